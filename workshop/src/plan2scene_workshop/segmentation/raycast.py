"""A small ray caster for rooms of boxes, ellipsoids and cut-out cards, in NumPy.

It makes labelled pictures of endless variety at a fraction of a path tracer's cost; it is not
meant to look real. Lengths in metres, y up; colours are linear unless said otherwise. Light is
in ``segmentation_shading``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plan2scene_workshop.segmentation.bodies import Array, Body, Eye, Paint

_FAR = np.float32(1e6)
#: The axes (across, along) of the texture on a face, by the face's normal axis.
_FACE_AXES = ((2, 1), (0, 2), (0, 1))


def dot(a: Array, b: Array) -> Array:
    """Return the dot products of vectors (..., 3) without a temporary of their size."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def least(v: Array) -> Array:
    """Return the least of three components; faster than a reduction over so short an axis."""
    least: Array = np.minimum(np.minimum(v[..., 0], v[..., 1]), v[..., 2])
    return least


def _argmax(v: Array) -> tuple[Array, Array]:
    """Return the greatest of three components and which it is."""
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    axis = (y > x).astype(np.int8)
    top = np.maximum(x, y)
    third = z > top
    axis[third] = 2
    return np.maximum(top, z), axis


def _hit(body: Body, origin: Array, rays: Array) -> tuple[Array, Array]:
    """Return (distance, face 0..5) of each ray (..., 3) from `origin` (3,) or (..., 3).

    No hit is far away.
    """
    start = body.local(origin) / body.span
    way = (rays @ body.turn.T) / body.span
    if body.round:
        a, b = dot(way, way), dot(way, start)
        c = dot(start, start) - np.float32(1)
        root = b * b - a * c
        t = (-b - np.sqrt(np.maximum(root, 0))) / a
        return np.where((root > 0) & (t > 1e-3), t, _FAR), np.zeros(t.shape, np.int8)
    way = np.where(np.abs(way) < 1e-9, np.float32(1e-9), way)
    inverse = 1 / way
    middle, reach = -start * inverse, np.abs(inverse)
    if body.hollow:
        last, axis = _argmax(-(middle + reach))
        side = np.take_along_axis(way, axis[..., None].astype(np.intp), -1)[..., 0] > 0
        return -last, (2 * axis + side).astype(np.int8)
    enter, axis = _argmax(middle - reach)
    side = np.take_along_axis(way, axis[..., None].astype(np.intp), -1)[..., 0] < 0
    hit = (enter > 1e-3) & (enter < least(middle + reach))
    if body.stencil is not None:
        hit &= _kept(body.stencil, body.span, start + way * enter[..., None])
    return np.where(hit, enter, _FAR), (2 * axis + side).astype(np.int8)


def _kept(stencil: Array, span: Array, unit: Array) -> Array:
    """Return where points (..., 3) of a box, in halves of its size, are inside the stencil."""
    rows, columns = stencil.shape
    across, along = _FACE_AXES[int(span.argmin())]
    flip = -1 if along == 1 else 1
    u = np.clip((unit[..., across] + 1) * (columns / 2), 0, columns - 1).astype(np.intp)
    v = np.clip((flip * unit[..., along] + 1) * (rows / 2), 0, rows - 1).astype(np.intp)
    return np.asarray(stencil[v, u])


def _window(body: Body, eye: Eye) -> tuple[slice, slice] | None:
    """Return the pixels that a body can cover; None when it lies behind the camera."""
    height, width = eye.size
    if body.hollow:
        return slice(0, height), slice(0, width)
    corners = _CORNERS * body.span
    seen = (corners @ body.turn + body.centre - eye.position) @ eye.rotation.T
    if (seen[:, 2] < 0.05).all():
        return None
    # Outside one side of the view's pyramid, which holds for corners behind the camera too.
    side = np.abs(seen[:, :2]) * eye.focal_px > np.array([width, height]) / 2 * seen[:, 2:]
    if ((side & (seen[:, :2] > 0)).all(0) | (side & (seen[:, :2] < 0)).all(0)).any():
        return None
    if (seen[:, 2] < 0.05).any():
        return slice(0, height), slice(0, width)
    xy = seen[:, :2] / seen[:, 2:] * eye.focal_px + [(width - 1) / 2, (height - 1) / 2]
    low = np.floor(xy.min(0)).astype(int)
    high = np.ceil(xy.max(0)).astype(int) + 1
    rows = slice(max(0, min(height, low[1])), max(0, min(height, high[1])))
    columns = slice(max(0, min(width, low[0])), max(0, min(width, high[0])))
    return (rows, columns) if rows.start < rows.stop and columns.start < columns.stop else None


_CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T.astype(np.float32)


@dataclass(frozen=True, eq=False)
class Hits:
    """What each ray sees: index of the body, face, and distance along the ray, rays' shape."""

    body: Array
    face: Array
    distance: Array


def cast(bodies: list[Body], eye: Eye, rays: Array) -> Hits:
    """Return the nearest hit of every pixel's ray; the first body is the room."""
    hits = _nothing(eye.size)
    for k, body in enumerate(bodies):
        window = None if body.hollow and k else _window(body, eye)
        if window is not None:
            _nearer(hits, k, window, *_hit(body, eye.position, rays[window]))
    _enter(hits, bodies, np.broadcast_to(eye.position, rays.shape), rays)
    return hits


def cast_from(bodies: list[Body], origins: Array, rays: Array) -> Hits:
    """Return the nearest hit of rays (n, 3) that start at `origins` (n, 3)."""
    hits = _nothing((len(rays),))
    for k, body in enumerate(bodies):
        if not body.hollow or k == 0:
            _nearer(hits, k, (slice(None),), *_hit(body, origins, rays))
    _enter(hits, bodies, origins, rays)
    return hits


def _enter(hits: Hits, bodies: list[Body], origins: Array, rays: Array) -> None:
    """Let the rays that meet an opening go on to the inside of what lies beyond."""
    places = {id(body): k for k, body in enumerate(bodies)}
    for k, body in enumerate(bodies):
        if body.beyond is None:
            continue
        here = hits.body == k
        if here.any():
            t, side = _hit(body.beyond, origins[here], rays[here])
            hits.distance[here], hits.face[here] = t, side
            hits.body[here] = places[id(body.beyond)]


def _nothing(shape: tuple[int, ...]) -> Hits:
    return Hits(np.zeros(shape, np.int16), np.zeros(shape, np.int8), np.full(shape, _FAR))


def _nearer(hits: Hits, k: int, window: tuple[slice, ...], t: Array, side: Array) -> None:
    """Write the hits of body k that are nearer than those before into `hits`."""
    nearer = t < hits.distance[window]
    hits.distance[window][nearer] = t[nearer]
    hits.face[window][nearer] = side[nearer]
    hits.body[window][nearer] = k


def _seen_faces(hits: Hits) -> Iterator[tuple[int, int, Array]]:
    """Yield (body, face, flat pixel indices) of each visible face."""
    key = hits.body.ravel() * np.int16(8) + hits.face.ravel()
    order = np.argsort(key, kind="stable")
    values, starts = np.unique(key[order], return_index=True)
    for value, pixels in zip(values, np.split(order, starts[1:]), strict=True):
        yield int(value) // 8, int(value) % 8, pixels


def _texel(paint: Paint, uv: Array, footprint: Array) -> Array:
    """Return (n, 3) linear colours at positions in tiles; `footprint` is tiles per pixel."""
    base = paint.levels[0].shape[0]
    if base == 1:
        return np.broadcast_to(paint.levels[0][0, 0], (len(uv), 3))
    wanted = np.log2(np.maximum(footprint * base, 1))
    level = np.clip(np.round(wanted), 0, len(paint.levels) - 1).astype(np.int8)
    colours = np.empty((len(uv), 3), np.float32)
    for k in range(int(level.min()), int(level.max()) + 1):
        tile = paint.levels[k]
        chosen = np.flatnonzero(level == k)
        cell = np.floor(uv[chosen] * tile.shape[0]).astype(np.int32) % tile.shape[0]
        colours[chosen] = tile[cell[:, 1], cell[:, 0]]
    return colours


@dataclass(frozen=True, eq=False)
class Surfels:
    """What is seen, per ray (flat): point, normal, linear albedo, gloss, glow, mirror, label."""

    point: Array
    normal: Array
    albedo: Array
    gloss: Array
    glow: Array
    mirror: Array
    label: Array


def surfels(
    bodies: list[Body], eye: Eye, rays: Array, hits: Hits, origins: Array | None = None
) -> Surfels:
    """Return the surface that each ray sees; rays start at the eye unless `origins` are given."""
    flat = rays.reshape(-1, 3)
    distance = hits.distance.reshape(-1, 1)
    start = (eye.position if origins is None else origins).astype(np.float32)
    point = start + flat * distance
    normal, albedo = np.zeros_like(point), np.zeros_like(point)
    gloss, glow, mirror = np.zeros((3, len(point)), np.float32)
    label = np.zeros(len(point), np.uint8)
    for k, side, pixels in _seen_faces(hits):
        body = bodies[k]
        paint = body.paints[side if len(body.paints) > 1 else 0]
        n, uv = _on_face(body, side, body.local(point[pixels]), paint.size_m)
        normal[pixels] = n @ body.turn
        facing = np.abs(dot(normal[pixels], flat[pixels]))
        facing /= np.sqrt(dot(flat[pixels], flat[pixels]))
        metres = distance[pixels, 0] / np.float32(eye.focal_px) / np.sqrt(np.maximum(facing, 0.05))
        tile = paint.size_m or 2 * float(np.median(body.half))
        albedo[pixels] = _texel(paint, uv, metres / np.float32(tile))
        gloss[pixels], glow[pixels], mirror[pixels] = paint.gloss, body.glow, body.mirror
        label[pixels] = body.labels[side if len(body.labels) > 1 else 0]
    return Surfels(point, normal, albedo, gloss, glow, mirror, label)


def _on_face(body: Body, side: int, local: Array, size_m: float) -> tuple[Array, Array]:
    """Return (normal, position in tiles) of points (n, 3) on a face, in the body's frame."""
    if body.round:
        n = local / body.span**2
        n /= np.sqrt(dot(n, n))[:, None]
        return n, (local[:, [0, 1]] + local[:, [2, 2]]) / np.float32(size_m or 1)
    axis, sign = side // 2, (1 if side % 2 else -1) * (-1 if body.hollow else 1)
    n = np.zeros_like(local)
    n[:, axis] = sign
    axes = list(_FACE_AXES[axis])
    if size_m:
        return n, local[:, axes] / np.float32(size_m)
    uv = (local[:, axes] / body.span[axes] + 1) * np.float32(0.4999)
    if axes[1] == 1:
        uv[:, 1] = np.float32(0.9999) - uv[:, 1]
    return n, uv
