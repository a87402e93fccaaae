"""Drawings of several storeys, one above the other, and the house that they mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from plan2scene.errors import InputError
from plan2scene.house import House, IconBox, Level, Room, Stairs
from plan2scene.plans.parse import Source
from plan2scene.plans.storeys import LEAST_FLIGHT, LEAST_RISE, linked
from plan2scene_app.plan_formats.drawing import Drawing, free_id, house_of_drawing

#: Words of a piece's name that mean stairs.
STAIR_WORDS = frozenset(
    {"stairs", "staircase", "stair", "treppe", "escalier", "escalera", "scala", "scale", "trap"}
)
#: A model whose lowest floor is farther than this from 0 (metres) is counted from that floor.
FAR = 20.0


@dataclass(frozen=True)
class DrawnStorey:
    """A storey's name as written, its floor's elevation in metres, and what is drawn on it."""

    name: str
    elevation: float
    drawing: Drawing


def house_of_storeys(source: Source, storeys: Iterable[DrawnStorey]) -> House:
    """Return the house of drawings one above the other; one drawing is a house without levels.

    Of storeys at nearly one elevation the largest is read; the others, and storeys on which
    nothing is a room, are left out with a warning. Raises InputError where none has rooms.
    """
    given = _apart(source, sorted(storeys, key=lambda storey: storey.elevation))
    if len(given) == 1:
        return house_of_drawing(source, given[0].drawing)
    found: list[tuple[Level, House]] = []
    stairs: list[Stairs] = []
    taken: set[str] = set()
    names: set[str] = set()
    fault: InputError | None = None
    base = given[0].elevation if given and abs(given[0].elevation) > FAR else 0.0
    for storey in given:
        try:
            house = house_of_drawing(source, storey.drawing, taken)
        except InputError as error:
            fault = error
            source.warnings.append(f"{error} on level {storey.name}; left out")
            continue
        height = storey.drawing.height
        level = Level(free_id(storey.name, names), storey.name, storey.elevation - base, height)
        found.append((level, house))
        stairs += [replace(flight, level=level.id) for flight in storey.drawing.stairs]
    if not found:
        raise fault or source.fault("storeys with rooms", "none")
    return _joined(source, found, stairs)


def _apart(source: Source, storeys: Sequence[DrawnStorey]) -> list[DrawnStorey]:
    """Return storeys, which come by elevation, without those beside a larger one."""
    kept: list[DrawnStorey] = []
    for storey in storeys:
        if not kept or storey.elevation - kept[-1].elevation >= LEAST_RISE:
            kept.append(storey)
            continue
        small, large = sorted((kept[-1], storey), key=lambda one: one.drawing.size())
        kept[-1] = large
        expected = f"levels at least {LEAST_RISE:g} m apart"
        source.warn(expected, f"{small.name} beside {large.name}; left out")
    return kept


def _joined(
    source: Source, storeys: Sequence[tuple[Level, House]], stairs: Sequence[Stairs]
) -> House:
    """Return one house of those of several levels; a single one stays without levels."""
    if len(storeys) == 1:
        return replace(storeys[0][1], warnings=tuple(source.warnings))
    levels = tuple(level for level, _ in storeys)
    renamed = [_on_level(level, house) for level, house in storeys]
    rooms = [room for house in renamed for room in house.rooms]
    pieces = [icon for house in renamed for icon in house.icons]
    known = [flight for flight in stairs if flight.level != levels[-1].id]
    flights = (*linked(known, rooms, levels), *flights_of(pieces, rooms, levels))
    flights = tuple(replace(flight, id=f"stairs_{k}") for k, flight in enumerate(flights))
    return House(
        id=source.house_id,
        rooms=tuple(rooms),
        walls=tuple(wall for house in renamed for wall in house.walls),
        doors=tuple(door for house in renamed for door in house.doors),
        icons=tuple(icon for icon in pieces if not _climbs(icon, levels)),
        levels=levels,
        stairs=flights,
        warnings=tuple(source.warnings),
    )


def _on_level(level: Level, house: House) -> House:
    """Return a house with all on a level, and openings named after it."""

    def named(opening_id: str) -> str:
        return f"{level.id}_{opening_id}"

    walls = [
        replace(wall, openings=tuple(replace(o, id=named(o.id)) for o in wall.openings))
        for wall in house.walls
    ]
    return replace(
        house,
        rooms=tuple(replace(room, level=level.id) for room in house.rooms),
        walls=tuple(walls),
        doors=tuple(replace(door, opening_id=named(door.opening_id)) for door in house.doors),
        icons=tuple(replace(icon, level=level.id) for icon in house.icons),
    )


def _climbs(icon: IconBox, levels: Sequence[Level]) -> bool:
    """Return whether a piece is stairs to a level above its own."""
    words = re.findall(r"[a-zäöüéè]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", icon.type).lower())
    sides = (abs(icon.p2[0] - icon.p1[0]), abs(icon.p2[1] - icon.p1[1]))
    return (
        bool(STAIR_WORDS.intersection(words))
        and icon.level != levels[-1].id
        and max(sides) >= LEAST_FLIGHT
        and min(sides) > 0
    )


def flights_of(
    icons: Iterable[IconBox], rooms: Sequence[Room], levels: Sequence[Level]
) -> tuple[Stairs, ...]:
    """Return the stairs among pieces of furniture as flights along their longer side.

    Files do not tell which end is up: it is the one from which more rooms are reached.
    """
    flights: list[Stairs] = []
    for icon in icons:
        if not _climbs(icon, levels):
            continue
        (x0, z0), (x1, z1) = icon.p1, icon.p2
        if abs(x1 - x0) >= abs(z1 - z0):
            middle = (z0 + z1) / 2
            start, end, width = (x0, middle), (x1, middle), abs(z1 - z0)
        else:
            middle = (x0 + x1) / 2
            start, end, width = (middle, z0), (middle, z1), abs(x1 - x0)
        both = [Stairs("", icon.level, *ends, width) for ends in ((start, end), (end, start))]
        ways = linked(both, rooms, levels)
        flights.append(min(ways, key=lambda way: way.room_ids.count(None)))
    return tuple(flights)
