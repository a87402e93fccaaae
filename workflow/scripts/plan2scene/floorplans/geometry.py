"""Plane geometry of plans: polygons, the inner side of walls, walls from outlines, doors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from shapely.geometry import LineString, Polygon
from shapely.geometry import Point as ShapelyPoint

from plan2scene.house import Door, Point, Ring, Room, Wall

#: Outlines closer than this (metres) share one wall when walls are made from outlines.
SHARED_TOLERANCE = 0.01
#: A room whose outline is this near (metres) to a door, beyond the wall's depth, is behind it.
BEHIND_TOLERANCE = 0.1


def room_polygon(room: Room) -> Polygon:
    """Return a room's outline with its holes as a polygon in (x, z), metres."""
    return Polygon(room.rings[0], room.rings[1:])


def inner_normal(room: Room, wall: Wall) -> Point:
    """Return the unit normal (x, z) of `wall` that points into `room`.

    Decided by which side of the wall's line the room's polygon has more area near the wall, not
    by the order of the points; the left side (of start to end, x right, z down) when neither.
    """
    (x0, z0), (x1, z1) = wall.start, wall.end
    length = wall.length
    ux, uz = (x1 - x0) / length, (z1 - z0) / length
    normal = (uz, -ux)
    polygon = room_polygon(room)
    reach = 0.5
    areas = []
    for sign in (1.0, -1.0):
        dx, dz = sign * reach * normal[0], sign * reach * normal[1]
        strip = Polygon([(x0, z0), (x1, z1), (x1 + dx, z1 + dz), (x0 + dx, z0 + dz)])
        areas.append(polygon.intersection(strip).area)
    sign = 1.0 if areas[0] >= areas[1] else -1.0
    return (sign * normal[0], sign * normal[1])


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
    an opening of the same id, else the nearest other room whose outline is within the wall's
    depth and `BEHIND_TOLERANCE` of the opening's middle; None (outside) when there is none.
    """
    walls = list(walls)
    owners: dict[str, list[str]] = {}
    for wall in walls:
        for opening in wall.openings:
            owners.setdefault(opening.id, []).append(wall.room_ids[0])
    polygons = {room.id: room_polygon(room) for room in rooms}
    doors: dict[tuple[str, frozenset[str | None]], Door] = {}
    for wall in walls:
        for opening in wall.openings:
            if opening.kind == "window":
                continue
            room_a = wall.room_ids[0]
            others = [*wall.room_ids[1:], *(r for r in owners[opening.id] if r != room_a)]
            middle = point_along(wall, (opening.start + opening.end) / 2)
            room_b = others[0] if others else _room_near(middle, room_a, wall.depth, polygons)
            key = (opening.id, frozenset((room_a, room_b)))
            doors.setdefault(key, Door(room_a, opening.id, room_b))
    return tuple(doors.values())


def _room_near(
    point: Point, not_room: str, depth: float, polygons: dict[str, Polygon]
) -> str | None:
    """Return the room nearest to `point` within the depth of a wall, other than `not_room`."""
    near = [
        (polygon.distance(ShapelyPoint(point)), room_id)
        for room_id, polygon in polygons.items()
        if room_id != not_room
    ]
    distance, room_id = min(near, default=(math.inf, ""))
    return room_id if distance <= depth + BEHIND_TOLERANCE else None


@dataclass
class _Segment:
    """A piece of an outline: its ends, and the rooms that have it."""

    start: Point
    end: Point
    room_ids: list[str]


def walls_of_rooms(rooms: Sequence[Room], *, depth: float = 0.1, shared: bool = True) -> list[Wall]:
    """Return walls along the rooms' outlines, in the order of rooms and edges.

    With `shared`, edges are split where another room's corner lies on them (within
    `SHARED_TOLERANCE`), and a piece that two rooms have is one wall with both room ids. A shared
    wall is as high as the higher of the two rooms.
    """
    corners = [point for room in rooms for ring in room.rings for point in ring] if shared else []
    segments: list[_Segment] = []
    for room in rooms:
        for ring in room.rings:
            for edge in ring_edges(ring):
                for start, end in _split(edge, corners):
                    _add_segment(segments, _Segment(start, end, [room.id]), shared)
    heights = {room.id: room.height for room in rooms}
    walls = []
    counts: dict[str, int] = {}
    for segment in segments:
        owner = segment.room_ids[0]
        number = counts.get(owner, 0)
        counts[owner] = number + 1
        walls.append(
            Wall(
                id=f"{owner}_wall_{number}",
                room_ids=tuple(segment.room_ids),
                start=segment.start,
                end=segment.end,
                height=max(heights[room_id] for room_id in segment.room_ids),
                depth=depth,
            )
        )
    return walls


def _split(edge: tuple[Point, Point], corners: Sequence[Point]) -> list[tuple[Point, Point]]:
    """Return `edge` cut at the corners that lie on it."""
    start, end = edge
    line = LineString(edge)
    cuts = []
    for corner in corners:
        at = ShapelyPoint(corner)
        ends_off = min(math.dist(corner, start), math.dist(corner, end)) > SHARED_TOLERANCE
        if ends_off and line.distance(at) <= SHARED_TOLERANCE:
            cuts.append(line.project(at))
    stops = [0.0]
    for cut in sorted(cuts):
        if cut - stops[-1] > SHARED_TOLERANCE:
            stops.append(cut)
    points = [start]
    points += [(p.x, p.y) for p in (line.interpolate(stop) for stop in stops[1:])]
    points.append(end)
    return list(pairwise(points))


def _add_segment(segments: list[_Segment], new: _Segment, shared: bool) -> None:
    """Append `new`, or give its room to the other room's segment between the same ends."""
    for old in segments if shared else []:
        if len(old.room_ids) > 1 or old.room_ids == new.room_ids:
            continue
        same = max(math.dist(old.start, new.start), math.dist(old.end, new.end))
        turned = max(math.dist(old.start, new.end), math.dist(old.end, new.start))
        if min(same, turned) <= 1.5 * SHARED_TOLERANCE:
            old.room_ids.extend(new.room_ids)
            return
    segments.append(new)
