"""Walls and openings that are drawn as areas: their axes and segments."""

from __future__ import annotations

import numpy as np
from shapely.geometry import LineString, Point, Polygon
from shapely.strtree import STRtree

from plan2scene.plans.openings import Segment
from plan2scene_app.plan_formats.axes import WallAxis

#: No side of an opening is shorter than this (metres) along its wall.
LEAST_WIDTH = 0.35
#: A side goes through a hinge that is nearer (metres).
AT_ANCHOR = 0.1
#: Bottom and top in metres of an opening whose file tells none.
HEIGHTS = {"door": (0.0, 2.05), "passage": (0.0, 2.2), "window": (0.9, 2.1)}


def axis_of_area(area: Polygon, height: float = 0.0) -> WallAxis | None:
    """Return a wall's axis: along the longer side of the rectangle around its area.

    It ends half a thickness before the rectangle does, where the axes of a corner cross. None for
    an area without a width.
    """
    sides = _middle_lines(area)
    if sides is None:
        return None
    (start, end), thickness = sides[0]
    length = float(np.linalg.norm(end - start))
    inset = min(thickness, length * 0.9) / 2 * (end - start) / length
    return WallAxis(
        tuple((start + inset).tolist()), tuple((end - inset).tolist()), thickness, height
    )


def _middle_lines(area: Polygon) -> list[tuple[tuple[np.ndarray, np.ndarray], float]] | None:
    """Return both middle lines of the rectangle around an area, each with the width across it.

    The longer comes first; None where the area has no width.
    """
    box = area.minimum_rotated_rectangle
    if not isinstance(box, Polygon) or box.area < 1e-6:
        return None
    a, b, c, d = (np.array(point) for point in list(box.exterior.coords)[:4])
    lines = [
        (((a + d) / 2, (b + c) / 2), float(np.linalg.norm(d - a))),
        (((a + b) / 2, (d + c) / 2), float(np.linalg.norm(b - a))),
    ]
    return sorted(lines, key=lambda line: line[1])


class NearestAxis:
    """Finds the wall that an opening's area lies in."""

    def __init__(self, axes: list[WallAxis]) -> None:
        self._axes = axes
        self._lines = [LineString([axis.start, axis.end]) for axis in axes]
        self._tree = STRtree(self._lines)

    def segment(self, area: Polygon, name: str, kind: str) -> Segment | None:
        """Return an opening's segment: the middle line of its area that runs along the wall."""
        sides = _middle_lines(area)
        if sides is None:
            return None
        start, end = sides[0][0]
        if self._axes:
            axis = self._axes[int(self._tree.nearest(Point(area.centroid)))]
            way = np.subtract(axis.end, axis.start)
            start, end = max((line for line, _ in sides), key=lambda line: _along(line, way))
        bottom, top = HEIGHTS[kind]
        return Segment(name, kind, tuple(start.tolist()), tuple(end.tolist()), bottom, top)

    def edge_segment(
        self, area: Polygon, name: str, kind: str, anchor: Point | None = None
    ) -> Segment | None:
        """Return the segment of an opening whose area may stand out of its wall, as a swing does.

        That is the side or middle line of the area nearest to a wall that runs its way; of those
        that go through the `anchor` (a hinge), where there are some.
        """
        box = area.minimum_rotated_rectangle
        sides = _middle_lines(area)
        if sides is None or not isinstance(box, Polygon):
            return None
        corners = np.array(box.exterior.coords)
        lines = [line for line, _ in sides] + [(corners[k], corners[k + 1]) for k in range(4)]
        if anchor is not None:
            at_anchor = [line for line in lines if LineString(line).distance(anchor) < AT_ANCHOR]
            lines = at_anchor or lines
        best: tuple[float, int] = (np.inf, 0)
        for number, (start, end) in enumerate(lines):
            if np.linalg.norm(end - start) < LEAST_WIDTH:
                continue
            for k in self._tree.query(LineString([start, end]), predicate="dwithin", distance=0.5):
                first = np.array(self._axes[k].start)
                way = np.subtract(self._axes[k].end, first)
                if _along((start, end), way) > 0.98:
                    offset = (start + end) / 2 - first
                    across = abs(way[0] * offset[1] - way[1] * offset[0]) / np.hypot(*way)
                    best = min(best, (round(float(across), 3), number))
        start, end = lines[best[1]]
        return Segment(name, kind, tuple(start.tolist()), tuple(end.tolist()), *HEIGHTS[kind])


def _along(line: tuple[np.ndarray, np.ndarray], way: np.ndarray) -> float:
    """Return the cosine between a line and a direction."""
    step = line[1] - line[0]
    return float(abs(step @ way) / max(np.linalg.norm(step) * np.linalg.norm(way), 1e-12))
