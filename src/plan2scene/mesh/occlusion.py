"""Ambient occlusion of a house's surfaces, baked into one image (glTF's occlusionTexture).

How much of the hemisphere over a point is free of what is nearer than `REACH_M`, weighted by the
cosine and by how near it is: corners, door frames and open leaves darken what is beside them; a
wall across the room does not. Rays by Embree.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
import trimesh
from scipy import ndimage
from shapely.geometry import Polygon
from shapely.ops import unary_union

from plan2scene.images import png_bytes
from plan2scene.mesh.parts import MeshPart

#: What is farther away than this does not darken, metres.
REACH_M = 1.2
#: Side of a texel, metres; the image is at most `MOST_PX` wide and high, else texels are larger.
TEXEL_M = 0.08
MOST_PX = 2048
RAYS = 64
#: Rays start so far in front of a face, metres.
_LIFT = 2e-3
#: Texels around each part that continue its edge, so that filtering takes nothing of others.
_GUTTER = 1


@dataclass(frozen=True)
class Occlusion:
    """A baked image, and where each part lies in it.

    Attributes
    ----------
    png : bytes
        (h, w) uint8, linear: 255 where nothing is near.
    uv : mapping of part name to (n, 2) float64
        Texture coordinates of the part's vertices in the image, v down, in [0, 1].
    """

    png: bytes
    uv: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class _Chart:
    """A flat part with its texels: column and row of the image that its texel (0, 0) has."""

    part: MeshPart
    low: np.ndarray
    size: tuple[int, int]
    texel_m: float
    column: int = 0
    row: int = 0


def bake_occlusion(parts: Sequence[MeshPart], flat: Sequence[MeshPart]) -> Occlusion | None:
    """Return the occlusion of the `flat` ones among a house's parts, which have UV in metres.

    Every opaque part casts; glass does not, and skirting boards, thinner than a texel, would only
    blacken the wall behind them. None where nothing is flat, or where there is no ray
    tracer. Deterministic.
    """
    if not flat:
        return None
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError:
        logging.getLogger("plan2scene").warning("no Embree here: the house has no occlusion")
        return None
    casting = (p for p in parts if p.material != "glass" and p.extras.get("kind") != "skirting")
    solid = [part.mesh.triangles for part in casting]
    scene = EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(np.concatenate(solid), dtype=np.float32))
    charts, width = _packed(flat)
    height = max(chart.row + chart.size[0] + _GUTTER for chart in charts)
    image = np.full((height, width), 255, np.uint8)
    uv = {}
    for chart in charts:
        shade = _shade(chart, scene)
        top, left = chart.row - _GUTTER, chart.column - _GUTTER
        image[top : top + shade.shape[0], left : left + shade.shape[1]] = shade
        texel = (np.asarray(chart.part.uv) - chart.low) / chart.texel_m
        uv[chart.part.name] = (texel + [chart.column, chart.row]) / [width, height]
    return Occlusion(png_bytes(image), uv)


def _packed(parts: Sequence[MeshPart]) -> tuple[list[_Chart], int]:
    """Return the parts on shelves of an image no higher than wide, and its width in pixels."""
    texel = TEXEL_M
    while True:
        charts = sorted((_chart(part, texel) for part in parts), key=lambda c: -c.size[0])
        side = 64
        while side <= MOST_PX:
            placed = _shelves(charts, side)
            if placed is not None:
                return placed, side
            side *= 2
        texel *= 1.5


def _chart(part: MeshPart, texel_m: float) -> _Chart:
    uv = np.asarray(part.uv)
    low = uv.min(0)
    width, height = np.maximum(np.ceil((uv.max(0) - low) / texel_m - 1e-9), 1).astype(int)
    return _Chart(part, low, (int(height), int(width)), texel_m)


def _shelves(charts: Sequence[_Chart], side: int) -> list[_Chart] | None:
    """Return charts placed in rows of a square; None where it is too small."""
    placed, x, y, high = [], 0, 0, 0
    for chart in charts:
        height, width = (n + 2 * _GUTTER for n in chart.size)
        if x + width > side:
            x, y, high = 0, y + high, 0
        if x + width > side or y + height > side:
            return None
        place = {"column": x + _GUTTER, "row": y + _GUTTER}
        placed.append(_Chart(chart.part, chart.low, chart.size, chart.texel_m, **place))
        x, high = x + width, max(high, height)
    return placed


def _shade(chart: _Chart, scene: object) -> np.ndarray:
    """Return a part's texels with their gutter, (h + 2g, w + 2g) uint8."""
    height, width = chart.size
    rows, columns = np.mgrid[-_GUTTER : height + _GUTTER, -_GUTTER : width + _GUTTER]
    uv = chart.low + (np.stack([columns, rows], axis=-1) + 0.5) * chart.texel_m
    inside = _covered(chart.part, uv)
    light = np.ones(inside.shape)
    if inside.any():
        light[inside] = _openness(chart.part, uv[inside], scene)
        nearest = ndimage.distance_transform_edt(
            ~inside, return_distances=False, return_indices=True
        )
        light = light[tuple(nearest)]
    return np.asarray(np.round(255 * light), np.uint8)


def _covered(part: MeshPart, uv: np.ndarray) -> np.ndarray:
    """Return which points (..., 2) of the part's coordinates lie on it."""
    corners = np.asarray(part.uv)[part.mesh.faces]
    area = unary_union([Polygon(triangle) for triangle in corners])
    return np.asarray(shapely.contains_xy(area, uv[..., 0], uv[..., 1]))


def _openness(part: MeshPart, uv: np.ndarray, scene: object) -> np.ndarray:
    """Return the free share of the hemisphere over points (n, 2) of a flat part, (n,) in [0, 1]."""
    known = np.column_stack([np.asarray(part.uv), np.ones(len(part.mesh.vertices))])
    to_world, *_ = np.linalg.lstsq(known, part.mesh.vertices, rcond=None)
    normal = np.asarray(part.mesh.vertex_normals[0])
    points = np.column_stack([uv, np.ones(len(uv))]) @ to_world + _LIFT * normal
    directions = _hemisphere(normal)
    origins = np.repeat(points.astype(np.float32), len(directions), axis=0)
    rays = np.tile(directions.astype(np.float32), (len(points), 1))
    distance = scene.run(origins, rays, query="DISTANCE")  # type: ignore[attr-defined]
    near = np.clip(1 - distance / REACH_M, 0, 1).reshape(len(points), -1)
    return np.asarray(1 - near.mean(axis=1))


def _hemisphere(normal: np.ndarray) -> np.ndarray:
    """Return `RAYS` unit directions about a normal, (n, 3), dense as the cosine (Malley's way)."""
    number = np.arange(RAYS)
    radius = np.sqrt((number + 0.5) / RAYS)
    angle = number * np.pi * (3 - np.sqrt(5))
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], 1)
    turn = trimesh.geometry.align_vectors([0, 0, 1], normal)[:3, :3]
    return np.asarray(local @ turn.T)
