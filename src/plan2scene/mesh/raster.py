"""The renderer of previews: z-buffer of triangle ids, then attributes of all pixels at once.

Why not another one: it needs no display, GL or GPU (trimesh's and pyrender's viewers do) and no
extra (Mitsuba, the workshop's path tracer, takes an extra and a minute for such a picture), and
two textured views of a house take it a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from plan2scene.colour import srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.mesh.glb import GLASS
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.textures import UNTEXTURED, TileTexture


@dataclass(frozen=True)
class Camera:
    """A view: world-to-camera rotation (rows right, down, forward), and a projection.

    `scale` is pixels per metre of an orthographic view, or the focal length in pixels.
    """

    rotation: np.ndarray
    position: np.ndarray
    scale: float
    size: tuple[int, int]  # (height, width)
    perspective: bool

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return (..., 3) pixel x, pixel y, depth in metres of (..., 3) world points."""
        local = (points - self.position) @ self.rotation.T
        depth = local[..., 2]
        factor = self.scale / depth if self.perspective else np.full_like(depth, self.scale)
        height, width = self.size
        x = local[..., 0] * factor + (width - 1) / 2
        y = local[..., 1] * factor + (height - 1) / 2
        return np.stack([x, y, depth], axis=-1)


def look_at(
    eye: np.ndarray, target: np.ndarray, scale: float, size: tuple[int, int], *, perspective: bool
) -> Camera:
    """Return a camera at `eye` that looks at `target`; straight down, -z is up in the image."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    up = np.array([0.0, 0.0, -1.0]) if abs(forward[1]) > 0.999 else np.array([0.0, 1.0, 0.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    return Camera(np.array([right, down, forward]), eye, scale, size, perspective)


@dataclass
class Soup:
    """Triangles of many parts.

    Attributes
    ----------
    corners : (t, 3, 3) float64
        World metres.
    normals : (t, 3) float64
    uv : (t, 3, 2) float64
        In images, not metres.
    colours : (t, 3) float64
        Linear base colours.
    texture : (t,) int64
        Index into `mipmaps`, -1 for none.
    glass : (t,) bool
    """

    corners: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    colours: np.ndarray
    texture: np.ndarray
    glass: np.ndarray
    mipmaps: list[list[np.ndarray]] = field(default_factory=list)


def mipmaps(image: np.ndarray) -> list[np.ndarray]:
    """Return the linear float32 pyramid of a (h, w, 3) uint8 sRGB texture, halved by box filter."""
    levels: list[Any] = [srgb_to_linear(image).astype(np.float32)]
    while min(levels[-1].shape[:2]) > 1:
        top = levels[-1]
        top = top[: top.shape[0] // 2 * 2, : top.shape[1] // 2 * 2]
        levels.append((top[::2, ::2] + top[1::2, ::2] + top[::2, 1::2] + top[1::2, 1::2]) / 4)
    return levels


def soup_of(parts: Iterable[MeshPart], textures: Mapping[SurfaceKey, TileTexture]) -> Soup:
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
    return Soup(corners, normals, uv, colours, texture, glass, pyramids)


def _colours(part: MeshPart) -> np.ndarray:
    """Return the (m, 3) linear base colours of a part's faces when it has no texture."""
    if part.colours is not None:
        return srgb_to_linear(part.colours[part.mesh.faces[:, 0]])
    colour = np.array(GLASS[:3])
    if part.surface is not None:
        colour = srgb_to_linear(np.array(UNTEXTURED[part.surface.kind], np.uint8))
    return np.tile(colour, (len(part.mesh.faces), 1))


def texels_per_metre(soup: Soup) -> np.ndarray:
    """Return the (t,) texels per metre of each triangle, 0 without a texture."""
    sizes = np.array([*(levels[0].shape[1::-1] for levels in soup.mipmaps), (0, 0)])
    edge = np.linalg.norm(soup.corners[:, 1] - soup.corners[:, 0], axis=1)
    across = (soup.uv[:, 1] - soup.uv[:, 0]) * sizes[soup.texture]
    return np.linalg.norm(across, axis=1) / np.maximum(edge, 1e-9)


def visible(soup: Soup, camera: Camera, keep: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (h, w) int32 id of the nearest triangle (-1 none) and float32 depth, of those kept.

    Triangles that face away are left out, except glass, which has two sides. Triangles behind
    the camera are not clipped: the camera stands outside the house.
    """
    height, width = camera.size
    ids = np.full((height, width), -1, dtype=np.int32)
    depth = np.full((height, width), np.inf, dtype=np.float32)
    screen = camera.project(soup.corners)
    a, b, c = screen[:, 0, :2], screen[:, 1, :2], screen[:, 2, :2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    # y runs down: counter-clockwise in the world is a negative area on the screen.
    shown = keep & ((area < -1e-9) | (soup.glass & (np.abs(area) > 1e-9)))
    low = np.maximum(np.ceil(screen[:, :, :2].min(axis=1)), 0).astype(int)
    high = np.minimum(np.floor(screen[:, :, :2].max(axis=1)), [width - 1, height - 1]).astype(int)
    shown &= (high >= low).all(axis=1)
    affine = 1.0 / screen[..., 2] if camera.perspective else screen[..., 2]
    planes = screen_planes(screen, affine)
    for t in np.flatnonzero(shown):
        (x0, y0), (x1, y1) = low[t], high[t]
        x = np.arange(x0, x1 + 1, dtype=np.float32)
        y = np.arange(y0, y1 + 1, dtype=np.float32)[:, None]
        inside = _inside(screen[t], float(np.sign(area[t])), x, y)
        value = planes[t, 0] * x + planes[t, 1] * y + planes[t, 2]
        far = (1.0 / value if camera.perspective else value).astype(np.float32)
        window = depth[y0 : y1 + 1, x0 : x1 + 1]
        nearer = inside & (far < window)
        window[nearer] = far[nearer]
        ids[y0 : y1 + 1, x0 : x1 + 1][nearer] = t
    return ids, depth


def _inside(corners: np.ndarray, sign: float, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return which pixels of a grid lie in a screen triangle (edges included: no cracks)."""
    inside: np.ndarray | None = None
    for k in range(3):
        (px, py), (qx, qy) = corners[k, :2], corners[(k + 1) % 3, :2]
        slack = 0.01 * np.hypot(qx - px, qy - py)  # pixels; closes cracks by rounding
        edge = sign * ((qx - px) * (y - py) - (qy - py) * (x - px)) >= -slack
        inside = edge if inside is None else inside & edge
    return np.asarray(inside)


def screen_planes(screen: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return (t, 3) coefficients (gx, gy, g0) of values (t, 3) given at the screen corners."""
    a, b, c = screen[:, 0, :2], screen[:, 1, :2], screen[:, 2, :2]
    ab, ac = b - a, c - a
    det = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    det = np.where(np.abs(det) < 1e-12, np.inf, det)
    vb, vc = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    gx = (vb * ac[:, 1] - vc * ab[:, 1]) / det
    gy = (vc * ab[:, 0] - vb * ac[:, 0]) / det
    return np.stack([gx, gy, values[:, 0] - gx * a[:, 0] - gy * a[:, 1]], axis=1)


def attributes(soup: Soup, camera: Camera, ids: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return flat index, triangle id, world point (p, 3) and UV (p, 2) of each covered pixel."""
    pixels = np.flatnonzero(ids >= 0)
    t = ids.ravel()[pixels]
    y, x = (place.astype(np.float32) for place in np.divmod(pixels, ids.shape[1]))
    screen = camera.project(soup.corners)
    weight = 1.0 / screen[..., 2] if camera.perspective else np.ones(screen.shape[:2])

    def at(values: np.ndarray) -> np.ndarray:
        plane = screen_planes(screen, values).astype(np.float32)
        return plane[t, 0] * x + plane[t, 1] * y + plane[t, 2]

    w = at(weight)
    points = np.stack([at(soup.corners[..., k] * weight) / w for k in range(3)], axis=1)
    uv = np.stack([at(soup.uv[..., k] * weight) / w for k in range(2)], axis=1)
    return pixels, t, points, uv


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
    """Return (p, 3) colours of a repeating image between its texels (OpenCV: 1/32 texel)."""
    height, width = image.shape[:2]
    count, row = len(uv), 4096  # remap wants pictures, not rows of millions
    texel = np.zeros((-(-count // row) * row, 2), dtype=np.float32)
    texel[:count] = (uv - np.floor(uv)) * np.array([width, height], dtype=np.float32) - 0.5
    x, y = texel[:, 0].reshape(-1, row), texel[:, 1].reshape(-1, row)
    wrapped = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    return np.asarray(wrapped.reshape(-1, 3)[:count])
