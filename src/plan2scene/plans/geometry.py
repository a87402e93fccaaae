"""Plane geometry of plans: polygons of rooms, walls from outlines, doors."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise, product

import numpy as np
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry import Polygon
from shapely.strtree import STRtree

from plan2scene.errors import InputError
from plan2scene.house import Door, Point, Ring, Room, Wall

#: Outlines closer than this (metres) share one wall when walls are made from outlines.
SHARED_TOLERANCE = 0.01
MAX_WALLS = 20_000  #: Largest number of walls that are made from outlines
#: A room is behind a door if its outline is within the wall's depth plus this (metres) of it.
BEHIND_TOLERANCE = 0.1


def room_polygon(room: Room) -> Polygon:
    """Return a room's outline with its holes as a polygon in (x, z), metres."""
    return Polygon(room.rings[0], room.rings[1:])


def point_along(wall: Wall, distance: float) -> Point:
    """Return the point (x, z) `distance` metres along a wall from its first point."""
    t = distance / wall.length
    return (
        wall.start[0] + t * (wall.end[0] - wall.start[0]),
        wall.start[1] + t * (wall.end[1] - wall.start[1]),
    )


def ring_edges(ring: Ring) -> list[tuple[Point, Point]]:
    """Return the edges of a closed ring in order."""
    return list(zip(ring, ring[1:] + ring[:1], strict=True))


def find_doors(rooms: Sequence[Room], walls: Iterable[Wall]) -> tuple[Door, ...]:
    """Return the room-door-room relations that the walls' doors and passages make.

    The room behind an opening is the wall's second room, else the room of another wall that has
    an opening of the same id, else the nearest other room of its level whose outline is within the
    wall's depth and `BEHIND_TOLERANCE` of the opening's middle; None (outside) when there is none.
    """
    walls = list(walls)
    owners: dict[str, list[str]] = {}
    for wall in walls:
        for opening in wall.openings:
            owners.setdefault(opening.id, []).append(wall.room_ids[0])
    level_of = {room.id: room.level for room in rooms}
    by_level: dict[str, list[Room]] = {}
    for room in rooms:
        by_level.setdefault(room.level, []).append(room)
    behind = {level: _RoomsNear(level_rooms) for level, level_rooms in by_level.items()}
    doors: dict[tuple[str, frozenset[str | None]], Door] = {}
    for wall in walls:
        for opening in wall.openings:
            if opening.kind == "window":
                continue
            room_a = wall.room_ids[0]
            near = behind[level_of[room_a]].of
            other_rooms = [*wall.room_ids[1:], *(r for r in owners[opening.id] if r != room_a)]
            middle = point_along(wall, (opening.start + opening.end) / 2)
            room_b = other_rooms[0] if other_rooms else near(middle, room_a, wall.depth)
            key = (opening.id, frozenset((room_a, room_b)))
            doors.setdefault(key, Door(room_a, opening.id, room_b))
    return tuple(doors.values())


class _RoomsNear:
    """Finds the room of a level that is near a point."""

    def __init__(self, rooms: Sequence[Room]) -> None:
        self._ids = [room.id for room in rooms]
        self._polygons = [room_polygon(room) for room in rooms]
        self._tree = STRtree(self._polygons)

    def of(self, point: Point, not_room: str, depth: float) -> str | None:
        """Return the room nearest to `point` within the depth of a wall, other than `not_room`."""
        spot = ShapelyPoint(point)
        found = self._tree.query(spot, predicate="dwithin", distance=depth + BEHIND_TOLERANCE)
        near = [(self._polygons[k].distance(spot), self._ids[k]) for k in found]
        return min((pair for pair in near if pair[1] != not_room), default=(0.0, None))[1]


def walls_of_rooms(rooms: Sequence[Room], *, depth: float = 0.1, shared: bool = True) -> list[Wall]:
    """Return walls along the rooms' outlines, in the order of rooms and edges.

    With `shared`, edges are split where another room's corner lies on them (within
    `SHARED_TOLERANCE`), and a piece that two rooms have is one wall with both room ids. A shared
    wall is as high as the higher of the two rooms. Rooms of different levels share nothing.
    """
    levels = list(dict.fromkeys(room.level for room in rooms))
    groups = ([room for room in rooms if room.level == level] for level in levels)
    return [wall for group in groups for wall in _walls_of_level(group, depth, shared=shared)]


def _walls_of_level(rooms: Sequence[Room], depth: float, *, shared: bool) -> list[Wall]:
    """Return the walls of rooms of one level; see :func:`walls_of_rooms`."""
    points = [point for room in rooms for ring in room.rings for point in ring] if shared else []
    corners = np.array(points, dtype=np.float64).reshape(-1, 2)
    pieces = _Pieces()
    for room in rooms:
        for ring in room.rings:
            for start, end in ring_edges(ring):
                for piece in pairwise(_split(start, end, corners)):
                    pieces.add(piece, room.id, shared)
                if len(pieces.ends) > MAX_WALLS:
                    raise InputError(f"outlines that make at most {MAX_WALLS} walls", "more")
    heights = {room.id: room.height for room in rooms}
    counts: Counter[str] = Counter()
    walls = []
    for (start, end), room_ids in zip(pieces.ends, pieces.room_ids, strict=True):
        owner = room_ids[0]
        height = max(heights[room_id] for room_id in room_ids)
        name = f"{owner}_wall_{counts[owner]}"
        walls.append(Wall(name, tuple(room_ids), start, end, height, depth))
        counts[owner] += 1
    return walls


def _split(start: Point, end: Point, corners: np.ndarray) -> list[Point]:
    """Return the edge's ends and, between them, the (n, 2) `corners` that lie on it, in order."""
    a, b = np.array(start), np.array(end)
    length = float(np.linalg.norm(b - a))
    direction = (b - a) / length
    along = (corners - a) @ direction
    across = np.abs((corners - a) @ np.array([-direction[1], direction[0]]))
    inside = (along > SHARED_TOLERANCE) & (along < length - SHARED_TOLERANCE)
    points = [start]
    last = 0.0
    for k in sorted(np.flatnonzero(inside & (across <= SHARED_TOLERANCE)), key=lambda k: along[k]):
        if along[k] - last > SHARED_TOLERANCE:
            last = float(along[k])
            cut = a + last * direction
            points.append((float(cut[0]), float(cut[1])))
    return [*points, end]


class _Pieces:
    """Pieces of outlines and the one or two rooms that each bounds, found by their middle."""

    def __init__(self) -> None:
        self.ends: list[tuple[Point, Point]] = []
        self.room_ids: list[list[str]] = []
        self._by_middle: dict[tuple[int, int], list[int]] = {}

    def add(self, piece: tuple[Point, Point], room_id: str, shared: bool) -> None:
        """Add a piece, or give its room to the other room's piece between the same ends."""
        (x0, z0), (x1, z1) = piece
        cell = 5 * SHARED_TOLERANCE
        i, j = math.floor((x0 + x1) / 2 / cell), math.floor((z0 + z1) / 2 / cell)
        near = [
            number
            for di, dj in product((-1, 0, 1), repeat=2)
            for number in self._by_middle.get((i + di, j + dj), [])
        ]
        for number in sorted(near) if shared else []:
            others = self.room_ids[number]
            if len(others) == 1 and others[0] != room_id and _same(self.ends[number], piece):
                others.append(room_id)
                return
        self._by_middle.setdefault((i, j), []).append(len(self.ends))
        self.ends.append(piece)
        self.room_ids.append([room_id])


def _same(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    """Return whether two pieces have the same ends, either way round."""
    same = max(math.dist(one[0], other[0]), math.dist(one[1], other[1]))
    turned = max(math.dist(one[0], other[1]), math.dist(one[1], other[0]))
    return min(same, turned) <= 1.5 * SHARED_TOLERANCE
