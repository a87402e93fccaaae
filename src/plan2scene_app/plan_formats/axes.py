"""Walls as axes with a thickness: of areas, of openings in them, and the rooms that they close."""

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

#: Thickness in metres of a wall that has none.
DEFAULT_THICKNESS = 0.1
#: Most wall axes of a plan.
MAX_AXES = 5000
#: Most pairs of walls that meet, and of lines of walls side by side.
MAX_PAIRS = 200_000
#: Bottom and top in metres of an opening whose file gives none.
HEIGHTS = {"door": (0.0, 2.05), "passage": (0.0, 2.2), "window": (0.9, 2.1)}


@dataclass(frozen=True)
class DrawingSettings:
    """The tuned numbers of reading other programs' drawings.

    Metres and square metres as buildings and their drawings usually have them, set by hand; which
    files of other programs are read with them is in docs/measurements/formats.md.
    """

    # Walls as axes.
    join: float = 0.02  #: m within which ends of axes meet
    least_reach: float = 0.08  #: m that a loose end reaches at least, however thin the walls
    grid: float = 1e-3  #: m that crossings are rounded to
    room_area: float = 0.3  #: m2: smaller faces are the inside of walls
    room_width: float = 0.3  #: m: narrower ones, too
    wall_angle: float = math.radians(10)  #: rad between a room's edge and the wall along it
    # Walls as lines.
    faces: tuple[float, float] = (0.04, 0.6)  #: m between the two faces of a wall
    face_angle: float = math.radians(2.0)  #: rad between them
    shared: float = 0.5  #: share of the shorter face that the other goes along
    covered: float = 0.7  #: share of a line with faces opposite from which it needs no other
    touch: float = 0.05  #: m within which lines of one door or window touch
    panes: float = 0.4  #: m between its parallel lines
    overlap: float = 0.05  #: m that a wall through an opening goes on into the wall beside it
    thin: float = 0.5  #: m: a thinner face between lines is a wall's body
    rectangle: float = 0.85  #: share of the rectangle around it that a wall's outline fills
    flat: float = 0.02  #: m between a curve and the lines that it is cut into
    arc_step: float = math.radians(15.0)  #: rad that a piece of a curved wall turns at most
    # Gaps between walls in line.
    gap: tuple[float, float] = (0.5, 1.3)  #: m of a gap that is a passage
    gap_room: float = 2.5  #: m2 of the smallest room that a gap closes
    in_line: float = math.radians(8.0)  #: rad between the walls beside it
    off_line: float = 0.15  #: m between their lines
    # What is unlikely.
    most_height: float = 6.0  #: m of a room
    most_floor: tuple[float, float] = (6000.0, 50_000.0)  #: m2 of a storey: a doubt, none
    bordering: float = 0.6  #: share of the walls that border a room, below which it is a doubt
    # Rooms and openings.
    drawn_share: float = 0.1  #: share of a face that drawn rooms cover, below which it is a room
    agreement: float = 0.1  #: share by which scales of areas written in rooms may differ
    same_opening: float = 0.4  #: m between the middles of two openings that are one
    opening_side: float = 0.35  #: m of an opening's shortest side along its wall
    at_hinge: float = 0.1  #: m between a hinge and a side that goes through it
    opening_slack: float = 0.1  #: m between an opening and the face of its wall
    opening_reach: float = 0.3  #: m between it and a wall of unknown thickness
    widths: tuple[float, float] = (0.4, 6.0)  #: m of doors and windows in DXF
    sill: float = 0.3  #: m: an opening that begins higher is a window
    walled: float = 0.2  #: share of a line between two rooms with walls, below which it is open
    passage: float = 0.5  #: m of the shortest such passage
    far: float = 20.0  #: m from 0 beyond which the lowest floor is taken for 0


SETTINGS = DrawingSettings()


@dataclass(frozen=True)
class WallAxis:
    """A wall by the segment (x, z) in its middle; metres.

    Thickness 0: the segment is the wall's face, as scans have it. Height 0: not known.
    """

    start: house.Point
    end: house.Point
    thickness: float = DEFAULT_THICKNESS
    height: float = 0.0


def distinct(axes: Iterable[WallAxis]) -> list[WallAxis]:
    """Return walls once each: of several between the same ends (to `SETTINGS.grid`) the first.

    It is as thick and as high as the thickest and the highest of them.
    """
    once: dict[tuple[tuple[int, int], ...], WallAxis] = {}
    for axis in axes:
        key = same_ends(axis.start, axis.end)
        first = once.get(key, axis)
        thickness, height = max(first.thickness, axis.thickness), max(first.height, axis.height)
        once[key] = replace(first, thickness=thickness, height=height)
    return list(once.values())


def same_ends(start: Sequence[float], end: Sequence[float]) -> tuple[tuple[int, int], ...]:
    """Return a key that segments between the same ends have, to `SETTINGS.grid`, either way."""
    ends = [(round(x / SETTINGS.grid), round(z / SETTINGS.grid)) for x, z in (start, end)]
    return tuple(sorted(ends))


def limit_pairs(lines: Sequence[LineString], distance: float, what: str) -> None:
    """Raise InputError where more than `MAX_PAIRS` pairs of lines are within a distance.

    They are counted a few lines at a time: the count takes no more time than its limit.
    """
    tree, count, step = STRtree(lines), 0, 50
    for k in range(0, len(lines), step):
        pairs = tree.query(lines[k : k + step], predicate="dwithin", distance=distance)
        count += pairs.shape[1]
        if count > 2 * MAX_PAIRS + len(lines):
            raise InputError(f"at most {MAX_PAIRS} pairs of {what}", "more")


def rooms_of_axes(source: Source, axes: Sequence[WallAxis]) -> list[Polygon]:
    """Return the floors between walls: the faces that the axes close, less the walls' bodies.

    A loose end is drawn on to the axis whose body it touches. Sorted from top to bottom, then
    left to right; no face at all is an empty list.

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
    """Return pieces that join walls in line, from an end to the end that faces it.

    A piece lies between two ends that nothing joins, or outside all rooms that the walls close: a
    corridor between two walls in line stays open.
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
    """Return for each end (index into `ends` (2n, 2)) the nearest one that faces it in line."""
    from scipy.spatial import cKDTree  # a third of a second that no other format needs

    outward = ends - ends.reshape(-1, 2, 2)[:, ::-1].reshape(-1, 2)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    pairs = cKDTree(ends).query_pairs(SETTINGS.gap[1], output_type="ndarray")
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    found: dict[int, tuple[float, int]] = {}
    for one, other in (pairs.T, pairs.T[::-1]):
        steps, ways = ends[other] - ends[one], outward[one]
        along = (steps * ways).sum(1)
        across = np.abs(steps[:, 0] * ways[:, 1] - steps[:, 1] * ways[:, 0])
        straight = -(ways * outward[other]).sum(1) >= math.cos(SETTINGS.in_line)
        near = across <= SETTINGS.off_line + thickness[one // 2] / 2
        fits = straight & near & (along >= SETTINGS.gap[0]) & (along <= SETTINGS.gap[1])
        for k in np.flatnonzero(fits & (one // 2 != other // 2)):
            best = found.get(int(one[k]), (math.inf, -1))
            found[int(one[k])] = min(best, (float(along[k]), int(other[k])))
    return [(end, other) for end, (_, other) in sorted(found.items())]


def _is_free(end: np.ndarray, own: int, lines: Sequence[LineString], tree: STRtree) -> bool:
    """Return whether no other wall is at an end; a stroke across it, as doors have, is none."""
    place = Point(end)
    near = tree.query(place, predicate="dwithin", distance=SETTINGS.touch)
    return not any(k != own and lines[k].length > SETTINGS.room_width for k in near)


def is_floor(face: Polygon) -> bool:
    """Return whether a face between walls is large and wide enough for a room."""
    return face.area >= SETTINGS.room_area and not face.buffer(-SETTINGS.room_width / 2).is_empty


def _joined(axes: Sequence[WallAxis]) -> list[WallAxis]:
    """Return the axes with near ends made one, and loose ends drawn to the wall they touch."""
    from scipy.spatial import cKDTree  # a third of a second that no other format needs

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
    """Return where a loose end (index into `points` (2n, 2)) meets the nearest other axis.

    That is the crossing of both lines, when the bodies of both walls, `thickness` (n,) m, touch
    there.
    """
    own = end // 2
    here, other_end = points[end], points[end ^ 1]
    direction = here - other_end
    direction = direction / max(float(np.linalg.norm(direction)), 1e-9)
    half = thickness[own] / 2
    reach = max(half + thickness.max() / 2, SETTINGS.least_reach) + SETTINGS.join
    others = tree.query(lines[own].buffer(reach))
    others = others[others != own]
    across = points[2 * others + 1] - points[2 * others]
    turns = direction[0] * across[:, 1] - direction[1] * across[:, 0]
    turned = np.abs(turns) > 0.17 * np.linalg.norm(across, axis=1)
    others, across, turns = others[turned], across[turned], turns[turned]
    offsets = points[2 * others] - here
    steps = (offsets[:, 0] * across[:, 1] - offsets[:, 1] * across[:, 0]) / turns
    limits = np.maximum(half + thickness[others] / 2, SETTINGS.least_reach) + SETTINGS.join
    for n in np.argsort(np.abs(steps), kind="stable"):
        place = here + steps[n] * direction
        if abs(steps[n]) <= limits[n] and lines[others[n]].distance(Point(place)) <= limits[n]:
            return np.asarray(place)
    return None


def _body(axis: WallAxis) -> Polygon:
    """Return the area of a wall, drawn on by half its thickness at both ends."""
    return LineString([axis.start, axis.end]).buffer(axis.thickness / 2, cap_style="square")


def _plain(room: Polygon) -> Polygon:
    """Return a room without points on straight lines and slivers of the grid."""
    plain = room.simplify(2 * SETTINGS.grid)
    return plain if plain.is_valid and plain.area > 0 else room


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
    """Return the cosine between a line and a direction."""
    step = line[1] - line[0]
    return float(abs(step @ way) / max(np.linalg.norm(step) * np.linalg.norm(way), 1e-12))
