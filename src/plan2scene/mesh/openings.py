"""Openings as passages through walls: both rooms' copies of a hole matched, walls cut, reveals.

In Rent3D++ plans each room has its own walls, so a door is drawn twice, on two walls a few
centimetres apart, sometimes a few centimetres askew. A `Portal` is the one door of both.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from shapely.geometry import LineString, box
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Wall
from plan2scene.mesh.frames import FaceOpening, Frame, inner_normal, openings_on, wall_frame

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
    """One door, window or passage.

    Attributes
    ----------
    hole : FaceOpening
        The copy on the owner's side of the wall.
    side : Side
        That side.
    back : (2, 2) float64
        Plan points of the far edge of the passage, at the left and at the right.
    depth : float
        Metres from the near to the far edge (0 when two rooms touch).
    other : str or None
        The room behind, None for the outside.
    """

    hole: FaceOpening
    side: Side
    back: np.ndarray
    depth: float
    other: str | None

    @property
    def width(self) -> float:
        """Metres along the side's frame."""
        return self.hole.right - self.hole.left


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
    """Match the copies of each hole, measure its passage, and collect what to cut from each side.

    A side loses its own wall's openings; also one that the plan's room-door-room relations lead
    to its room when its own wall has no copy there.
    """
    found = Openings()
    copies: list[Portal] = []
    for side in sides:
        for hole in openings_on(side.wall, side.frame):
            cut = box(hole.left, hole.bottom, hole.right, hole.top)
            found.holes[side.wall.id, side.room_id].append(cut)
            if side.room_id == side.wall.room_ids[0]:
                copies.append(_straight(hole, side, polygons))
    leads_to = _relations(house)
    used: set[int] = set()
    for index, copy in enumerate(copies):
        if index in used:
            continue
        partner = _partner(
            copy, [(k, c) for k, c in enumerate(copies) if k > index and k not in used]
        )
        if partner is not None:
            used.add(partner)
            found.portals.append(_joined(copy, copies[partner]))
            continue
        found.portals.append(copy)
        wanted = leads_to.get(copy.hole.opening.id, set()) - {copy.side.room_id}
        _cut_behind(copy, sides, wanted, found)
    return found


def _relations(house: House) -> dict[str, set[str]]:
    """Return the rooms that each opening leads to."""
    rooms: dict[str, set[str]] = defaultdict(set)
    for door in house.doors:
        rooms[door.opening_id].update(r for r in (door.room_a, door.room_b) if r is not None)
    return rooms


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


def _cut_behind(copy: Portal, sides: list[Side], rooms: set[str], found: Openings) -> None:
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
        mine = found.holes[side.wall.id, side.room_id]
        if not any(other.intersects(hole) for other in mine):
            mine.append(hole)
