"""A small ray caster for rooms of boxes and ellipsoids, in NumPy.

It makes labelled pictures of endless variety at a fraction of a path tracer's cost; it is not
meant to look real. Lengths in metres, y up; colours are linear unless said otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

Array = np.ndarray
_FAR = np.float32(1e6)


@dataclass(frozen=True, eq=False)
class Paint:
    """Colour of a thing: a tile that repeats, in several resolutions, or a plain colour.

    Attributes
    ----------
    levels : tuple of (n, n, 3) float32 linear
        Each half the size of the one before; the last is 1x1.
    size_m : float
        Metres that a tile covers.
    gloss : float
        Strength of highlights, 0 matt.
    """

    levels: tuple[Array, ...]
    size_m: float = 1.0
    gloss: float = 0.0


def plain(colour: Array, gloss: float = 0.0) -> Paint:
    """Return a paint of one linear colour."""
    return Paint((np.asarray(colour, np.float32).reshape(1, 1, 3),), 1.0, gloss)


def tiled(albedo: Array, size_m: float, gloss: float = 0.0) -> Paint:
    """Return a paint of a (n, n, 3) uint8 sRGB tile."""
    level = (albedo.astype(np.float32) / 255) ** np.float32(2.2)
    levels = [level]
    while level.shape[0] > 1:
        side = max(1, level.shape[0] // 2)
        level = cv2.resize(level, (side, side), interpolation=cv2.INTER_AREA)
        levels.append(level)
    return Paint(tuple(levels), size_m, gloss)


@dataclass(frozen=True, eq=False)
class Body:
    """A box or an ellipsoid, turned about the vertical; `hollow` is the room, seen from inside.

    `paints` has one entry, or six: -x, +x, -y, +y, -z, +z faces as seen from outside. `labels`
    likewise.
    """

    centre: Array
    half: Array
    yaw: float
    labels: tuple[int, ...]
    paints: tuple[Paint, ...]
    round: bool = False
    hollow: bool = False
    glow: float = 0.0


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light that reaches from a point with some size."""

    position: Array
    colour: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Eye:
    """A pinhole camera: `rotation` takes world to camera (x right, y down, z forward)."""

    position: Array
    rotation: Array
    focal_px: float
    size: tuple[int, int]

    def rays(self) -> Array:
        """Return (h, w, 3) float32 directions in the world, depth 1 along the view."""
        height, width = self.size
        rows, columns = np.mgrid[:height, :width].astype(np.float32)
        camera = np.stack(
            [
                (columns - (width - 1) / 2) / self.focal_px,
                (rows - (height - 1) / 2) / self.focal_px,
                np.ones_like(rows),
            ],
            axis=-1,
        )
        return (camera @ self.rotation).astype(np.float32)


def _turned(vectors: Array, yaw: float) -> Array:
    """Return vectors (..., 3) in a frame turned by `yaw` about y."""
    cos, sin = np.float32(np.cos(yaw)), np.float32(np.sin(yaw))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.stack([cos * x - sin * z, y, sin * x + cos * z], axis=-1)


def _least(v: Array) -> Array:
    """Return the least of three components; faster than a reduction over so short an axis."""
    least: Array = np.minimum(np.minimum(v[..., 0], v[..., 1]), v[..., 2])
    return least


def _hit(body: Body, origin: Array, rays: Array) -> tuple[Array, Array]:
    """Return (distance, face 0..5) of each ray (..., 3); no hit is far away."""
    start = _turned((origin - body.centre).astype(np.float32), body.yaw) / body.half
    way = _turned(rays, body.yaw) / body.half.astype(np.float32)
    if body.round:
        a = (way * way).sum(-1)
        b = (way * start).sum(-1)
        c = (start * start).sum(-1) - 1
        root = b * b - a * c
        t = (-b - np.sqrt(np.maximum(root, 0))) / a
        return np.where((root > 0) & (t > 1e-3), t, _FAR), np.zeros(t.shape, np.int8)
    way = np.where(np.abs(way) < 1e-9, np.float32(1e-9), way)
    first = (-np.sign(way) - start) / way
    last = (np.sign(way) - start) / way
    if body.hollow:
        axis = last.argmin(-1)
        t = np.take_along_axis(last, axis[..., None], -1)[..., 0]
        side = np.take_along_axis(way, axis[..., None], -1)[..., 0] > 0
        return t, (2 * axis + side).astype(np.int8)
    axis = first.argmax(-1)
    enter = np.take_along_axis(first, axis[..., None], -1)[..., 0]
    side = np.take_along_axis(way, axis[..., None], -1)[..., 0] < 0
    hit = (enter > 1e-3) & (enter < _least(last))
    return np.where(hit, enter, _FAR), (2 * axis + side).astype(np.int8)


def _window(body: Body, eye: Eye) -> tuple[slice, slice] | None:
    """Return the pixels that a body can cover; None when it lies behind the camera."""
    height, width = eye.size
    if body.hollow:
        return slice(0, height), slice(0, width)
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T * body.half
    seen = (_turned(corners, -body.yaw) + body.centre - eye.position) @ eye.rotation.T
    if (seen[:, 2] < 0.05).all():
        return None
    if (seen[:, 2] < 0.05).any():
        return slice(0, height), slice(0, width)
    xy = seen[:, :2] / seen[:, 2:] * eye.focal_px + [(width - 1) / 2, (height - 1) / 2]
    low = np.floor(xy.min(0)).astype(int)
    high = np.ceil(xy.max(0)).astype(int) + 1
    rows = slice(int(np.clip(low[1], 0, height)), int(np.clip(high[1], 0, height)))
    columns = slice(int(np.clip(low[0], 0, width)), int(np.clip(high[0], 0, width)))
    return (rows, columns) if rows.start < rows.stop and columns.start < columns.stop else None


@dataclass(frozen=True, eq=False)
class Hits:
    """What each pixel sees: (h, w) index of the body, face, and distance along the ray."""

    body: Array
    face: Array
    distance: Array


def cast(bodies: list[Body], eye: Eye, rays: Array) -> Hits:
    """Return the nearest hit of every pixel's ray."""
    index = np.zeros(eye.size, np.int16)
    face = np.zeros(eye.size, np.int8)
    distance = np.full(eye.size, _FAR)
    for k, body in enumerate(bodies):
        window = _window(body, eye)
        if window is None:
            continue
        t, side = _hit(body, eye.position, rays[window])
        nearer = t < distance[window]
        distance[window][nearer] = t[nearer]
        face[window][nearer] = side[nearer]
        index[window][nearer] = k
    return Hits(index, face, distance)


def _seen_faces(hits: Hits) -> Iterator[tuple[int, int, Array]]:
    """Yield (body, face, flat pixel indices) of each visible face."""
    key = hits.body.ravel().astype(np.int32) * 8 + hits.face.ravel()
    order = np.argsort(key, kind="stable")
    values, starts = np.unique(key[order], return_index=True)
    for value, pixels in zip(values, np.split(order, starts[1:]), strict=True):
        yield int(value) // 8, int(value) % 8, pixels


def _texel(paint: Paint, uv: Array, footprint: Array) -> Array:
    """Return (n, 3) linear colours at metric positions; `footprint` is metres per pixel."""
    base = paint.levels[0].shape[0]
    wanted = np.log2(np.maximum(footprint / paint.size_m * base, 1))
    level = np.clip(np.round(wanted), 0, len(paint.levels) - 1).astype(int)
    colours = np.empty((len(uv), 3), np.float32)
    for k in np.unique(level):
        tile = paint.levels[k]
        chosen = level == k
        cell = np.floor(uv[chosen] / paint.size_m * tile.shape[0]).astype(int) % tile.shape[0]
        colours[chosen] = tile[cell[:, 1], cell[:, 0]]
    return colours


@dataclass(frozen=True, eq=False)
class Surfels:
    """What is seen, per pixel (flat): point, normal, linear albedo, gloss, glow, label."""

    point: Array
    normal: Array
    albedo: Array
    gloss: Array
    glow: Array
    label: Array


def surfels(bodies: list[Body], eye: Eye, rays: Array, hits: Hits) -> Surfels:
    """Return the surface seen by each pixel."""
    flat = rays.reshape(-1, 3)
    distance = hits.distance.reshape(-1, 1)
    point = (eye.position + flat * distance).astype(np.float32)
    normal = np.zeros_like(point)
    albedo = np.zeros_like(point)
    gloss, glow = np.zeros(len(point), np.float32), np.zeros(len(point), np.float32)
    label = np.zeros(len(point), np.uint8)
    for k, side, pixels in _seen_faces(hits):
        body = bodies[k]
        local = _turned(point[pixels] - body.centre, body.yaw)
        if body.round:
            n = local / body.half**2
            uv = local[:, [0, 1]] + local[:, [2, 2]]
            n = n / np.linalg.norm(n, axis=1, keepdims=True)
        else:
            axis, sign = side // 2, (1 if side % 2 else -1) * (-1 if body.hollow else 1)
            n = np.zeros_like(local)
            n[:, axis] = sign
            uv = local[:, [(2, 1), (0, 2), (0, 1)][axis]]
        normal[pixels] = _turned(n, -body.yaw)
        paint = body.paints[side if len(body.paints) > 1 else 0]
        facing = np.abs((normal[pixels] * flat[pixels]).sum(1)) / np.linalg.norm(
            flat[pixels], axis=1
        )
        footprint = distance[pixels, 0] / eye.focal_px / np.sqrt(np.maximum(facing, 0.05))
        albedo[pixels] = _texel(paint, uv, footprint)
        gloss[pixels], glow[pixels] = paint.gloss, body.glow
        label[pixels] = body.labels[side if len(body.labels) > 1 else 0]
    return Surfels(point, normal, albedo, gloss, glow, label)


def shadow(
    bodies: list[Body], seen: Surfels, eye: Eye, lamp: Lamp, rng: np.random.Generator
) -> Array:
    """Return (h, w) float32 share of a lamp's light that arrives, soft by its size.

    Cast on a grid of every fourth pixel with a jittered lamp, then blurred.
    """
    height, width = eye.size
    points = seen.point.reshape(height, width, 3)[::4, ::4]
    normals = seen.normal.reshape(height, width, 3)[::4, ::4]
    aim = lamp.position + rng.normal(0, lamp.radius / 2, points.shape).astype(np.float32)
    start = (points + 0.02 * normals).astype(np.float32)
    way = (aim - start).astype(np.float32)
    lit = np.ones(points.shape[:2], np.float32)
    for body in bodies:
        if body.hollow or body.glow > 0 or max(body.half) < 0.06:
            continue
        lit[_blocked(body, start, way)] = 0
    lit = cv2.blur(lit, (3, 3))
    return cv2.resize(lit, (width, height), interpolation=cv2.INTER_LINEAR)


def _blocked(body: Body, start: Array, way: Array) -> Array:
    """Return where a body lies between `start` and `start + way` (...)."""
    half = body.half.astype(np.float32)
    a = _turned(start - body.centre.astype(np.float32), body.yaw) / half
    b = _turned(way, body.yaw) / half
    if body.round:
        t = np.clip(-(a * b).sum(-1) / np.maximum((b * b).sum(-1), 1e-9), 0, 1)
        return ((a + t[..., None] * b) ** 2).sum(-1) < 1
    b = np.where(np.abs(b) < 1e-9, np.float32(1e-9), b)
    sign = np.sign(b)
    first = -_least((sign + a) / b)
    last = _least((sign - a) / b)
    return (first < last) & (last > 0.001) & (first < 0.98)


def shade(
    bodies: list[Body],
    seen: Surfels,
    eye: Eye,
    lamps: list[Lamp],
    ambient: Array,
    rng: np.random.Generator,
) -> Array:
    """Return the (h, w, 3) float32 linear picture: lamps, highlights, light from all around."""
    height, width = eye.size
    room = bodies[0]
    view = eye.position - seen.point
    view = view / np.linalg.norm(view, axis=1, keepdims=True)
    corner = np.sort(room.half - np.abs(seen.point - room.centre), axis=1)
    # A surface of the room has distance 0 to itself; the next two are its neighbours.
    near = np.clip(corner[:, 1:], 0, None)
    occlusion = (1 - 0.35 * np.exp(-near / 0.35)).prod(axis=1)
    light = ambient * (occlusion * (0.85 + 0.15 * seen.normal[:, 1]))[:, None]
    shine = np.zeros_like(light)
    for lamp in lamps:
        to = lamp.position - seen.point
        square = (to * to).sum(1)
        to = to / np.sqrt(square)[:, None]
        arrives = shadow(bodies, seen, eye, lamp, rng).ravel() / (square + 0.15)
        light += (np.maximum((seen.normal * to).sum(1), 0) * arrives)[:, None] * lamp.colour
        halfway = to + view
        halfway /= np.linalg.norm(halfway, axis=1, keepdims=True)
        peak = np.maximum((seen.normal * halfway).sum(1), 0) ** 60
        shine += (peak * arrives * seen.gloss * 4)[:, None] * lamp.colour
    picture = seen.albedo * (light + seen.glow[:, None]) + shine
    return picture.reshape(height, width, 3).astype(np.float32)
