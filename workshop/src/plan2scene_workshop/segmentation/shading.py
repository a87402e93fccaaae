"""Light in a room of boxes: lamps with soft shadows, sun through windows, mirrors and gloss."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.photos.labels.palette import OTHER
from plan2scene_workshop.segmentation.bodies import (
    Array,
    Body,
    Eye,
    Lamp,
)
from plan2scene_workshop.segmentation.raycast import (
    Surfels,
    cast_from,
    dot,
    least,
    surfels,
)


@dataclass(frozen=True, eq=False)
class Sun:
    """Direct sunlight through windows.

    Attributes
    ----------
    towards : (3,) float
        Direction from the room to the sun.
    colour : (3,) linear
    panes : tuple of Body
        Thin boxes; light falls in where a ray to the sun passes one of them.
    """

    towards: Array
    colour: Array
    panes: tuple[Body, ...]


def _blocked(body: Body, start: Array, way: Array) -> Array:
    """Return where a body lies between `start` and `start + way` (..., 3)."""
    a = body.local(start) / body.span
    b = (way @ body.turn.T) / body.span
    if body.round:
        t = np.clip(-dot(a, b) / np.maximum(dot(b, b), 1e-9), 0, 1)
        near = a + t[..., None] * b
        return dot(near, near) < 1
    inverse = 1 / np.where(np.abs(b) < 1e-9, np.float32(1e-9), b)
    middle, reach = -a * inverse, np.abs(inverse)
    first = -least(reach - middle)
    last = least(middle + reach)
    return np.asarray((first < last) & (last > 0.001) & (first < 0.98))


def _casts(body: Body) -> bool:
    """Return whether a body's shadow is worth its cost."""
    size = np.sort(body.half)
    return not body.hollow and body.glow == 0 and size[1] > 0.05 and size[2] > 0.1


def shadow(
    bodies: list[Body], seen: Surfels, eye: Eye, lamp: Lamp, rng: np.random.Generator
) -> Array:
    """Return (h, w) float32 share of a lamp's light that arrives, soft by its size.

    Cast on a grid of every fourth pixel towards nine places on the lamp in turn, then averaged
    over blocks of nine.
    """
    height, width = eye.size
    points = seen.point.reshape(height, width, 3)[::4, ::4]
    normals = seen.normal.reshape(height, width, 3)[::4, ::4]
    rows, columns = points.shape[:2]
    places = rng.normal(0, lamp.radius / 2, (3, 3, 3)).astype(np.float32)
    jitter = np.tile(places, (rows // 3 + 1, columns // 3 + 1, 1))[:rows, :columns]
    start = points + np.float32(0.02) * normals
    way = lamp.position.astype(np.float32) + jitter - start
    flat_start, flat_way = start.reshape(-1, 3), way.reshape(-1, 3)
    lit = np.ones(len(flat_start), np.float32)
    left = np.flatnonzero(dot(flat_way, normals.reshape(-1, 3)) > 0)
    for body in bodies:
        if not _casts(body):
            continue
        gone = _blocked(body, flat_start[left], flat_way[left])
        if body.stencil is not None:
            lit[left[gone]] *= 0.6
            continue
        lit[left[gone]] = 0
        left = left[~gone]
    grid = cv2.blur(lit.reshape(points.shape[:2]), (3, 3))
    return np.asarray(cv2.resize(grid, (width, height), interpolation=cv2.INTER_LINEAR))


def contact(bodies: list[Body], seen: Surfels, eye: Eye) -> Array:
    """Return (n,) float32 share of the light from all around that things let through to the room.

    Floors and walls darken towards what stands on or against them; found for every fourth pixel.
    """
    height, width = eye.size
    grid = seen.point.reshape(height, width, 3)[::4, ::4]
    points = grid.reshape(-1, 3)
    share = np.ones(len(points), np.float32)
    for body in bodies:
        if not _casts(body) or body.stencil is not None or body.labels != (OTHER,):
            continue
        apart = points - body.centre.astype(np.float32)
        reach = np.float32((np.linalg.norm(body.half) + 0.5) ** 2)
        near = np.flatnonzero(dot(apart, apart) < reach)
        if len(near):
            out = np.maximum(np.abs(apart[near] @ body.turn.T) - body.span, 0)
            share[near] *= 1 - 0.35 * np.exp(np.sqrt(dot(out, out)) / np.float32(-0.12))
    small = cv2.blur(np.maximum(share, 0.25).reshape(grid.shape[:2]), (3, 3))
    full = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR).ravel()
    return np.where(seen.label == OTHER, 1, full).astype(np.float32)


def sunlight(bodies: list[Body], seen: Surfels, sun: Sun) -> Array:
    """Return (n,) float32: the sun's light on each pixel, hard-edged."""
    light = np.zeros(len(seen.point), np.float32)
    towards = (sun.towards / np.linalg.norm(sun.towards)).astype(np.float32)
    facing = seen.normal @ towards
    way = towards * np.float32(30)
    left = np.flatnonzero((facing > 0) & (seen.glow == 0))
    inside = np.zeros(len(left), bool)
    start = seen.point[left] + np.float32(0.01) * seen.normal[left]
    ways = np.broadcast_to(way, start.shape)
    for pane in sun.panes:
        inside |= _blocked(pane, start, ways)
    left, start = left[inside], start[inside]
    for body in bodies:
        if not len(left):
            break
        if body.hollow or body.glow > 0 or body.stencil is not None:
            continue
        free = ~_blocked(body, start, np.broadcast_to(way, start.shape))
        left, start = left[free], start[free]
    light[left] = facing[left]
    return light


def _reflected(bodies: list[Body], seen: Surfels, eye: Eye, ambient: Array, pixels: Array) -> Array:
    """Return (n, 3) light that comes to pixels from what lies in the mirror direction."""
    view = seen.point[pixels] - eye.position.astype(np.float32)
    normal = seen.normal[pixels]
    rays = view - 2 * dot(view, normal)[:, None] * normal
    rays /= np.sqrt(dot(rays, rays))[:, None]
    origins = seen.point[pixels] + np.float32(0.01) * normal
    there = surfels(bodies, eye, rays, cast_from(bodies, origins, rays), origins)
    shaded = 0.8 + 0.2 * there.normal[:, 1]
    return np.asarray(there.albedo * (ambient * shaded[:, None] + there.glow[:, None]))


def reflections(bodies: list[Body], seen: Surfels, eye: Eye, ambient: Array) -> tuple[Array, Array]:
    """Return (share of mirrored light (n, 1), mirrored light (n, 3)) of every pixel.

    Cast for every second pixel of each direction, then enlarged.
    """
    height, width = eye.size
    share = seen.mirror.copy()
    picture = np.zeros((height, width, 3), np.float32)
    rows, columns = (height + 1) // 2, (width + 1) // 2
    coarse = np.zeros((rows, columns, 3), np.float32)
    grid = np.arange(height * width).reshape(height, width)[::2, ::2]
    chosen = share.reshape(height, width)[::2, ::2] > 0
    if chosen.any():
        coarse[chosen] = _reflected(bodies, seen, eye, ambient, grid[chosen])
        picture = cv2.resize(coarse, (2 * columns, 2 * rows), interpolation=cv2.INTER_NEAREST)
        picture = cv2.GaussianBlur(picture[:height, :width], (3, 3), 0)
    # Gloss of a floor rises towards grazing; a true mirror (share over 0.6) is one everywhere.
    view = eye.position.astype(np.float32) - seen.point
    cos = np.abs(dot(view, seen.normal)) / np.sqrt(dot(view, view))
    share = np.where(share > 0.6, share, share * (0.15 + 0.85 * (1 - cos) ** 3))
    return share[:, None], picture.reshape(-1, 3)


def shade(
    bodies: list[Body],
    seen: Surfels,
    eye: Eye,
    lamps: list[Lamp],
    ambient: Array,
    rng: np.random.Generator,
    sun: Sun | None = None,
) -> Array:
    """Return the (h, w, 3) float32 linear picture: lamps, highlights, light from all around."""
    height, width = eye.size
    room = bodies[0]
    view = eye.position.astype(np.float32) - seen.point
    view /= np.sqrt(dot(view, view))[:, None]
    corner = np.sort(room.span - np.abs(seen.point - room.centre.astype(np.float32)), axis=1)
    # A surface of the room has distance 0 to itself; the next two are its neighbours.
    near = np.clip(corner[:, 1:], 0, None)
    occlusion = (1 - 0.35 * np.exp(near / np.float32(-0.35))).prod(axis=1)
    occlusion *= 0.85 + 0.15 * seen.normal[:, 1]
    occlusion *= contact(bodies, seen, eye)
    light = ambient.astype(np.float32) * occlusion[:, None]
    shine = np.zeros_like(light)
    for lamp in lamps:
        to = lamp.position.astype(np.float32) - seen.point
        square = dot(to, to)
        to /= np.sqrt(square)[:, None]
        colour = lamp.colour.astype(np.float32)
        arrives = shadow(bodies, seen, eye, lamp, rng).ravel() / (square + np.float32(0.15))
        light += (np.maximum(dot(seen.normal, to), 0) * arrives)[:, None] * colour
        halfway = to + view
        halfway /= np.sqrt(dot(halfway, halfway))[:, None]
        peak = np.maximum(dot(seen.normal, halfway), 0) ** 60
        shine += (peak * arrives * seen.gloss * 4)[:, None] * colour
    if sun is not None:
        light += sunlight(bodies, seen, sun)[:, None] * sun.colour.astype(np.float32)
    picture = seen.albedo * (light + seen.glow[:, None]) + shine
    if seen.mirror.any():
        share, mirrored = reflections(bodies, seen, eye, ambient + light.mean(0))
        picture = picture * (1 - share) + share * mirrored
    return picture.reshape(height, width, 3).astype(np.float32)


def soft_edges(picture: Array, body: Array) -> Array:
    """Return a (h, w, 3) linear picture with pixels at outlines of bodies (h, w) mixed.

    Stands in for many rays per pixel, which real photos amount to.
    """
    limited = np.minimum(picture, 4 * float(np.quantile(picture[::4, ::4], 0.9)) + 1e-3)
    edge = np.zeros(body.shape, bool)
    across, down = body[:, 1:] != body[:, :-1], body[1:] != body[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return np.where(edge[..., None], cv2.GaussianBlur(limited, (3, 3), 0.7), picture)
