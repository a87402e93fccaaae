"""Flat parts laid out in one image: where each lies, and the world points of its texels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy import ndimage
from shapely.geometry import Polygon
from shapely.ops import unary_union

from plan2scene.mesh.parts import MeshPart

#: Texels around each part that continue its edge, so that filtering takes nothing of others.
GUTTER = 1
#: Points stand so far in front of a face, metres, when rays start there: before the walls of rooms
#: that a plan draws a little into each other.
LIFT = 0.015


@dataclass(frozen=True)
class Chart:
    """A flat part with its texels: column and row of the image that its texel (0, 0) has.

    `low` is the corner of texel (0, 0) in the part's texture coordinates, metres.
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
        """Return (..., 2) column and row in the image, in texels, of texture coordinates."""
        return np.asarray((uv - self.low) / self.texel_m + [self.column, self.row])

    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """Return texture coordinates (h, w, 2) of texels with their gutter, and which are on it."""
        height, width = self.size
        rows, columns = np.mgrid[-GUTTER : height + GUTTER, -GUTTER : width + GUTTER]
        uv = self.low + (np.stack([columns, rows], axis=-1) + 0.5) * self.texel_m
        return uv, self._covered(uv)

    def world(self, uv: np.ndarray) -> np.ndarray:
        """Return points (n, 3) `LIFT` in front of the part, of texture coordinates (n, 2)."""
        known = np.column_stack([np.asarray(self.part.uv), np.ones(len(self.part.mesh.vertices))])
        to_world, *_ = np.linalg.lstsq(known, self.part.mesh.vertices, rcond=None)
        return np.asarray(np.column_stack([uv, np.ones(len(uv))]) @ to_world + LIFT * self.normal)

    def paste(self, image: np.ndarray, values: np.ndarray, inside: np.ndarray) -> None:
        """Write values (h, w, ...) of the grid into an image; off the part its nearest texel's."""
        if inside.any():
            nearest = ndimage.distance_transform_edt(
                ~inside, return_distances=False, return_indices=True
            )
            values = values[tuple(nearest)]
        top, left = self.row - GUTTER, self.column - GUTTER
        image[top : top + values.shape[0], left : left + values.shape[1]] = values

    def _covered(self, uv: np.ndarray) -> np.ndarray:
        """Return which points (..., 2) of the part's coordinates lie on it."""
        corners = np.asarray(self.part.uv)[self.part.mesh.faces]
        area = unary_union([Polygon(triangle) for triangle in corners])
        return np.asarray(shapely.contains_xy(area, uv[..., 0], uv[..., 1]))


def packed(
    parts: Sequence[MeshPart], texel_m: float, most_px: int
) -> tuple[list[Chart], tuple[int, int]]:
    """Return the parts on shelves of an image no higher than wide, and its (height, width).

    Texels are `texel_m` wide, larger where the image would be over `most_px`.
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
    """Return charts placed in rows of a square; None where it is too small."""
    placed, x, y, high = [], 0, 0, 0
    for chart in charts:
        height, width = (n + 2 * GUTTER for n in chart.size)
        if x + width > side:
            x, y, high = 0, y + high, 0
        if x + width > side or y + height > side:
            return None
        place = {"column": x + GUTTER, "row": y + GUTTER}
        placed.append(Chart(chart.part, chart.low, chart.size, chart.texel_m, **place))
        x, high = x + width, max(high, height)
    return placed
