"""From areas of pixels to polygons: straight walls, shared by the rooms on both sides.

Every long straight piece of an outline gives a line; lines along the picture that nearly coincide
are one. The lines cut the plane into cells, a cell belongs to the room that has most of it, and
the cells of a room make its polygon: rooms tile, whatever the pixels said.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon
from skimage.measure import find_contours

from plan2scene_app.tracing.regions import Regions

#: Metres: outlines are followed to this, and pieces shorter than the second give no line.
TOLERANCE, SHORTEST = 0.13, 0.3
#: Degrees off an axis up to which a piece lies along it.
ALONG_AXIS = 12.0
#: Lines nearer than this (metres), or than most of a wall's thickness, are one.
MERGED = 0.1


@dataclass(frozen=True)
class _Piece:
    """A straight piece of an outline in pixels; `points` (n, 2) are those of the outline on it."""

    start: np.ndarray
    end: np.ndarray
    points: np.ndarray

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))

    @property
    def axis(self) -> int | None:
        """0 along x, 1 along y, None for neither."""
        dx, dy = np.abs(self.end - self.start)
        angle = np.degrees(np.arctan2(dy, dx))
        if angle < ALONG_AXIS:
            return 0
        return 1 if angle > 90 - ALONG_AXIS else None


def room_polygons(regions: Regions) -> dict[int, Polygon]:
    """Return the polygon (pixels x, y) of each room's number; rooms that vanish are left out."""
    pieces = [p for n in range(1, regions.count + 1) for p in _pieces(regions, n)]
    straight = [[p for p in pieces if p.axis == axis] for axis in (0, 1)]
    slanted = [p for p in pieces if p.axis is None and p.length > 1.5 * SHORTEST * regions.ppm]
    least = max(MERGED * regions.ppm, 0.6 * regions.wall_px, 2.0)
    ys = _coordinates(straight[0], 1, SHORTEST * regions.ppm, least)
    xs = _coordinates(straight[1], 0, SHORTEST * regions.ppm, least)
    if len(xs) < 2 or len(ys) < 2:
        return {}
    return _cells(regions, xs, ys, _slanted_lines(slanted, least))


def _pieces(regions: Regions, number: int) -> list[_Piece]:
    """Return the straight pieces of a room's outlines."""
    mask = np.pad(regions.rooms == number, 1).astype(np.float32)
    tolerance = max(1.5, TOLERANCE * regions.ppm)
    found = []
    for contour in find_contours(mask, 0.5):
        ring = contour[:-1, ::-1] - 1
        if len(ring) < 8:
            continue
        corners = cv2.approxPolyDP(ring.astype(np.float32)[:, None], tolerance, True)[:, 0]
        places = [int(np.argmin(np.abs(ring - corner).sum(1))) for corner in corners]
        for a, b in zip(places, places[1:] + places[:1], strict=True):
            along = ring[a : b + 1] if b > a else np.concatenate([ring[a:], ring[: b + 1]])
            if len(along) < 3:
                continue
            trim = len(along) // 6
            found.append(_Piece(ring[a], ring[b], along[trim : len(along) - trim]))
    return found


def _coordinates(pieces: list[_Piece], across: int, shortest: float, least: float) -> list[float]:
    """Return the positions of lines along one axis, at least `least` pixels apart."""
    found = sorted(
        (float(np.median(p.points[:, across])), p.length) for p in pieces if p.length >= shortest
    )
    groups: list[list[tuple[float, float]]] = []
    for place, length in found:
        if groups and place - _mean(groups[-1]) < least:
            groups[-1].append((place, length))
        else:
            groups.append([(place, length)])
    return [_mean(group) for group in groups]


def _mean(group: list[tuple[float, float]]) -> float:
    """Return the mean of places weighted by length."""
    places, lengths = np.array(group).T
    return float((places * lengths).sum() / lengths.sum())


def _slanted_lines(pieces: list[_Piece], least: float) -> list[LineString]:
    """Return one line for each slanted wall: both rooms beside it have a piece of it."""
    lines: list[LineString] = []
    for piece in sorted(pieces, key=lambda p: -p.length):
        way = (piece.end - piece.start) / piece.length
        own = LineString([piece.start - way * 2 * least, piece.end + way * 2 * least])
        middle = shapely.Point((piece.start + piece.end) / 2)
        if all(line.distance(middle) > 1.5 * least for line in lines):
            lines.append(own)
    return lines


def _cells(
    regions: Regions, xs: list[float], ys: list[float], slanted: list[LineString]
) -> dict[int, Polygon]:
    """Return the polygons that cells between the lines make."""
    grid = [LineString([(x, ys[0]), (x, ys[-1])]) for x in xs]
    grid += [LineString([(xs[0], y), (xs[-1], y)]) for y in ys]
    cells = list(shapely.get_parts(shapely.polygonize([shapely.union_all([*grid, *slanted])])))
    plane = np.zeros(regions.rooms.shape, np.int32)
    for number, cell in enumerate(cells, start=1):
        corners = np.round((np.array(cell.exterior.coords)[:-1] + 0.0) * 16).astype(np.int32)
        cv2.fillPoly(plane, [corners[:, None]], number, cv2.LINE_8, 4)
    count = regions.count + 1
    votes = np.bincount((plane * count + regions.rooms).ravel(), minlength=(len(cells) + 1) * count)
    winners = votes.reshape(-1, count)[: len(cells) + 1].argmax(1)
    found = {}
    for number in range(1, count):
        own = [cell for cell, winner in zip(cells, winners[1:], strict=True) if winner == number]
        shape = shapely.union_all(own, grid_size=1e-3) if own else Polygon()
        if isinstance(shape, MultiPolygon):
            shape = max(shape.geoms, key=lambda part: part.area)
        shape = shape.simplify(0.01)
        # What is mostly cells of another room is none of its own.
        floor = float((regions.floors == number).sum())
        if isinstance(shape, Polygon) and shape.is_valid and shape.area > floor / 2:
            found[number] = shape
    return found
