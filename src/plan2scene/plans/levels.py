"""Levels and the stairs between them: which rooms a flight joins, and what is odd about it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from shapely.geometry import LineString, Polygon
from shapely.geometry import Point as ShapelyPoint

from plan2scene.house import DEFAULT_HEIGHT, House, Level, Room, Stairs
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.parse import Source

MAX_LEVELS = 50  #: Most levels of a house


@dataclass(frozen=True)
class StairLimits:
    """Limits of levels and flights of stairs, metres."""

    step_off: float = 0.3  #: one steps on and off a flight this far from its ends
    #: A step is at most so high and at least so deep (usual building codes).
    riser: float = 0.19
    tread: float = 0.15
    margin: float = 0.1  #: walls may reach so far into a flight
    least_rise: float = 0.5  #: levels are at least so far apart
    least_flight: float = 0.5  #: A flight is at least so long in plan


STAIRS = StairLimits()


def read_levels(source: Source, document: Mapping[str, Any]) -> tuple[Level, ...]:
    """Return the entries ``levels`` of a file, the lowest first; none where it has none.

    Raises InputError for two levels with one id, or with elevations that are too near. If a level
    has no elevation (another program's form), all are left out with a warning.
    """
    levels = []
    for item in source.items(document.get("levels"), "levels"):
        entry = source.mapping(item, "a level")
        if "elevation" not in entry:
            source.warn("levels with an elevation", "others; read as one storey")
            return ()
        name = source.identifier(entry.get("id"), "a level id")
        elevation = source.number(entry["elevation"], f"the elevation of level {name}")
        height = source.number(entry.get("height", DEFAULT_HEIGHT), f"the height of level {name}")
        levels.append(Level(name, str(entry.get("name") or name)[:100], elevation, height))
    ordered = sorted(levels, key=lambda level: level.elevation)
    if len(ordered) > MAX_LEVELS:
        raise source.fault(f"at most {MAX_LEVELS} levels", len(ordered))
    ids = [level.id for level in ordered]
    for level, above in pairwise(ordered):
        if ids.count(level.id) > 1:
            raise source.fault("each level id once", f"{level.id} {ids.count(level.id)} times")
        if above.elevation - level.elevation < STAIRS.least_rise:
            apart = f"{above.elevation - level.elevation:.2f} m"
            expected = f"levels {level.id} and {above.id} at least {STAIRS.least_rise:g} m apart"
            raise source.fault(expected, apart)
    return tuple(ordered)


def used_levels(
    source: Source, levels: Sequence[Level], rooms: Iterable[Room]
) -> tuple[Level, ...]:
    """Return the levels that have rooms; each other one gives a warning."""
    used = {room.level for room in rooms}
    for level in levels:
        if level.id not in used:
            source.warn(f"rooms on level {level.id}", "none; left out")
    return tuple(level for level in levels if level.id in used)


def level_of(
    source: Source, entry: Mapping[str, Any], levels: Sequence[Level], what: str, room: str = ""
) -> str:
    """Return the id of the level that an entry names; empty where the plan has none."""
    ids = [level.id for level in levels]
    named = entry.get("level")
    if (named in ids) if levels else (named is None):
        return named or ""
    expected = f"one of the levels {', '.join(ids)} for {what}" if ids else f"levels, for {what}"
    raise source.fault(expected, "none" if named is None else repr(named), room)


def read_flight(source: Source, name: str, entry: Mapping[str, Any], level: str) -> Stairs:
    """Return the flight of an entry ``from``, ``to``, ``width``, not yet linked with rooms."""
    start, end = (source.point(entry.get(key), f"stairs {name}") for key in ("from", "to"))
    width = source.number(entry.get("width"), f"the width of stairs {name}")
    stairs = Stairs(name, level, (start[0], start[2]), (end[0], end[2]), width)
    if stairs.length < STAIRS.least_flight or stairs.width <= 0:
        expected = f"stairs {stairs.id} at least {STAIRS.least_flight:g} m long, with a width"
        raise source.fault(expected, f"{stairs.length:.2f} and {stairs.width:.2f} m")
    return stairs


def flight_area(stairs: Stairs) -> Polygon:
    """Return the strip of the plan that a flight takes, (x, z) in metres."""
    start, end = np.array(stairs.start), np.array(stairs.end)
    along = (end - start) / stairs.length
    side = np.array([along[1], -along[0]]) * stairs.width / 2
    return Polygon([start + side, end + side, end - side, start - side])


def step_count(rise: float) -> int:
    """Return how many steps a flight of this rise in metres has."""
    return max(2, math.ceil(rise / STAIRS.riser - 1e-9))


def linked(
    stairs: Iterable[Stairs], rooms: Sequence[Room], levels: Sequence[Level]
) -> tuple[Stairs, ...]:
    """Return flights with the rooms that they join, found where one steps on and off.

    `levels` go from the lowest to the highest; without any, nothing is above.
    """
    above = {level.id: higher.id for level, higher in pairwise(levels)}
    flights = []
    for flight in stairs:
        lower = _room_at(flight, rooms, flight.level, foot=True)
        upper = above.get(flight.level)
        higher = None if upper is None else _room_at(flight, rooms, upper, foot=False)
        flights.append(replace(flight, room_ids=(lower, higher)))
    return tuple(flights)


def _room_at(stairs: Stairs, rooms: Sequence[Room], level: str, *, foot: bool) -> str | None:
    """Return the room of a level at one end of a flight: at a point beyond it, else on it."""
    (x0, z0), (x1, z1) = stairs.start, stairs.end
    ux, uz = (x1 - x0) / stairs.length, (z1 - z0) / stairs.length
    for off in (STAIRS.step_off, -0.05):
        spot = (x0 - off * ux, z0 - off * uz) if foot else (x1 + off * ux, z1 + off * uz)
        for room in rooms:
            if room.level == level and room_polygon(room).covers(ShapelyPoint(spot)):
                return room.id
    return None


def _across(house: House, stairs: Stairs) -> Iterator[str]:
    """Yield the ids of walls, of a flight's level and of the one above, that cross the flight."""
    above = house.level_above(stairs.level)
    levels = {stairs.level, stairs.level if above is None else above.id}
    level_by_room = {room.id: room.level for room in house.rooms}
    area = flight_area(stairs).buffer(-STAIRS.margin)
    for wall in house.walls:
        if level_by_room[wall.room_ids[0]] not in levels:
            continue
        if LineString([wall.start, wall.end]).intersection(area).length > STAIRS.margin:
            yield wall.id


def _doors_into_the_air(house: House) -> Iterator[tuple[str, str, str]]:
    """Yield (expected, found, room) for doors of higher levels that have no room behind."""
    higher = {level.id for level in house.levels[1:]}
    level_by_room = {room.id: room.level for room in house.rooms}
    outer = {(door.room_a, door.opening_id) for door in house.doors if door.room_b is None}
    for wall in house.walls:
        room = wall.room_ids[0]
        for opening in wall.openings:
            drawn = (room, opening.id) in outer and opening.kind == "door"
            if drawn and opening.bottom < STAIRS.riser and level_by_room[room] in higher:
                where = f"door {opening.id} of level {level_by_room[room]}"
                yield f"a room or balcony behind {where}", "none", room


def storey_oddities(house: House) -> Iterator[tuple[str, str, str]]:
    """Yield (expected, found, room) for odd stairs, levels without any, and doors to nowhere."""
    yield from _doors_into_the_air(house)
    elevations = {level.id: level.elevation for level in house.levels}
    for stairs in house.stairs:
        lower, upper = stairs.room_ids
        above = house.level_above(stairs.level)
        if lower is None:
            yield f"stairs {stairs.id} from a room of their level", "none at their foot", ""
        if above is None:
            yield f"a level above stairs {stairs.id}", "none; they end at the ceiling", lower or ""
        elif upper is None:
            expected = f"a room of level {above.id} at the head of stairs {stairs.id}"
            yield expected, "none", lower or ""
        rise = house.rise_of(stairs)
        if (tread := stairs.length / step_count(rise)) < STAIRS.tread:
            found = f"{tread:.2f} m ({stairs.length:.2f} m for a rise of {rise:.2f} m)"
            yield (
                f"steps of stairs {stairs.id} at least {STAIRS.tread:g} m deep",
                found,
                lower or "",
            )
        for wall in _across(house, stairs):
            yield f"stairs {stairs.id} clear of walls", f"wall {wall} across them", lower or ""
    for level in house.levels[:-1]:
        above = house.level_above(level.id)
        if above is not None and not any(
            stairs.level == level.id and None not in stairs.room_ids for stairs in house.stairs
        ):
            yield f"stairs from level {level.id} up to level {above.id}", "none", ""
    for room in house.rooms:
        above = house.level_above(room.level)
        if above is not None:
            limit = above.elevation - elevations[room.level]
            if room.height > limit + 1e-6:
                expected = f"a ceiling below level {above.id}, {limit:g} m up"
                yield expected, f"{room.height:g} m", room.id
