"""Rooms out of walls that are drawn as axes with a thickness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from shapely import unary_union
from shapely.geometry import LineString, Polygon
from shapely.ops import polygonize
from shapely.strtree import STRtree

from plan2scene.house import Point
from plan2scene.plans.parse import MAX_ITEMS, Source

#: Thickness in metres of a wall that has none.
DEFAULT_THICKNESS = 0.1
#: Most wall axes of a plan.
MAX_AXES = 5000
#: Ends of axes nearer than this (metres) meet.
JOIN = 0.02
#: A loose end reaches at least this far (metres), however thin the walls.
LEAST_REACH = 0.08
#: Crossings are rounded to this grid (metres).
GRID = 1e-3
#: Faces with less area (square metres) or width (metres) are the inside of walls, not rooms.
LEAST_AREA, LEAST_WIDTH = 0.3, 0.3


@dataclass(frozen=True)
class WallAxis:
    """A wall by the segment (x, z) in its middle; metres.

    Thickness 0: the segment is the wall's face, as scans have it. Height 0: not told.
    """

    start: Point
    end: Point
    thickness: float = DEFAULT_THICKNESS
    height: float = 0.0


def rooms_of_axes(source: Source, axes: Sequence[WallAxis]) -> list[Polygon]:
    """Return the floors between walls: the faces that the axes close, less the walls' bodies.

    A loose end is drawn on to the axis whose body it touches. Sorted from top to bottom, then
    left to right; no face at all is an empty list.

    Raises InputError for more axes than a plan may have.
    """
    if len(axes) > MAX_AXES:
        raise source.fault(f"at most {MAX_AXES} walls", len(axes))
    axes = [axis for axis in axes if math.dist(axis.start, axis.end) > JOIN]
    if not axes:
        return []
    joined = _joined(axes)
    network = unary_union(
        [LineString([a.start, a.end]) for a in joined if a.start != a.end], grid_size=GRID
    )
    pieces = len(getattr(network, "geoms", [network]))
    if pieces > MAX_ITEMS:
        raise source.fault(f"walls of at most {MAX_ITEMS} pieces between crossings", pieces)
    bodies = [_body(axis) for axis in joined]
    tree = STRtree(bodies)
    rooms = []
    for face in polygonize(network):
        floor = face.difference(unary_union([bodies[k] for k in tree.query(face)]))
        for part in getattr(floor, "geoms", [floor]):
            if is_floor(part):
                rooms.append(_plain(part))
    return sorted(rooms, key=lambda room: (round(room.bounds[1], 3), round(room.bounds[0], 3)))


def is_floor(face: Polygon) -> bool:
    """Return whether a face between walls is large and wide enough for a room."""
    return face.area >= LEAST_AREA and not face.buffer(-LEAST_WIDTH / 2).is_empty


def _joined(axes: Sequence[WallAxis]) -> list[WallAxis]:
    """Return the axes with near ends made one, and loose ends drawn to the wall they touch."""
    from scipy.spatial import cKDTree  # a third of a second that no other format needs

    points = np.array([end for axis in axes for end in (axis.start, axis.end)], dtype=np.float64)
    nodes = np.arange(len(points))
    for i, j in sorted(cKDTree(points).query_pairs(JOIN)):
        nodes[j] = min(nodes[i], nodes[j])
    points = points[nodes]
    counts = np.bincount(nodes, minlength=len(points))
    lines = [LineString(points[2 * k : 2 * k + 2]) for k in range(len(axes))]
    tree = STRtree(lines)
    moved = points.copy()
    for end in np.flatnonzero(counts[nodes] == 1):
        target = _touched(int(end), points, axes, lines, tree)
        if target is not None:
            moved[end] = target
    return [
        replace(axis, start=tuple(moved[2 * k].tolist()), end=tuple(moved[2 * k + 1].tolist()))
        for k, axis in enumerate(axes)
    ]


def _touched(
    end: int,
    points: np.ndarray,
    axes: Sequence[WallAxis],
    lines: Sequence[LineString],
    tree: STRtree,
) -> np.ndarray | None:
    """Return where a loose end (index into `points` (2n, 2)) meets the nearest other axis.

    That is the crossing of both lines, when the bodies of both walls touch there.
    """
    own = end // 2
    here, other_end = points[end], points[end ^ 1]
    direction = here - other_end
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    half = axes[own].thickness / 2
    best: tuple[float, np.ndarray | None] = (math.inf, None)
    reach = max(half + max(axis.thickness for axis in axes) / 2, LEAST_REACH) + JOIN
    for k in tree.query(lines[own].buffer(reach)):
        if k == own:
            continue
        a, b = points[2 * k], points[2 * k + 1]
        across = b - a
        turn = direction[0] * across[1] - direction[1] * across[0]
        if abs(turn) <= 0.17 * float(np.linalg.norm(across)):
            continue
        offset = a - here
        step = (offset[0] * across[1] - offset[1] * across[0]) / turn
        place = here + step * direction
        limit = max(half + axes[k].thickness / 2, LEAST_REACH) + JOIN
        off = lines[k].distance(LineString([place, place]))
        if abs(step) <= limit and off <= limit and abs(step) < best[0]:
            best = (abs(step), place)
    return best[1]


def _body(axis: WallAxis) -> Polygon:
    """Return the area of a wall, drawn on by half its thickness at both ends."""
    return LineString([axis.start, axis.end]).buffer(axis.thickness / 2, cap_style="square")


def _plain(room: Polygon) -> Polygon:
    """Return a room without points on straight lines and slivers of the grid."""
    plain = room.simplify(2 * GRID)
    return plain if plain.is_valid and plain.area > 0 else room
