"""Each room's side of each wall, and the openings through walls as both rooms see them.

A side's local axes are s (metres to the right as seen from inside the room) and y (up). In Rent3D++
plans each room has its own walls, so a door is drawn twice, on two walls a few centimetres apart,
sometimes a few centimetres askew. A `Portal` joins the two to one door.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from shapely.geometry import LineString, Point, Polygon, box
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Opening, Room, Wall

_PROBES = (0.01, 0.05, 0.2)  #: Distances from the wall line at which a room is looked for, metres

#: Wall faces stand this far inside their room, metres. Otherwise a partition between rooms behind,
#: which ends on the face's line, would shine through at its edge.
LIFT = 2e-4
_BEHIND = 0.5  #: A wall with an indoor room this near behind it, metres, is no railing


@dataclass(frozen=True)
class Frame:
    """A vertical rectangle seen from its visible side; ``right = (normal_z, -normal_x)``."""

    left: np.ndarray  #: plan point (x, z) of the lower left corner, (2,) float64
    right: np.ndarray  #: unit vector along the rectangle, to the right
    normal: np.ndarray  #: unit vector towards the viewer
    length: float  #: metres

    def plan(self, s: np.ndarray | float, out: float = 0.0) -> np.ndarray:
        """Return plan points at `s` along the face and `out` metres in front of it."""
        along = np.asarray(s, dtype=np.float64)[..., None] * self.right
        return self.left + along + out * self.normal

    def world(self, sy: np.ndarray) -> np.ndarray:
        """Return (n, 3) world points of (n, 2) local points (s, y)."""
        plan = self.plan(sy[:, 0])
        return np.stack([plan[:, 0], sy[:, 1], plan[:, 1]], axis=1)

    def moved(self, out: float) -> Frame:
        """Return the same rectangle `out` metres nearer to the viewer."""
        return Frame(self.left + out * self.normal, self.right, self.normal, self.length)

    def axes(self, s: float, out: float = 0.0) -> np.ndarray:
        """Return a (4, 3) box frame: right, up, normal, and the floor point at `s`."""
        x, z = self.plan(s, out)
        return np.array(
            [
                [self.right[0], 0.0, self.right[1]],
                [0.0, 1.0, 0.0],
                [self.normal[0], 0.0, self.normal[1]],
                [x, 0.0, z],
            ]
        )


@dataclass(frozen=True)
class FaceOpening:
    """An opening as seen on a face: metres from the face's left end, and above the floor."""

    opening: Opening
    left: float
    right: float
    bottom: float
    top: float


def frame_between(start: np.ndarray, end: np.ndarray, normal: np.ndarray) -> Frame:
    """Return the frame of a vertical face over a plan segment that looks along `normal`."""
    right = np.array([normal[1], -normal[0]])
    left = start if start @ right <= end @ right else end
    return Frame(left, right, normal, float(np.linalg.norm(end - start)))


def wall_frame(wall: Wall, normal: np.ndarray) -> Frame:
    """Return the frame of a wall's line seen from the side of `normal`."""
    return frame_between(np.array(wall.start), np.array(wall.end), normal)


def inner_normal(wall: Wall, polygon: BaseGeometry) -> np.ndarray:
    """Return the (2,) unit plan vector from a wall towards the room it bounds.

    Points on both sides of the line vote; when they cannot tell (a wall in the middle of its
    room, or off its outline) the room's centre decides, then the left of start-to-end.
    """
    start, end = np.array(wall.start), np.array(wall.end)
    along = (end - start) / wall.length
    normal = np.array([along[1], -along[0]])
    votes = 0
    for share in (0.5, 0.25, 0.75, 0.1, 0.9):
        middle = start + share * (end - start)
        for distance in _PROBES:
            votes += shapely.contains_xy(polygon, *(middle + distance * normal))
            votes -= shapely.contains_xy(polygon, *(middle - distance * normal))
    if votes == 0:
        centre = np.array(polygon.centroid.coords[0])
        votes = 1 if (centre - start) @ normal >= 0 else -1
    return normal if votes > 0 else -normal


def openings_on(wall: Wall, frame: Frame) -> Iterator[FaceOpening]:
    """Yield a wall's openings as seen on its frame, cut to the wall, if any area is left."""
    from_start = np.array(wall.start) @ frame.right <= np.array(wall.end) @ frame.right
    for opening in wall.openings:
        low, high = max(opening.start, 0.0), min(opening.end, wall.length)
        left, right = (low, high) if from_start else (wall.length - high, wall.length - low)
        bottom, top = max(opening.bottom, 0.0), min(opening.top, wall.height)
        if right - left > 1e-6 and top - bottom > 1e-6:
            yield FaceOpening(opening, left, right, bottom, top)


def walked_rings(room: Room) -> list[np.ndarray]:
    """Return a room's rings, closed, (n + 1, 2), walked to the right as seen from inside.

    An outline then turns from x to z, a hole the other way round.
    """
    rings = []
    for number, ring in enumerate(room.rings):
        exterior = Polygon(ring).exterior
        coordinates = np.asarray(exterior.coords)
        rings.append(coordinates if exterior.is_ccw == (number == 0) else coordinates[::-1])
    return rings


def arc_offset(room: Room, frame: Frame) -> float:
    """Return where a face's left end lies along its room's outline, metres.

    Outlines are walked to the right as seen from inside, so a texture continues round a corner.
    """
    middle = Point(*frame.plan(frame.length / 2))
    line = min((LineString(ring) for ring in walked_rings(room)), key=middle.distance)
    return float(line.project(middle)) - frame.length / 2


def reveal_quads(
    frame: Frame, hole: FaceOpening, back: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the left jamb, right jamb, head and sill of a hole, each (4, 3), facing inwards.

    Seen from the hole, corners run counter-clockwise. `back` is the (2, 2) plan points of the
    far edge, at the left and at the right.
    """

    def at(plan: np.ndarray, y: float) -> np.ndarray:
        return np.array([plan[0], y, plan[1]])

    (a, b), (c, d) = frame.plan(np.array([hole.left, hole.right])), back
    bottom, top = hole.bottom, hole.top
    left = np.array([at(a, bottom), at(c, bottom), at(c, top), at(a, top)])
    right = np.array([at(d, bottom), at(b, bottom), at(b, top), at(d, top)])
    head = np.array([at(a, top), at(c, top), at(d, top), at(b, top)])
    sill = np.array([at(a, bottom), at(b, bottom), at(d, bottom), at(c, bottom)])
    return left, right, head, sill


#: Two copies of a hole lie on walls at most this far apart, metres.
MATCH_DISTANCE = 0.6
_PARALLEL = 0.9


@dataclass(frozen=True)
class Side:
    """One room's side of a wall: its face."""

    wall: Wall
    room_id: str
    frame: Frame


@dataclass(frozen=True)
class Portal:
    """One door, window or passage."""

    hole: FaceOpening  #: the copy on the owner's side of the wall
    side: Side  #: that side
    back: np.ndarray  #: (2, 2) float64, plan points of the far edge, at the left and at the right
    depth: float  #: metres from the near to the far edge (0 when two rooms touch)
    other: str | None  #: the room behind, None for the outside

    @property
    def width(self) -> float:
        """Metres along the side's frame."""
        return self.hole.right - self.hole.left

    @property
    def has_threshold(self) -> bool:
        """Whether the floor goes on through the wall: of doors and passages with some depth."""
        return self.depth >= 1e-4 and self.hole.bottom <= 0.02


@dataclass
class Openings:
    """What :func:`find_openings` returns: the portals, and the holes to cut from each side."""

    portals: list[Portal] = field(default_factory=list)
    holes: dict[tuple[str, str], list[BaseGeometry]] = field(
        default_factory=lambda: defaultdict(list)
    )

    def hole(self, side: Side) -> BaseGeometry:
        """Return the union of a side's holes in its local (s, y) axes."""
        return unary_union(self.holes.get((side.wall.id, side.room_id), []))


def room_sides(house: House, polygons: Mapping[str, BaseGeometry]) -> list[Side]:
    """Return the face of every room on every wall.

    The second room's face of a shared wall stands where its own outline is, when that is within
    twice the wall's depth behind the line.
    """
    sides = []
    for wall in house.walls:
        if wall.length < 1e-6:
            continue
        first = wall.room_ids[0]
        normal = inner_normal(wall, polygons[first])
        sides.append(Side(wall, first, wall_frame(wall, normal)))
        for other in wall.room_ids[1:]:
            frame = wall_frame(wall, -normal)
            gap = distance_behind(sides[-1].frame, polygons[other], 2 * wall.depth)
            sides.append(Side(wall, other, frame.moved(gap or 0.0)))
    return sides


def distance_behind(frame: Frame, geometry: BaseGeometry, reach: float) -> float | None:
    """Return how far behind a face's middle a geometry begins, None when beyond `reach`."""
    if reach <= 0.0:
        return None
    s = frame.length / 2
    ray = LineString([frame.plan(s), frame.plan(s, -reach)])
    hit = ray.intersection(geometry)
    return None if hit.is_empty else float(hit.distance(ray.boundary.geoms[0]))


def find_openings(
    house: House, sides: list[Side], polygons: Mapping[str, BaseGeometry]
) -> Openings:
    """Match the two copies of each hole, measure its depth, and collect the holes of each side.

    A side has its own wall's openings. It also has an opening of another wall that leads to its
    room by the plan's room-door-room relations, if its own wall has no copy there.
    """
    openings = Openings()
    copies: list[Portal] = []
    for side in sides:
        for hole in openings_on(side.wall, side.frame):
            cut = box(hole.left, hole.bottom, hole.right, hole.top)
            openings.holes[side.wall.id, side.room_id].append(cut)
            if side.room_id == side.wall.room_ids[0]:
                copies.append(_straight(hole, side, polygons))
    leads_to: dict[str, set[str | None]] = defaultdict(set)
    for door in house.doors:
        leads_to[door.opening_id] |= {door.room_a, door.room_b}
    used: set[int] = set()
    for index, copy in enumerate(copies):
        if index in used:
            continue
        partner = _partner(
            copy, [(k, c) for k, c in enumerate(copies) if k > index and k not in used]
        )
        if partner is not None:
            used.add(partner)
            openings.portals.append(_joined(copy, copies[partner]))
            continue
        openings.portals.append(copy)
        _cut_behind(copy, sides, leads_to[copy.hole.opening.id] - {copy.side.room_id}, openings)
    return openings


def _straight(hole: FaceOpening, side: Side, polygons: Mapping[str, BaseGeometry]) -> Portal:
    """Return a portal that runs straight back to the next room or through the wall's depth."""
    frame = replace(side.frame, left=side.frame.plan(hole.left), length=hole.right - hole.left)
    depth, other = side.wall.depth, None
    for room_id, polygon in polygons.items():
        gap = None if room_id == side.room_id else distance_behind(frame, polygon, depth)
        if gap is not None and gap < depth:
            depth, other = gap, room_id
    for room_id in side.wall.room_ids[1:]:
        other = other or room_id
    back = side.frame.plan(np.array([hole.left, hole.right]), -depth)
    return Portal(hole, side, back, depth, other)


def _partner(copy: Portal, others: Iterable[tuple[int, Portal]]) -> int | None:
    """Return the index of the other room's copy of a hole, None when there is none.

    It faces the other way, lies within `MATCH_DISTANCE` behind, and overlaps in both directions;
    the same id wins, then the larger overlap.
    """
    best, best_score = None, 0.0
    frame = copy.side.frame
    for index, other in others:
        theirs = other.side.frame
        if other.side.room_id == copy.side.room_id or theirs.normal @ frame.normal > -_PARALLEL:
            continue
        ends = theirs.plan(np.array([other.hole.left, other.hole.right])) - frame.left
        behind = -(ends @ frame.normal).mean()
        if not -0.1 < behind < MATCH_DISTANCE:
            continue
        s = ends @ frame.right
        overlap = min(copy.hole.right, s.max()) - max(copy.hole.left, s.min())
        rise = min(copy.hole.top, other.hole.top) - max(copy.hole.bottom, other.hole.bottom)
        if overlap < 0.4 * min(copy.width, other.width) or rise <= 0:
            continue
        score = overlap + (10.0 if other.hole.opening.id == copy.hole.opening.id else 0.0)
        if score > best_score:
            best, best_score = index, score
    return best


def _joined(copy: Portal, other: Portal) -> Portal:
    """Return the portal from one copy of a hole to the other."""
    ends = other.side.frame.plan(np.array([other.hole.right, other.hole.left]))
    depth = float(-((ends - copy.side.frame.left) @ copy.side.frame.normal).mean())
    return replace(copy, back=ends, depth=max(depth, 0.0), other=other.side.room_id)


def _cut_behind(
    copy: Portal, sides: list[Side], rooms: set[str | None], openings: Openings
) -> None:
    """Cut a hole, known to lead to `rooms`, from their walls when these have no copy of it."""
    ends = copy.side.frame.plan(np.array([copy.hole.left, copy.hole.right]))
    for side in sides:
        if side.wall.id == copy.side.wall.id or side.room_id not in rooms:
            continue
        if side.frame.normal @ copy.side.frame.normal > -_PARALLEL:
            continue
        offset = (ends - side.frame.left) @ side.frame.normal
        s = np.sort((ends - side.frame.left) @ side.frame.right)
        s0, s1 = max(float(s[0]), 0.0), min(float(s[1]), side.frame.length)
        top = min(copy.hole.top, side.wall.height)
        if not -MATCH_DISTANCE < offset.mean() < 0.1 or s1 - s0 < 0.05:
            continue
        hole = box(s0, copy.hole.bottom, s1, top)
        side_holes = openings.holes[side.wall.id, side.room_id]
        if not any(other.intersects(hole) for other in side_holes):
            side_holes.append(hole)


def railing_sides(
    house: House, sides: Sequence[Side], polygons: Mapping[str, BaseGeometry]
) -> list[Side]:
    """Return the railings: sides of rooms in the open air, no opening, no indoor room behind."""
    open_air = {room.id for room in house.rooms if room.open_air}
    indoors = unary_union([polygons[room.id] for room in house.rooms if room.id not in open_air])
    openings = []
    for side in sides:
        wall, frame = side.wall, side.frame
        if not open_air.issuperset(wall.room_ids) or wall.openings:
            continue
        ends = np.array([0.0, frame.length])
        strip = Polygon([*frame.plan(ends), *frame.plan(ends[::-1], -_BEHIND)])
        if strip.intersection(indoors).area < 0.1 * strip.area:
            openings.append(side)
    return openings


def face_ends(frame: Frame, polygon: BaseGeometry) -> tuple[float, float]:
    """Return (s0, s1) of a face, longer by `LIFT` where its room goes on round the corner."""
    probe = 0.005
    points = frame.plan(np.array([-probe, frame.length + probe]), probe)
    left, right = (bool(shapely.contains_xy(polygon, *point)) for point in points)
    lift = min(LIFT, 1e-3 * frame.length)
    return -lift * left, frame.length + lift * right
