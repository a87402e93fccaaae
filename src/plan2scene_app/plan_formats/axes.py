"""Walls as axes with a thickness: made of areas, with the rooms they close and their openings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from shapely import unary_union
from shapely.geometry import LineString, Point, Polygon
from shapely.ops import polygonize
from shapely.strtree import STRtree

from plan2scene import house
from plan2scene.errors import InputError
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import MAX_ITEMS, Source

#: Thickness in metres of a wall whose file gives none.
DEFAULT_THICKNESS = 0.1
#: Largest number of wall axes of a plan.
MAX_AXES = 5000
#: Largest number of pairs of walls that meet, and of pairs of wall lines side by side.
MAX_PAIRS = 200_000
#: Bottom and top in metres of an opening whose file gives none.
HEIGHTS = {"door": (0.0, 2.05), "passage": (0.0, 2.2), "window": (0.9, 2.1)}


@dataclass(frozen=True)
class DrawingSettings:
    """The tuned numbers of reading other programs' drawings.

    Metres and square metres that are usual in buildings and their drawings, set by hand. The file
    docs/measurements/formats.md lists which files of other programs are read with them.
    """

    # Walls as axes.
    join: float = 0.02  #: m within which ends of axes are joined
    least_reach: float = 0.08  #: m: a loose end is extended by up to this even if walls are thin
    grid: float = 1e-3  #: m that crossings are rounded to
    room_area: float = 0.3  #: m2: smaller faces are the inside of walls
    room_width: float = 0.3  #: m: narrower faces are the inside of walls, too
    wall_angle: float = math.radians(10)  #: rad: largest angle from a room's edge to its wall
    # Walls as lines.
    faces: tuple[float, float] = (0.04, 0.6)  #: m between the two faces of a wall
    face_angle: float = math.radians(2.0)  #: rad: largest angle between them
    shared: float = 0.5  #: least share of the shorter line that lies beside the longer one
    covered: float = 0.7  #: a line with partners along this share of it gets no further one
    touch: float = 0.05  #: m within which lines of one door or window touch
    panes: float = 0.4  #: m: largest distance between its parallel lines
    overlap: float = 0.05  #: m by which a wall through an opening overlaps the wall beside it
    thin: float = 0.5  #: m: a thinner face between lines is a wall's body
    rectangle: float = 0.85  #: least share of its bounding rectangle that a wall's outline fills
    flat: float = 0.02  #: m: largest distance of a curve from the lines that replace it
    arc_step: float = math.radians(15.0)  #: rad: largest turn of a piece of a curved wall
    # Gaps between walls in line.
    gap: tuple[float, float] = (0.5, 1.3)  #: m of a gap that is a passage
    gap_room: float = 2.5  #: m2 of the smallest room that a gap may close
    in_line: float = math.radians(8.0)  #: rad: largest angle between the walls beside a gap
    off_line: float = 0.15  #: m: largest distance between their lines
    # What is unlikely.
    most_height: float = 6.0  #: m of a room; higher ones get a warning
    most_floor: tuple[float, float] = (6000.0, 50_000.0)  #: m2 of a storey: warning, error above
    bordering: float = 0.6  #: least share, of the walls' length, of walls along rooms; else warned
    # Rooms and openings.
    drawn_share: float = 0.1  #: a face with a larger share under drawn rooms is no room of its own
    agreement: float = 0.1  #: share by which scales of sizes written in rooms may differ
    same_opening: float = 0.4  #: m: openings whose middles are nearer are one
    opening_side: float = 0.35  #: m: shortest side of an opening's area along its wall
    at_hinge: float = 0.1  #: m within which a side goes through a hinge
    opening_slack: float = 0.1  #: m: largest distance of an opening from the face of its wall
    opening_reach: float = 0.3  #: m: the same for a wall of unknown thickness
    widths: tuple[float, float] = (0.4, 6.0)  #: m of doors and windows in DXF
    sill: float = 0.3  #: m: an opening that begins higher is a window
    walled: float = 0.2  #: with a smaller share of wall, the line between two rooms is a passage
    passage: float = 0.5  #: m of the shortest such passage
    far: float = 20.0  #: m: a lowest floor further from 0 is moved to 0, and the others with it


SETTINGS = DrawingSettings()


@dataclass(frozen=True)
class WallAxis:
    """A wall, given by the segment (x, z) in its middle; metres.

    Thickness 0: the segment is a face of the wall, as in scans. Height 0: not known.
    """

    start: house.Point
    end: house.Point
    thickness: float = DEFAULT_THICKNESS
    height: float = 0.0


def distinct(axes: Iterable[WallAxis]) -> list[WallAxis]:
    """Return walls without duplicates, which have the same ends (to `SETTINGS.grid`).

    The first one is kept, with the largest thickness and the largest height of them.
    """
    axis_by_ends: dict[tuple[tuple[int, int], ...], WallAxis] = {}
    for axis in axes:
        key = same_ends(axis.start, axis.end)
        first = axis_by_ends.get(key, axis)
        thickness, height = max(first.thickness, axis.thickness), max(first.height, axis.height)
        axis_by_ends[key] = replace(first, thickness=thickness, height=height)
    return list(axis_by_ends.values())


def same_ends(start: Sequence[float], end: Sequence[float]) -> tuple[tuple[int, int], ...]:
    """Return a key for a segment's ends, to `SETTINGS.grid`, in either order."""
    ends = [(round(x / SETTINGS.grid), round(z / SETTINGS.grid)) for x, z in (start, end)]
    return tuple(sorted(ends))


def limit_pairs(lines: Sequence[LineString], distance: float, what: str) -> None:
    """Raise InputError if more than `MAX_PAIRS` pairs of lines are within a distance.

    The pairs are counted a few lines at a time, so that the count stops soon after the limit.
    """
    tree, count, step = STRtree(lines), 0, 50
    for k in range(0, len(lines), step):
        pairs = tree.query(lines[k : k + step], predicate="dwithin", distance=distance)
        count += pairs.shape[1]
        if count > 2 * MAX_PAIRS + len(lines):
            raise InputError(f"at most {MAX_PAIRS} pairs of {what}", "more")


def rooms_of_axes(source: Source, axes: Sequence[WallAxis]) -> list[Polygon]:
    """Return the floors between walls: the faces that the axes close, less the walls' bodies.

    A loose end is extended to the axis whose body it touches. Floors are sorted from top to bottom,
    then left to right.

    Raises InputError for more axes than a plan may have.
    """
    if len(axes) > MAX_AXES:
        raise source.fault(f"at most {MAX_AXES} walls", len(axes))
    axes = [axis for axis in axes if math.dist(axis.start, axis.end) > SETTINGS.join]
    if not axes:
        return []
    limit_pairs([LineString([a.start, a.end]) for a in axes], 0.0, "walls that meet")
    joined = _joined(axes)
    lines = [LineString([a.start, a.end]) for a in joined if a.start != a.end]
    limit_pairs(lines, 0.0, "walls that meet")
    network = unary_union(lines, grid_size=SETTINGS.grid)
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


def gaps_in_line(axes: Sequence[WallAxis]) -> list[WallAxis]:
    """Return pieces of wall that fill the gap between walls in line, from end to facing end.

    A piece lies between two free ends, or outside all rooms that the walls close already, so that
    a corridor between two walls in line stays open.
    """
    axes = [axis for axis in axes if math.dist(axis.start, axis.end) > SETTINGS.join]
    lines = [LineString([axis.start, axis.end]) for axis in axes]
    if not lines:
        return []
    limit_pairs(lines, SETTINGS.gap[1], "walls side by side")
    tree = STRtree(lines)
    network = unary_union(lines, grid_size=SETTINGS.grid)
    inside = unary_union([face.buffer(-SETTINGS.touch) for face in polygonize(network)])
    ends = np.array([end for axis in axes for end in (axis.start, axis.end)], dtype=np.float64)
    pieces: dict[tuple[int, int], WallAxis] = {}
    for end, other in _facing(ends, np.array([axis.thickness for axis in axes])):
        one, two = axes[end // 2], axes[other // 2]
        piece = LineString(ends[[end, other]])
        way = (ends[other] - ends[end]) / piece.length
        middle = LineString([ends[end] + 0.1 * way, ends[other] - 0.1 * way])
        if set(tree.query(middle, predicate="intersects").tolist()) - {end // 2, other // 2}:
            continue
        free = all(_is_free(ends[k], k // 2, lines, tree) for k in (end, other))
        if free or not inside.contains(piece.centroid):
            (x0, z0), (x1, z1) = ends[sorted((end, other))].tolist()
            thickness = min(one.thickness, two.thickness)
            key = (min(end, other), max(end, other))
            pieces[key] = WallAxis((x0, z0), (x1, z1), thickness, one.height)
    return [pieces[key] for key in sorted(pieces)]


def _facing(ends: np.ndarray, thickness: np.ndarray) -> list[tuple[int, int]]:
    """Return (end, other), indices into `ends` (2n, 2): the nearest end that faces each in line."""
    from scipy.spatial import cKDTree  # slow to import (0.3 s), not always needed

    outward = ends - ends.reshape(-1, 2, 2)[:, ::-1].reshape(-1, 2)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    pairs = cKDTree(ends).query_pairs(SETTINGS.gap[1], output_type="ndarray")
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    nearest_ends: dict[int, tuple[float, int]] = {}
    for one, other in (pairs.T, pairs.T[::-1]):
        steps, ways = ends[other] - ends[one], outward[one]
        along = (steps * ways).sum(1)
        across = np.abs(steps[:, 0] * ways[:, 1] - steps[:, 1] * ways[:, 0])
        straight = -(ways * outward[other]).sum(1) >= math.cos(SETTINGS.in_line)
        near = across <= SETTINGS.off_line + thickness[one // 2] / 2
        fits = straight & near & (along >= SETTINGS.gap[0]) & (along <= SETTINGS.gap[1])
        for k in np.flatnonzero(fits & (one // 2 != other // 2)):
            best = nearest_ends.get(int(one[k]), (math.inf, -1))
            nearest_ends[int(one[k])] = min(best, (float(along[k]), int(other[k])))
    return [(end, other) for end, (_, other) in sorted(nearest_ends.items())]


def _is_free(end: np.ndarray, own: int, lines: Sequence[LineString], tree: STRtree) -> bool:
    """Return whether no other wall is at an end; a short stroke, as at doors, is no wall."""
    place = Point(end)
    near = tree.query(place, predicate="dwithin", distance=SETTINGS.touch)
    return not any(k != own and lines[k].length > SETTINGS.room_width for k in near)


def is_floor(face: Polygon) -> bool:
    """Return whether a face between walls is large and wide enough for a room."""
    return face.area >= SETTINGS.room_area and not face.buffer(-SETTINGS.room_width / 2).is_empty


def _joined(axes: Sequence[WallAxis]) -> list[WallAxis]:
    """Return the axes with near ends merged, and loose ends extended to the wall they touch."""
    from scipy.spatial import cKDTree  # slow to import (0.3 s), not always needed

    points = np.array([end for axis in axes for end in (axis.start, axis.end)], dtype=np.float64)
    nodes = np.arange(len(points))
    near = cKDTree(points)
    if near.count_neighbors(near, SETTINGS.join) > 2 * MAX_PAIRS + len(points):
        raise InputError(f"at most {MAX_PAIRS} pairs of ends of walls that meet", "more")
    for i, j in sorted(near.query_pairs(SETTINGS.join)):
        nodes[j] = min(nodes[i], nodes[j])
    points = points[nodes]
    counts = np.bincount(nodes, minlength=len(points))
    lines = [LineString(points[2 * k : 2 * k + 2]) for k in range(len(axes))]
    tree = STRtree(lines)
    thickness = np.array([axis.thickness for axis in axes])
    moved = points.copy()
    for end in np.flatnonzero(counts[nodes] == 1):
        target = _touched(int(end), points, thickness, lines, tree)
        if target is not None:
            moved[end] = target
    return [
        replace(axis, start=tuple(moved[2 * k].tolist()), end=tuple(moved[2 * k + 1].tolist()))
        for k, axis in enumerate(axes)
    ]


def _touched(
    end: int,
    points: np.ndarray,
    thickness: np.ndarray,
    lines: Sequence[LineString],
    tree: STRtree,
) -> np.ndarray | None:
    """Return the point where a loose end (index into `points` (2n, 2)) meets the nearest axis.

    It is the crossing of both lines, if the bodies of both walls, `thickness` (n,) m, touch there.
    """
    own_axis = end // 2
    loose_end, other_end = points[end], points[end ^ 1]
    direction = loose_end - other_end
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    half = thickness[own_axis] / 2
    reach = max(half + thickness.max() / 2, SETTINGS.least_reach) + SETTINGS.join
    near_axes = tree.query(lines[own_axis].buffer(reach))
    near_axes = near_axes[near_axes != own_axis]
    across = points[2 * near_axes + 1] - points[2 * near_axes]
    turns = direction[0] * across[:, 1] - direction[1] * across[:, 0]
    turned = np.abs(turns) > 0.17 * np.linalg.norm(across, axis=1)
    near_axes, across, turns = near_axes[turned], across[turned], turns[turned]
    offsets = points[2 * near_axes] - loose_end
    steps = (offsets[:, 0] * across[:, 1] - offsets[:, 1] * across[:, 0]) / turns
    limits = np.maximum(half + thickness[near_axes] / 2, SETTINGS.least_reach) + SETTINGS.join
    for n in np.argsort(np.abs(steps), kind="stable"):
        place = loose_end + steps[n] * direction
        if abs(steps[n]) <= limits[n] and lines[near_axes[n]].distance(Point(place)) <= limits[n]:
            return np.asarray(place)
    return None


def _body(axis: WallAxis) -> Polygon:
    """Return the area of a wall, extended by half its thickness at both ends."""
    return LineString([axis.start, axis.end]).buffer(axis.thickness / 2, cap_style="square")


def _plain(room: Polygon) -> Polygon:
    """Return a room without points on straight lines and slivers from rounding to the grid."""
    plain = room.simplify(2 * SETTINGS.grid)
    return plain if plain.is_valid and plain.area > 0 else room


def axis_of_area(area: Polygon, height: float = 0.0) -> WallAxis | None:
    """Return the axis of a wall's area, along the longer side of its bounding rectangle.

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

    The longer line comes first. None if the area has no width.
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
    """Finds the wall in which an opening's area lies."""

    def __init__(self, axes: Sequence[WallAxis]) -> None:
        self._axes = distinct(axes)
        self._lines = [LineString([axis.start, axis.end]) for axis in self._axes]
        self._tree = STRtree(self._lines)
        self._starts = np.array([axis.start for axis in self._axes]).reshape(-1, 2)
        self._ways = np.array([axis.end for axis in self._axes]).reshape(-1, 2) - self._starts

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
        """Return the segment of an opening whose area may stick out of its wall, as a swing does.

        It is that side or middle line of the area which is nearest to a parallel wall. If some of
        them go through the `anchor` (a hinge), it is one of these.
        """
        box = area.minimum_rotated_rectangle
        sides = _middle_lines(area)
        if sides is None or not isinstance(box, Polygon):
            return None
        corners = np.array(box.exterior.coords)
        lines = [line for line, _ in sides] + [(corners[k], corners[k + 1]) for k in range(4)]
        if anchor is not None:
            at_anchor = [
                line for line in lines if LineString(line).distance(anchor) < SETTINGS.at_hinge
            ]
            lines = at_anchor or lines
        best: tuple[float, int] = (np.inf, 0)
        for number, (start, end) in enumerate(lines):
            if np.linalg.norm(end - start) < SETTINGS.opening_side:
                continue
            near = self._tree.query(LineString([start, end]), predicate="dwithin", distance=0.5)
            ways, step = self._ways[near], end - start
            lengths = np.hypot(*ways.T)
            cosines = np.abs(ways @ step) / np.maximum(np.linalg.norm(step) * lengths, 1e-12)
            offsets = (start + end) / 2 - self._starts[near]
            across = np.abs(ways[:, 0] * offsets[:, 1] - ways[:, 1] * offsets[:, 0])
            parallel = cosines > 0.98
            if parallel.any():
                nearest = (across[parallel] / lengths[parallel]).min()
                best = min(best, (round(float(nearest), 3), number))
        start, end = lines[best[1]]
        return Segment(name, kind, tuple(start.tolist()), tuple(end.tolist()), *HEIGHTS[kind])


def _along(line: tuple[np.ndarray, np.ndarray], way: np.ndarray) -> float:
    """Return the absolute cosine of the angle between a line and a direction."""
    step = line[1] - line[0]
    return float(abs(step @ way) / max(np.linalg.norm(step) * np.linalg.norm(way), 1e-12))
