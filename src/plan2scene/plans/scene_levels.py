"""Levels and stairs out of scene.json: `arch.levels`, `level` of rooms, `arch.stairs`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from plan2scene.house import DEFAULT_HEIGHT, GROUND, Level, Stairs
from plan2scene.plans.parse import Source
from plan2scene.plans.storeys import level_of, ordered_levels, sound_flight

#: Floors with no other between that are so far apart (metres) are two storeys.
STOREY = 1.8


def read_levels(source: Source, arch: Mapping[str, Any]) -> tuple[Level, ...]:
    """Return the levels of a file, the lowest first; none where it has none.

    Levels in another program's form, without an elevation, are left out with a warning.
    """
    levels = []
    for entry in source.items(arch.get("levels"), "levels"):
        level = source.mapping(entry, "a level")
        if "elevation" not in level:
            source.warn("levels with an elevation", "others; read as one storey")
            return ()
        name = source.identifier(level.get("id"), "a level id")
        elevation = source.number(level.get("elevation"), f"the elevation of level {name}")
        height = source.number(level.get("height", DEFAULT_HEIGHT), f"the height of level {name}")
        levels.append(Level(name, str(level.get("name") or name)[:100], elevation, height))
    return ordered_levels(source, levels)


def levels_of_rooms(
    source: Source, arch: Mapping[str, Any], room_ids: Sequence[str], floors: Mapping[str, float]
) -> tuple[tuple[Level, ...], dict[str, Level]]:
    """Return the levels, and that of each room: by what its entry of `rooms` names.

    Where the file has no levels, `floors` (y in metres by room) that lie a storey apart make some.
    """
    levels = read_levels(source, arch)
    if not levels:
        return _levels_of_floors(room_ids, floors)
    by_id = {level.id: level for level in levels}
    entries = {
        str(entry.get("id")): entry
        for entry in source.items(arch.get("rooms"), "rooms")
        if isinstance(entry, dict)
    }
    found = {
        room_id: by_id[level_of(source, entries.get(room_id, {}), levels, "a room", room_id)]
        for room_id in room_ids
    }
    return levels, found


def _levels_of_floors(
    room_ids: Sequence[str], floors: Mapping[str, float]
) -> tuple[tuple[Level, ...], dict[str, Level]]:
    """Return levels at heights that are `STOREY` apart, none where all floors are nearer."""
    heights = sorted(floors.values())
    starts = [y for k, y in enumerate(heights) if k == 0 or y - heights[k - 1] >= STOREY]
    if len(starts) < 2:
        return (), dict.fromkeys(room_ids, GROUND)
    levels = tuple(
        Level(f"level_{k}", f"Level {k}", y, DEFAULT_HEIGHT) for k, y in enumerate(starts)
    )

    def at(y: float) -> Level:
        return max((level for level in levels if level.elevation <= y), key=lambda v: v.elevation)

    return levels, {room_id: at(floors.get(room_id, starts[0])) for room_id in room_ids}


def read_stairs(source: Source, arch: Mapping[str, Any], levels: Sequence[Level]) -> list[Stairs]:
    """Return the flights of stairs, not yet linked with rooms."""
    flights = []
    for entry in source.items(arch.get("stairs"), "stairs"):
        item = source.mapping(entry, "stairs")
        name = source.identifier(item.get("id"), "an id of stairs")
        start, end = (source.point(item.get(key), f"stairs {name}") for key in ("from", "to"))
        width = source.number(item.get("width"), f"the width of stairs {name}")
        lowest = levels[0].id if levels else ""
        level = level_of(source, item, levels, f"stairs {name}") if "level" in item else lowest
        flight = Stairs(name, level, (start[0], start[2]), (end[0], end[2]), width)
        flights.append(sound_flight(source, flight))
    return flights
