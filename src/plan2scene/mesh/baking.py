"""Ambient occlusion of a house's surfaces, baked into texels by rays (Embree), and its lamps.

Flat parts are laid out in one image (`Chart`). Occlusion (glTF's occlusionTexture) is the share of
the hemisphere over a point that near parts cover, weighted by the cosine and by their nearness.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy import ndimage
from shapely.geometry import Point, Polygon
from shapely.ops import unary_union

from plan2scene.house import House
from plan2scene.images import png_bytes
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.rays import Rays, hemisphere
from plan2scene.plans.geometry import room_polygon

#: Width in texels of a border that continues a part's edge: filtering does not mix in other parts.
GUTTER = 1
#: Rays start this far in front of a face, metres. So the wall of a neighbouring room that overlaps
#: this one a little in the plan does not block them.
LIFT = 0.015


@dataclass(frozen=True)
class Chart:
    """A flat part and its rectangle of texels, `size` (height, width), in an image.

    Texel (0, 0) has its corner at `low` in the part's texture coordinates, metres; in the image it
    lies at `column` and `row`.
    """

    part: MeshPart
    low: np.ndarray
    size: tuple[int, int]
    texel_m: float
    column: int = 0
    row: int = 0

    @property
    def normal(self) -> np.ndarray:
        """Return the part's normal, (3,)."""
        return np.asarray(self.part.mesh.vertex_normals[0])

    def texels(self, uv: np.ndarray) -> np.ndarray:
        """Return the (..., 2) column and row in the image, in texels, of texture coordinates."""
        return np.asarray((uv - self.low) / self.texel_m + [self.column, self.row])

    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """Return texture coordinates (h, w, 2) of texels and gutter, and which are on the part."""
        height, width = self.size
        rows, columns = np.mgrid[-GUTTER : height + GUTTER, -GUTTER : width + GUTTER]
        uv = self.low + (np.stack([columns, rows], axis=-1) + 0.5) * self.texel_m
        corners = np.asarray(self.part.uv)[self.part.mesh.faces]
        area = unary_union([Polygon(triangle) for triangle in corners])
        return uv, np.asarray(shapely.contains_xy(area, uv[..., 0], uv[..., 1]))

    def world(self, uv: np.ndarray) -> np.ndarray:
        """Return points (n, 3) `LIFT` in front of the part, of texture coordinates (n, 2)."""
        points = np.column_stack([uv, np.ones(len(uv))]) @ self.part.uv_to_world()
        return np.asarray(points + LIFT * self.normal)

    def paste(self, image: np.ndarray, values: np.ndarray, inside: np.ndarray) -> None:
        """Write the grid's values (h, w, ...) into an image; off the part its nearest texel's."""
        if inside.any():
            nearest = ndimage.distance_transform_edt(
                ~inside, return_distances=False, return_indices=True
            )
            values = values[tuple(nearest)]
        top, left = self.row - GUTTER, self.column - GUTTER
        image[top : top + values.shape[0], left : left + values.shape[1]] = values


def packed(
    parts: Sequence[MeshPart], texel_m: float, most_px: int
) -> tuple[list[Chart], tuple[int, int]]:
    """Return charts of the parts, packed in rows of an image, and its (height, width).

    It is no higher than wide. Texels are `texel_m` wide, or larger if it would exceed `most_px`.
    """
    while True:
        charts = sorted((_chart(part, texel_m) for part in parts), key=lambda c: -c.size[0])
        side = 64
        while side <= most_px:
            placed = _shelves(charts, side)
            if placed is not None:
                height = max(chart.row + chart.size[0] + GUTTER for chart in placed)
                return placed, (height, side)
            side *= 2
        texel_m *= 1.5


def _chart(part: MeshPart, texel_m: float) -> Chart:
    uv = np.asarray(part.uv)
    low = uv.min(0)
    width, height = np.maximum(np.ceil((uv.max(0) - low) / texel_m - 1e-9), 1).astype(int)
    return Chart(part, low, (int(height), int(width)), texel_m)


def _shelves(charts: Sequence[Chart], side: int) -> list[Chart] | None:
    """Return the charts, placed in rows of a square; None if it is too small."""
    placed, x, y, high = [], 0, 0, 0
    for chart in charts:
        height, width = (n + 2 * GUTTER for n in chart.size)
        if x + width > side:
            x, y, high = 0, y + high, 0
        if x + width > side or y + height > side:
            return None
        placed.append(replace(chart, column=x + GUTTER, row=y + GUTTER))
        x, high = x + width, max(high, height)
    return placed


@dataclass(frozen=True)
class OcclusionSettings:
    """How occlusion is baked: half a second of processor time a house."""

    reach_m: float = 1.2  #: parts farther away than this do not occlude
    texel_m: float = 0.08  #: side of a texel; larger if the image would exceed `most_px`
    most_px: int = 2048  #: largest width and height of the image
    rays: int = 64  #: number of rays per texel


OCCLUSION = OcclusionSettings()


@dataclass(frozen=True)
class Occlusion:
    """A baked image, and where each part lies in it."""

    png: bytes  #: (h, w) uint8, linear: 255 where nothing is near
    #: by part name: image coordinates of its vertices, (n, 2) float64 in [0, 1], v down
    uv: Mapping[str, np.ndarray]


def bake_occlusion(parts: Sequence[MeshPart], flat: Sequence[MeshPart]) -> Occlusion | None:
    """Return the occlusion of the `flat` parts, some of a house's `parts`, with UV in metres.

    All opaque parts occlude, except skirting boards: they are thinner than a texel and would only
    blacken the wall behind them. None if `flat` is empty or there is no ray tracer. Deterministic.
    """
    if not flat:
        return None
    rays = Rays.of([part for part in parts if part.extras.get("kind") != "skirting"])
    if rays is None:
        return None
    charts, (height, width) = packed(flat, OCCLUSION.texel_m, OCCLUSION.most_px)
    image = np.full((height, width), 255, np.uint8)
    uv = {}
    for chart in charts:
        texels, inside = chart.grid()
        light = np.ones(inside.shape)
        if inside.any():
            light[inside] = _openness(chart, texels[inside], rays)
        chart.paste(image, np.round(255 * light).astype(np.uint8), inside)
        uv[chart.part.name] = chart.texels(np.asarray(chart.part.uv)) / [width, height]
    return Occlusion(png_bytes(image), uv)


def _openness(chart: Chart, uv: np.ndarray, rays: Rays) -> np.ndarray:
    """Return the free share of the hemisphere over points (n, 2) of a flat part, (n,) in [0, 1]."""
    directions = hemisphere(chart.normal, OCCLUSION.rays)
    points = chart.world(uv)
    origins = np.repeat(points, len(directions), axis=0)
    distance = rays.distances(origins, np.tile(directions, (len(points), 1)))
    near = np.clip(1 - distance / OCCLUSION.reach_m, 0, 1).reshape(len(points), -1)
    return np.asarray(1 - near.mean(axis=1))


#: Linear RGB of lamps, 1 for a white surface in full light; how far they hang below the ceiling.
LAMP, LAMP_DROP_M = np.array([1.0, 0.94, 0.86]), 0.35


def lamp_position(house: House, room_id: str) -> np.ndarray:
    """Return where a room's lamp hangs, (3,): below the ceiling, in its middle or near it."""
    room = house.room(room_id)
    polygon = room_polygon(room)
    middle = polygon.centroid
    if not polygon.buffer(-0.3).contains(Point(middle.x, middle.y)):
        middle = polygon.representative_point()
    ceiling = house.level_of(room_id).elevation + room.height
    return np.array([middle.x, ceiling - LAMP_DROP_M, middle.y])
