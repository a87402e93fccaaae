"""Checks of a house that every later stage relies on: a fault stops it, a warning does not.

Each is one line. A fault keeps a house from being built. A warning tells what is unlike a real
home: a wrong unit, heights of a doll's house, islands, overlapping rooms.
"""

from __future__ import annotations

import math
import statistics
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely.geometry import Point
from shapely.strtree import STRtree
from shapely.validation import explain_validity

from plan2scene.errors import InputError
from plan2scene.house import OPENING_KINDS, ROOM_TYPES, House, Opening, Room, Wall
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import STAIRS, storey_oddities
from plan2scene.plans.parse import (
    ID_PATTERN,
    MAX_COORDINATE,
    MAX_ID_LENGTH,
    MAX_ITEMS,
    MAX_ROOMS,
    SAME_POINT,
)

#: A plan wider than this (metres), or whose median room is larger (square metres), is a fault.
MAX_EXTENT, MAX_USUAL_AREA = 300.0, 1000.0
#: Bounds of a height in metres. Outside the first pair is a fault, outside the second a warning.
HEIGHTS, USUAL_HEIGHTS = (0.5, 30.0), (1.8, 6.0)
#: Bounds of a plan's width (metres) and of its median room (square metres); outside is a warning.
USUAL_EXTENT, USUAL_AREA = 100.0, (0.3, 60.0)
#: Bounds of the area of each room, square metres; outside is a warning.
ROOM_AREA = (0.05, 500.0)
USUAL_DEPTH = 1.0  #: A wall thicker than this, metres, is a warning
#: Bounds of the median width of doors, and least width of a hole or room, metres; else a warning.
USUAL_DOOR, NARROW = (0.4, 1.6), 0.2
APART = 5.0  #: A group of rooms farther than this (metres) from the others is an island: a warning
#: Names that Windows reserves for devices, with any ending.
DEVICES = {"con", "prn", "aux", "nul", *(f"{d}{k}" for d in ("com", "lpt") for k in range(1, 10))}

_Fault = Callable[..., InputError]
_Line = tuple[str, str, str]  #: (expected, found, room) of a warning


def unit_faults(house: House, fault: _Fault) -> Iterator[InputError]:
    """Yield faults that show a plan not in metres; its outlines must have at least 3 points."""
    extent, area = _extent(house), _usual_area(house)
    if extent > MAX_EXTENT or area > MAX_USUAL_AREA:
        expected = f"a home in metres, at most {MAX_EXTENT:g} m wide"
        found = f"{extent:.0f} m, its usual room {area:.0f} m2 (are these centimetres?)"
        yield fault(expected, found)
    low, high = HEIGHTS
    for room in house.rooms:
        if not low <= room.height <= high:
            yield fault(f"a height of {low:g} to {high:g} m", f"{room.height:g}", room.id)
    for wall in house.walls:
        if wall.height > high:
            expected = f"a wall {wall.id} of at most {high:g} m"
            yield fault(expected, f"{wall.height:g}", wall.room_ids[0])


def oddities(house: House) -> Iterator[_Line]:
    """Yield warnings of what is unusual for a home: scale, heights, islands, holes, names."""
    extent, area = _extent(house), _usual_area(house)
    if extent > USUAL_EXTENT:
        yield f"a home of at most {USUAL_EXTENT:g} m", f"{extent:.0f} m", ""
    low, high = USUAL_AREA
    if not low <= area <= high:
        found = f"{area:.2f} m2 (is the plan's unit the metre?)"
        yield f"a usual room of {low:g} to {high:g} m2", found, ""
    low, high = USUAL_HEIGHTS
    for room in house.rooms:
        if not low <= room.height <= high:
            yield f"a height of {low:g} to {high:g} m", f"{room.height:g}", room.id
    tall = [wall for wall in house.walls if wall.height > high]
    for wall in tall[:1]:
        found = f"{len(tall)}, wall {wall.id} of {wall.height:g} m"
        yield f"walls at most {high:g} m high", found, wall.room_ids[0]
    low, high = ROOM_AREA
    for room in house.rooms:
        polygon = room_polygon(room)
        if not low <= polygon.area <= high:
            yield f"a room of {low:g} to {high:g} m2", f"{polygon.area:.2f} m2", room.id
        elif polygon.buffer(-NARROW / 2).is_empty:
            found = f"about {2 * polygon.area / polygon.length:.2f} m"
            yield f"a room at least {NARROW:g} m wide", found, room.id
    yield from _holes(house)
    thick = [wall for wall in house.walls if wall.depth > USUAL_DEPTH]
    for wall in thick[:1]:
        found = f"{len(thick)}, wall {wall.id} of {wall.depth:.2f} m"
        yield f"walls at most {USUAL_DEPTH:g} m thick", found, wall.room_ids[0]
    for _, storey in house.storeys():
        yield from _islands(storey)
    yield from name_oddities("room ids", [room.id for room in house.rooms])
    yield from name_oddities("a house name", [house.id])


def name_oddities(what: str, names: Iterable[str]) -> Iterator[_Line]:
    """Yield warnings of names that differ by case only, and of names of Windows devices."""
    groups: dict[str, list[str]] = defaultdict(list)
    for name in names:
        groups[name.lower()].append(name)
    for lower, same in groups.items():
        if len(same) > 1:
            found = f"{same[0]} and {same[1]}"
            yield f"{what} that differ by more than upper and lower case", found, same[0]
        if lower.split(".")[0] in DEVICES:
            yield f"{what} that every system takes as a file name", same[0], same[0]


def _extent(house: House) -> float:
    """Return the longer side in metres of the rooms' box."""
    points = np.array([p for room in house.rooms for ring in room.rings for p in ring])
    return float(np.ptp(points, axis=0).max())


def _usual_area(house: House) -> float:
    return statistics.median(room_polygon(room).area for room in house.rooms)


def _holes(house: House) -> Iterator[_Line]:
    """Yield warnings of very narrow holes, and of doors of an unusual median width."""
    doors = []
    for wall in house.walls:
        for opening in wall.openings:
            width = opening.end - opening.start
            doors += [width] if opening.kind == "door" else []
            if width < NARROW:
                expected = f"hole {opening.id} of at least {NARROW:g} m"
                yield expected, f"{width:.3f} m", wall.room_ids[0]
    low, high = USUAL_DOOR
    if doors and not low <= (median_width := statistics.median(doors)) <= high:
        found = f"{median_width:.2f} m (is the plan's unit the metre?)"
        yield f"a usual door of {low:g} to {high:g} m", found, ""


def _islands(house: House) -> Iterator[_Line]:
    """Yield a warning of rooms that stand apart from the first room's group."""
    polygons = [room_polygon(room) for room in house.rooms]
    near = STRtree(polygons).query(polygons, predicate="dwithin", distance=APART)
    shape = (len(polygons), len(polygons))
    _, group = connected_components(coo_array((np.ones(len(near[0])), near), shape))
    first, others = np.flatnonzero(group == group[0]), np.flatnonzero(group != group[0])
    if len(others):
        far = min(polygons[others[0]].distance(polygons[k]) for k in first)
        found = f"{len(others)} apart from the others, the first by {far:.1f} m"
        yield f"rooms within {APART:g} m of each other", found, house.rooms[others[0]].id


MIN_AREA = 0.01  #: A room with less area than this (square metres) is a drawing fault
#: If an outline of more corners crosses itself, its area is not computed: it takes quadratic time.
MANY_CORNERS = 200
#: Rooms may overlap by this share of the smaller one (walls drawn on both sides of their line).
OVERLAP_SHARE = 0.02
MAX_OVERLAPS = 200  #: Largest number of overlapping pairs of rooms of a storey that are reported
ROUNDING = 1e-3  #: A hole may reach this far (metres) over its wall through rounding
#: A wall whose middle is farther (metres) from its room's outline is in the wrong place.
STRAY_DISTANCE = 0.5


def validate_house(house: House, *, file: str | Path = "") -> list[str]:
    """Return the warnings of a house (its reader's and those found here).

    Raises InputError for the first fault of :func:`house_faults`.
    """
    for fault in house_faults(house, file=file):
        raise fault
    lines = list(house.warnings)
    storeys = [storey for _, storey in house.storeys()]
    oddity_lines = [line for storey in storeys for line in _overlaps(storey)]
    oddity_lines += [*_stray_walls(house), *_overlapping_holes(house), *oddities(house)]
    oddity_lines += storey_oddities(house)
    for expected, text, room in oddity_lines:
        lines.append(str(InputError(expected, text, file=file, house=house.id, room=room)))
    return lines


def house_faults(house: House, *, file: str | Path = "") -> Iterator[InputError]:
    """Yield every fault that keeps a house from being built, most basic first.

    Ids, numbers of elements, room types, coordinates, outlines (self-intersecting, without area),
    walls, holes (outside their wall, top not above bottom), door relations.
    """

    def fault(expected: str, found: object, room: str = "") -> InputError:
        return InputError(expected, str(found), file=file, house=house.id, room=room)

    if not 1 <= len(house.rooms) <= MAX_ROOMS:
        yield fault(f"1 to {MAX_ROOMS} rooms", len(house.rooms))
        return
    if len(house.walls) > MAX_ITEMS:
        yield fault(f"at most {MAX_ITEMS} walls", len(house.walls))
        return
    yield from _id_faults(house, fault)
    for room in house.rooms:
        yield from _room_faults(room, fault)
    if all(room.rings and min(map(len, room.rings)) >= 3 for room in house.rooms):
        yield from unit_faults(house, fault)
    yield from _level_faults(house, fault)
    for wall in house.walls:
        yield from _wall_faults(house, wall, fault)
    room_ids = {room.id for room in house.rooms}
    for door in house.doors:
        for room_id in (door.room_a, door.room_b):
            if room_id is not None and room_id not in room_ids:
                yield fault(f"rooms of this plan at door {door.opening_id}", room_id)


def _id_faults(house: House, fault: _Fault) -> Iterator[InputError]:
    """Yield ids that can't name files, and ids used twice."""
    groups: list[tuple[str, Iterable[str]]] = [
        ("house name", [house.id]),
        ("room id", [room.id for room in house.rooms]),
        ("wall id", [wall.id for wall in house.walls]),
        ("level id", [level.id for level in house.levels]),
        ("stairs id", [stairs.id for stairs in house.stairs]),
    ]
    for what, ids in groups:
        for name, count in Counter(ids).items():
            if len(name) > MAX_ID_LENGTH or not ID_PATTERN.fullmatch(name):
                yield fault(f"a {what} of letters, digits, '_', '-' and '.'", repr(name))
            if count > 1:
                yield fault(f"each {what} once", f"{name} {count} times")


def _level_faults(house: House, fault: _Fault) -> Iterator[InputError]:
    """Yield rooms on no level, walls of rooms on two, and flights without a length."""
    ids = [level.id for level in house.levels] or [""]
    level_of = {room.id: room.level for room in house.rooms}
    for room in house.rooms:
        if room.level not in ids:
            yield fault(f"one of the levels {', '.join(ids)}", repr(room.level), room.id)
    for wall in house.walls:
        if len({level_of.get(room_id) for room_id in wall.room_ids}) > 1:
            yield fault(f"rooms of one level at wall {wall.id}", ", ".join(wall.room_ids))
    for stairs in house.stairs:
        if stairs.level not in ids:
            found = repr(stairs.level)
            yield fault(f"one of the levels {', '.join(ids)} for stairs {stairs.id}", found)
        numbers = (*stairs.start, *stairs.end, stairs.width)
        sound = all(math.isfinite(v) and abs(v) <= MAX_COORDINATE for v in numbers)
        if not sound or stairs.length < STAIRS.least_flight or stairs.width <= 0:
            found = f"{stairs.length:g} and {stairs.width:g} m"
            yield fault(f"stairs {stairs.id} with a length and a width", found)


def _room_faults(room: Room, fault: _Fault) -> Iterator[InputError]:
    """Yield what is wrong with a room's types, coordinates, outline and height."""
    if not room.types:
        yield fault("at least one room type", "none", room.id)
    for name in room.types:
        if name not in ROOM_TYPES:
            yield fault(f"a room type ({', '.join(ROOM_TYPES)})", repr(name), room.id)
    numbers = [room.height, *(v for ring in room.rings for point in ring for v in point)]
    if not all(math.isfinite(v) and abs(v) <= MAX_COORDINATE for v in numbers):
        yield fault(f"finite coordinates within {MAX_COORDINATE:g} m", "others", room.id)
        return
    if room.height <= 0:
        yield fault("a height above 0 m", f"{room.height:g}", room.id)
    if not room.rings or any(len(ring) < 3 for ring in room.rings):
        yield fault("an outline of at least 3 points", "fewer", room.id)
        return
    polygon = room_polygon(room)
    many = sum(map(len, room.rings)) > MANY_CORNERS
    if not polygon.is_valid and (many or polygon.buffer(0).area >= MIN_AREA):
        yield fault("an outline that doesn't cross itself", explain_validity(polygon), room.id)
    elif polygon.area < MIN_AREA:
        yield fault(f"an area of at least {MIN_AREA:g} m2", f"{polygon.area:.4f}", room.id)


def _wall_faults(house: House, wall: Wall, fault: _Fault) -> Iterator[InputError]:
    """Yield what is wrong with a wall and its holes."""
    room_ids = {room.id for room in house.rooms}
    if not 1 <= len(wall.room_ids) <= 2 or not set(wall.room_ids) <= room_ids:
        yield fault(f"one or two rooms of this plan at wall {wall.id}", ", ".join(wall.room_ids))
        return
    room = wall.room_ids[0]
    numbers = (*wall.start, *wall.end, wall.height, wall.depth, wall.extra_height)
    if not all(math.isfinite(v) and abs(v) <= MAX_COORDINATE for v in numbers):
        yield fault(f"wall {wall.id} within {MAX_COORDINATE:g} m", "other numbers", room)
        return
    if wall.length <= SAME_POINT or wall.height <= 0 or wall.depth < 0:
        found = f"{wall.length:g}, {wall.height:g}, {wall.depth:g}"
        yield fault(f"wall {wall.id} with length and height above 0, depth not below", found, room)
    if len(wall.openings) > MAX_ITEMS:
        yield fault(f"at most {MAX_ITEMS} holes on wall {wall.id}", len(wall.openings), room)
        return
    for name, count in Counter(opening.id for opening in wall.openings).items():
        if count > 1:
            yield fault(f"each hole id once on wall {wall.id}", f"{name} {count} times", room)
    for opening in wall.openings:
        yield from _opening_faults(wall, opening, fault)


def _opening_faults(wall: Wall, opening: Opening, fault: _Fault) -> Iterator[InputError]:
    """Yield what is wrong with a hole."""
    room = wall.room_ids[0]
    name = f"hole {opening.id} on wall {wall.id}"
    if not ID_PATTERN.fullmatch(opening.id) or opening.kind not in OPENING_KINDS:
        found = f"{opening.id!r}, {opening.kind!r}"
        yield fault(f"an id and one of {', '.join(OPENING_KINDS)} for {name}", found, room)
    if not opening.start < opening.end:
        yield fault(f"{name} with a width", f"{opening.start:g} to {opening.end:g} m", room)
    if not opening.bottom < opening.top:
        found = f"{opening.bottom:g} to {opening.top:g} m"
        yield fault(f"{name} with its top above its bottom", found, room)
    for way, low, high, limit in (
        ("along", opening.start, opening.end, wall.length),
        ("up", opening.bottom, opening.top, wall.height),
    ):
        if not (low >= -ROUNDING and high <= limit + ROUNDING):
            found = f"{low:.3f} to {high:.3f} m"
            yield fault(f"{name}, {way} within 0 to {limit:.3f} m", found, room)


def _overlaps(house: House) -> Iterator[tuple[str, str, str]]:
    """Yield (expected, found, room) for each two rooms that overlap."""
    polygons = [room_polygon(room) for room in house.rooms]
    tree = STRtree(polygons)
    told = 0
    for i, j in sorted(zip(*tree.query(polygons, predicate="intersects"), strict=True)):
        if i >= j or told >= MAX_OVERLAPS:
            continue
        area = polygons[i].intersection(polygons[j]).area
        if area > OVERLAP_SHARE * min(polygons[i].area, polygons[j].area):
            told += 1
            found = f"{area:.2f} m2 shared with room {house.rooms[j].id}"
            yield "rooms that don't overlap", found, house.rooms[i].id


def _stray_walls(house: House) -> Iterator[tuple[str, str, str]]:
    """Yield (expected, found, room) for each wall that is far from its room's outline."""
    outlines = {room.id: room_polygon(room).boundary for room in house.rooms}
    for wall in house.walls:
        (x0, z0), (x1, z1) = wall.start, wall.end
        middle = Point((x0 + x1) / 2, (z0 + z1) / 2)
        for room_id in wall.room_ids:
            distance = outlines[room_id].distance(middle)
            if distance > STRAY_DISTANCE:
                yield f"wall {wall.id} on the room's outline", f"{distance:.2f} m from it", room_id


def _overlapping_holes(house: House) -> Iterator[tuple[str, str, str]]:
    """Yield (expected, found, room) for each two holes of a wall that overlap."""
    for wall in house.walls:
        ordered = sorted(wall.openings, key=lambda opening: opening.start)
        for one, other in pairwise(ordered):
            apart = one.end <= other.start + ROUNDING
            if not apart and max(one.bottom, other.bottom) < min(one.top, other.top):
                found = f"{one.id} and {other.id}"
                yield f"holes of wall {wall.id} apart", found, wall.room_ids[0]
