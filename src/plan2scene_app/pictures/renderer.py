"""Software renderer of houses: it finds each pixel's nearest triangle, then the surface's colour.

The package has its own renderer because it must run wherever the package runs: OpenGL renderers
need a display or a driver, and Embree (:mod:`plan2scene.mesh.rays`) has no wheel for Linux on ARM.
A pixel's triangle is found by homogeneous edge functions (Olano and Greer 1997), which need no
clipping at the camera.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from plan2scene.camera import Camera, as_rows
from plan2scene.colour import srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.mesh.parts import GLASS, MeshPart
from plan2scene.mesh.texture_files import UNTEXTURED, TileTexture

#: Near plane of a pinhole camera, metres: nothing nearer is drawn.
NEAR_M = 0.02
#: Triangles are enlarged at their edges by this, pixels, so that rounding leaves no cracks.
_SLACK_PX = 0.01
#: Lower bound of the cosine between ray and normal in the choice of mipmap level (limits blur).
_LEAST_FACING = 0.05


def look_at(
    eye: np.ndarray,
    target: np.ndarray,
    focal_px: float,
    size: tuple[int, int],
    *,
    orthographic: bool = False,
) -> Camera:
    """Return a camera without roll at `eye` that looks at `target`, world points (3,).

    `size` is (height, width). If the camera looks straight down or up, -z is up in the image.
    """
    ahead = (target - eye) / np.linalg.norm(target - eye)
    up = np.array([0.0, 0.0, -1.0]) if abs(ahead[1]) > 0.999 else np.array([0.0, 1.0, 0.0])
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    height, width = size
    return Camera(
        width,
        height,
        float(focal_px),
        (width - 1) / 2,
        (height - 1) / 2,
        as_rows(np.array([right, np.cross(ahead, right), ahead])),
        position=(float(eye[0]), float(eye[1]), float(eye[2])),
        orthographic=orthographic,
    )


@dataclass
class Fragments:
    """The visible surface at p pixels of a picture.

    Attributes
    ----------
    pixels : (p,) int64
        Indices into the flattened picture, ascending.
    triangles : (p,) int32
        The nearest triangle.
    weights : (3, p) float32
        Barycentric weights of its corners.
    depth : (p,) float32
        Metres along the camera's axis.
    points : (p, 3) float32
        The visible point, world metres.
    """

    pixels: np.ndarray
    triangles: np.ndarray
    weights: np.ndarray
    depth: np.ndarray
    points: np.ndarray

    def at(self, values: np.ndarray) -> np.ndarray:
        """Interpolate values at the corners of all triangles, (t, 3, c), to (p, c) float32."""
        corners = np.ascontiguousarray(values.transpose(1, 2, 0), dtype=np.float32)
        made = np.zeros((len(self.triangles), values.shape[2]), np.float32)
        for weight, corner in zip(self.weights, corners, strict=True):
            for k, value in enumerate(corner):
                made[:, k] += weight * np.take(value, self.triangles)
        return made


@dataclass
class Triangles:
    """Triangles of many parts.

    Attributes
    ----------
    corners : (t, 3, 3) float64
        World metres.
    normals : (t, 3) float64
    uv : (t, 3, 2) float64
        Texture coordinates in multiples of the image, not metres.
    colours : (t, 3) float64
        Linear base colours.
    texture : (t,) int64
        Index into `mipmaps`, -1 for none.
    glass : (t,) bool
    mipmaps : list of list of (h, w, 3) float32
        Linear pyramids of the textures.
    """

    corners: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    colours: np.ndarray
    texture: np.ndarray
    glass: np.ndarray
    mipmaps: list[list[np.ndarray]] = field(default_factory=list)

    @classmethod
    def of(cls, parts: Iterable[MeshPart], textures: Mapping[SurfaceKey, TileTexture]) -> Triangles:
        """Return the triangles of parts with their textures decoded."""
        numbers: dict[str, int] = {}
        pyramids: list[list[np.ndarray]] = []
        rows = []
        for part in parts:
            faces = part.mesh.faces
            tile = None if part.surface is None else textures.get(part.surface)
            number, uv = -1, np.zeros((len(faces), 3, 2))
            if tile is not None and part.uv is not None:
                number = numbers.setdefault(tile.digest, len(numbers))
                if number == len(pyramids):
                    pyramids.append(mipmaps(image_from_bytes(tile.image)))
                uv = tile.turns(part.uv)[faces]
            normals = part.mesh.vertex_normals[faces[:, 0]]
            kind = np.full(len(faces), number), np.full(len(faces), part.material == "glass")
            rows.append((part.mesh.triangles, normals, uv, _colours(part), *kind))
        corners, normals, uv, colours, texture, glass = map(np.concatenate, zip(*rows, strict=True))
        return cls(corners, normals, uv, colours, texture, glass, pyramids)

    def visible(self, camera: Camera, keep: np.ndarray) -> Fragments:
        """Return a camera's fragments; `keep` (t,) bool selects the triangles that are drawn.

        Triangles that face away are left out, except glass, which is visible from both sides.
        """
        in_camera = camera.seen(self.corners)
        ahead = np.ones(in_camera.shape[:2]) if camera.orthographic else in_camera[..., 2]
        x, y = (
            camera.focal_px * in_camera[..., k] + c * ahead
            for k, c in ((0, camera.cx), (1, camera.cy))
        )
        plane = np.stack([x, y, ahead], axis=2)  # homogeneous pixels: (x w, y w, w)
        a, b, c = plane[:, 0], plane[:, 1], plane[:, 2]
        # y runs down: counter-clockwise in the world is a negative volume.
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        drawn = keep & ((volume < -1e-9) | (self.glass & (np.abs(volume) > 1e-9)))
        low, high = _boxes(plane, (camera.width, camera.height))
        drawn &= (high >= low).all(axis=1)
        # Column k of a triangle's matrix: corner k's weight over w, linear in the pixel.
        edges = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=2)
        edges /= np.where(drawn, volume, 1.0)[:, None, None]
        # The nearest triangle has the largest 1 / w, or the least depth.
        closeness = edges.sum(axis=2)
        if camera.orthographic:
            closeness = -np.einsum("tck,tk->tc", edges, in_camera[..., 2])
        ids, depth = _nearest(edges, closeness, np.flatnonzero(drawn), low, high, camera)
        pixels = np.flatnonzero(ids >= 0)
        t = ids.ravel()[pixels]
        y, x = np.divmod(pixels, camera.width)
        weights = np.empty((3, len(t)), np.float32)
        for k in range(3):
            along, down, first = (np.take(edges[:, n, k], t) for n in range(3))
            weights[k] = along * x + down * y + first
        weights /= weights.sum(axis=0)
        metres = depth.ravel()[pixels]
        return Fragments(pixels, t, weights, metres, _points(camera, x, y, metres))

    def looks(self, camera: Camera, fragments: Fragments) -> np.ndarray:
        """Return the (p, 3) float32 linear colours of surfaces, without light."""
        t = fragments.triangles
        colour = self.colours.astype(np.float32)[t]
        footprint = np.take(self._texels_per_metre() / np.float32(camera.focal_px), t)
        if camera.orthographic:
            facing = np.abs(self.normals @ camera.matrix[2])[t]
        else:
            footprint *= fragments.depth
            away = self.corners[:, 0] - np.array(camera.position)
            facing = np.abs(np.einsum("ij,ij->i", away, self.normals)).astype(np.float32)[t]
            eye = np.array(camera.position, np.float32)
            facing /= np.linalg.norm(fragments.points - eye, axis=1)
        footprint /= np.sqrt(np.maximum(facing, _LEAST_FACING))
        uv = fragments.at(self.uv)
        texture = self.texture[t]
        order = np.argsort(texture, kind="stable")
        ends = np.cumsum(np.bincount(texture + 1, minlength=len(self.mipmaps) + 1))
        for levels, start, end in zip(self.mipmaps, ends[:-1], ends[1:], strict=True):
            group = order[start:end]
            colour[group] = sample(levels, uv[group], footprint[group])
        return colour

    def _texels_per_metre(self) -> np.ndarray:
        """Return the (t,) float32 texels per metre of each triangle, 0 without a texture."""
        sizes = np.array([*(levels[0].shape[1::-1] for levels in self.mipmaps), (0, 0)])
        edge = np.linalg.norm(self.corners[:, 1] - self.corners[:, 0], axis=1)
        across = (self.uv[:, 1] - self.uv[:, 0]) * sizes[self.texture]
        return (np.linalg.norm(across, axis=1) / np.maximum(edge, 1e-9)).astype(np.float32)


def _points(camera: Camera, x: np.ndarray, y: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Return the world points (p, 3) float32 of pixels at depths, (p,) each."""
    scale = np.float32(1 / camera.focal_px) * (1 if camera.orthographic else depth)
    local = np.stack([(x - camera.cx) * scale, (y - camera.cy) * scale, depth], axis=1)
    points = local.astype(np.float32) @ camera.matrix.astype(np.float32)
    return np.asarray(points + np.array(camera.position, np.float32))


def _boxes(plane: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the boxes, low and high pixel (t, 2), of triangles (t, 3, 3) in homogeneous pixels.

    Only what lies in front of the near plane counts; `size` is (width, height). Low is above high
    for a triangle that is not visible at all.
    """
    following = np.roll(plane, -1, axis=1)
    near, beyond = plane[..., 2] >= NEAR_M, following[..., 2] >= NEAR_M
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (NEAR_M - plane[..., 2]) / (following[..., 2] - plane[..., 2])
        cut = plane + share[..., None] * (following - plane)
        points = np.concatenate([plane, cut], axis=1)
        flat = points[..., :2] / points[..., 2:]
    valid = np.concatenate([near, near != beyond], axis=1)[..., None]
    low = np.where(valid, flat, np.inf).min(axis=1)
    high = np.where(valid, flat, -np.inf).max(axis=1)
    limits = np.array(size) - 1
    low = np.ceil(np.clip(low - _SLACK_PX, 0, limits + 1))
    return low.astype(int), np.floor(np.clip(high + _SLACK_PX, -1, limits)).astype(int)


def _nearest(
    edges: np.ndarray,
    closeness: np.ndarray,
    drawn: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    camera: Camera,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the nearest of the drawn triangles, (h, w) int32, -1 for none, and its depth."""
    ids = np.full((camera.height, camera.width), -1, dtype=np.int32)
    best = np.full(ids.shape, -np.inf, dtype=np.float32)
    slack = -_SLACK_PX * np.hypot(edges[:, 0], edges[:, 1])
    limit = np.inf if camera.orthographic else 1 / NEAR_M
    for t in drawn:
        (x0, y0), (x1, y1) = low[t], high[t]
        x = np.arange(x0, x1 + 1)
        y = np.arange(y0, y1 + 1)[:, None]
        value = closeness[t, 0] * x + (closeness[t, 1] * y + closeness[t, 2])
        window = best[y0 : y1 + 1, x0 : x1 + 1]
        nearer = (value > window) & (value < limit)
        for k in range(3):
            nearer &= edges[t, 0, k] * x + (edges[t, 1, k] * y + edges[t, 2, k]) >= slack[t, k]
        window[nearer] = value[nearer]
        ids[y0 : y1 + 1, x0 : x1 + 1][nearer] = t
    return ids, -best if camera.orthographic else 1 / best


def mipmaps(image: np.ndarray) -> list[np.ndarray]:
    """Return the linear float32 pyramid of a (h, w, 3) uint8 sRGB texture, halved by box filter."""
    levels: list[Any] = [srgb_to_linear(image).astype(np.float32)]
    while min(levels[-1].shape[:2]) > 1:
        top = levels[-1]
        top = top[: top.shape[0] // 2 * 2, : top.shape[1] // 2 * 2]
        levels.append((top[::2, ::2] + top[1::2, ::2] + top[::2, 1::2] + top[1::2, 1::2]) / 4)
    return levels


def _colours(part: MeshPart) -> np.ndarray:
    """Return the (m, 3) linear base colours of a part's faces when it has no texture."""
    if part.colours is not None:
        return srgb_to_linear(part.colours[part.mesh.faces[:, 0]])
    colour = np.array(GLASS[:3])
    if part.surface is not None:
        colour = srgb_to_linear(np.array(UNTEXTURED[part.surface.kind], np.uint8))
    return np.tile(colour, (len(part.mesh.faces), 1))


def sample(levels: list[np.ndarray], uv: np.ndarray, footprint: np.ndarray) -> np.ndarray:
    """Return (p, 3) linear colours by trilinear lookup; `footprint` is texels per pixel."""
    level = np.clip(np.log2(np.maximum(footprint, 1e-6)), 0, len(levels) - 1)
    low = np.floor(level).astype(int)
    share = (level - low).astype(np.float32)[:, None]
    result = np.zeros((len(uv), 3), dtype=np.float32)
    for number in np.flatnonzero(np.bincount(low)):
        mine = low == number
        colour = _bilinear(levels[number], uv[mine])
        if number + 1 < len(levels):
            colour += share[mine] * (_bilinear(levels[number + 1], uv[mine]) - colour)
        result[mine] = colour
    return result


def _bilinear(image: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return (p, 3) colours of a repeating image, bilinear (OpenCV: in steps of 1/32 texel)."""
    height, width = image.shape[:2]
    count, row = len(uv), 4096  # cv2.remap limits the width of an image
    texel = np.zeros((-(-count // row) * row, 2), dtype=np.float32)
    texel[:count] = (uv - np.floor(uv)) * np.array([width, height], dtype=np.float32) - 0.5
    x, y = texel[:, 0].reshape(-1, row), texel[:, 1].reshape(-1, row)
    wrapped = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return np.asarray(wrapped.reshape(-1, 3)[:count])
