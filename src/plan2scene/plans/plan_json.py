"""Reader of the program's own small JSON plan, ``plan.schema.json`` (docs/floorplans.md)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.errors import InputError, schema_fault
from plan2scene.house import DEFAULT_HEIGHT, USUAL, House, IconBox, Level, Room, Stairs, Wall
from plan2scene.plans.geometry import find_doors, walls_of_rooms
from plan2scene.plans.levels import level_of, linked, read_flight, read_levels, used_levels
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import Source
from plan2scene.plans.plan_file import PlanFormat

FORMAT = "plan2scene-plan"
DEFAULT_DEPTH = 0.1  #: Thickness in metres of the walls (as in the schema)
SNAP_TOLERANCE = 0.2  #: An opening this near (metres) to a wall's line lies on it


@cache
def plan_schema() -> dict[str, Any]:
    """Return the JSON schema of the format."""
    text = Path(__file__).with_name("plan.schema.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def house_of_plan(document: Any, house_id: str, *, file: str = "") -> House:
    """Return the house of a parsed plan JSON.

    Walls follow the outlines; where two outlines coincide they share one. Openings lie on the
    walls within `SNAP_TOLERANCE` metres; doors join the rooms on both sides of their wall.

    Raises InputError for the first entry that the schema forbids, for a level that the plan lacks,
    and for an opening without a wall nearby.
    """
    source = Source(file, house_id)
    source.identifier(house_id, "a house name")
    _check_schema(source, document)
    levels = read_levels(source, document)
    heights = {level.id: level.height for level in levels}
    has_heights = any(
        "height" in entry for key in ("rooms", "levels") for entry in document.get(key, [])
    )
    rooms = []
    for entry in document["rooms"]:
        rings = [
            source.outline(ring, entry["id"])
            for ring in (entry["polygon"], *entry.get("holes", []))
        ]
        level = level_of(source, entry, levels, f"room {entry['id']}", entry["id"])
        height = float(entry.get("height", heights.get(level, DEFAULT_HEIGHT)))
        types = dict.fromkeys(source.room_type(name, entry["id"]) for name in entry["types"])
        name = source.shown_name(entry.get("name"))
        rooms.append(Room(entry["id"], tuple(types), tuple(rings), height, level, name))
    lacking = [entry["id"] for entry in document["rooms"] if "height" not in entry and not levels]
    if has_heights and lacking:
        found = f"none of {', '.join(lacking)[:100]}; {DEFAULT_HEIGHT:g} m used"
        source.warn("a height of every room, or of none", found)
    levels = used_levels(source, levels, rooms)
    source.limit_corners(rooms)
    walls = walls_of_rooms(rooms, depth=float(document.get("wall_depth", DEFAULT_DEPTH)))
    segments = _segments(source, document.get("openings", []), levels)
    walls = _with_openings(source, rooms, walls, segments)
    return House(
        id=house_id,
        rooms=tuple(rooms),
        walls=tuple(walls),
        doors=find_doors(rooms, walls),
        levels=levels,
        stairs=linked(_stairs(source, document.get("stairs", []), levels), rooms, levels),
        icons=_icons(source, document.get("fixtures", []), levels),
        name=source.shown_name(document.get("name")),
        heights="" if has_heights and document.get("heights") != USUAL else USUAL,
        warnings=tuple(source.warnings),
    )


def _with_openings(
    source: Source, rooms: Sequence[Room], walls: Sequence[Wall], segments: dict[str, list[Segment]]
) -> list[Wall]:
    """Return the walls with the openings of their level, level by level.

    An opening that fits only a wall of another level is left out with a warning.
    """
    level_by_room = {room.id: room.level for room in rooms}
    by_level: dict[str, list[Wall]] = {}
    for wall in walls:
        by_level.setdefault(level_by_room[wall.room_ids[0]], []).append(wall)
    placed = []
    for level, level_walls in by_level.items():
        level_segments = segments.get(level, [])
        try:
            placed += place_openings(source, level_walls, level_segments, tolerance=SNAP_TOLERANCE)
        except InputError:
            other_walls = [
                wall for name, walls in by_level.items() if name != level for wall in walls
            ]
            level_segments = [
                s for s in level_segments if _on_level(source, s, level, level_walls, other_walls)
            ]
            placed += place_openings(source, level_walls, level_segments, tolerance=SNAP_TOLERANCE)
    return placed


def _on_level(
    source: Source, segment: Segment, level: str, own: Sequence[Wall], others: Sequence[Wall]
) -> bool:
    """Return whether to place an opening on its level; warn if it fits only another level."""

    def fits(walls: Sequence[Wall]) -> bool:
        scratch = Source(source.file, source.house_id)
        try:
            place_openings(scratch, walls, [segment], tolerance=SNAP_TOLERANCE)
        except InputError:
            return False
        return True

    if not others or fits(own) or not fits(others):
        return True
    expected = f"opening {segment.id} on a wall of its level {level}"
    source.warn(expected, "one on a wall of another level; left out")
    return False


def _stairs(source: Source, entries: list[dict[str, Any]], levels: Sequence[Level]) -> list[Stairs]:
    """Return the flights as drawn; a flight without an id gets one."""
    flights = []
    for number, entry in enumerate(entries):
        name = entry.get("id", f"stairs_{number}")
        level = level_of(source, entry, levels, f"stairs {name}")
        flights.append(read_flight(source, name, entry, level))
    return flights


def _icons(
    source: Source, entries: list[dict[str, Any]], levels: Sequence[Level]
) -> tuple[IconBox, ...]:
    """Return the fixtures as drawn."""
    icons = []
    for entry in entries:
        what = f"a {entry['type']}"
        corners = np.array([[source.number(v, what) for v in entry[key]] for key in ("from", "to")])
        (x0, z0), (x1, z1) = np.sort(corners, axis=0).tolist()
        level = level_of(source, entry, levels, what)
        icons.append(IconBox(entry["type"], (x0, z0), (x1, z1), level))
    return tuple(icons)


def _segments(
    source: Source, entries: list[dict[str, Any]], levels: Sequence[Level]
) -> dict[str, list[Segment]]:
    """Return the openings as drawn, by level; an opening without an id gets one."""
    segments: dict[str, list[Segment]] = {}
    seen: set[str] = set()
    for number, entry in enumerate(entries):
        name = entry.get("id", f"opening_{number}")
        if name in seen:
            raise source.fault("each opening id once", f"{name} twice")
        seen.add(name)
        ends = [[source.number(v, f"opening {name}") for v in entry[key]] for key in ("from", "to")]
        bottom, top = (source.number(entry[key], f"{key} of {name}") for key in ("bottom", "top"))
        if bottom >= top:
            found = f"{bottom:g} to {top:g} m"
            raise source.fault(f"opening {name} with its top above its bottom", found)
        (x0, z0), (x1, z1) = ends
        level = level_of(source, entry, levels, f"opening {name}")
        segment = Segment(name, entry["kind"], (x0, z0), (x1, z1), bottom, top)
        segments.setdefault(level, []).append(segment)
    return segments


def _check_schema(source: Source, document: Any) -> None:
    """Raise InputError for the first place where a document violates the schema."""
    from jsonschema import Draft202012Validator

    error = next(Draft202012Validator(plan_schema()).iter_errors(document), None)
    if error is None:
        return
    room = ""
    place = list(error.absolute_path)
    if len(place) > 1 and place[0] == "rooms":
        entry = document["rooms"][place[1]]
        room = str(entry.get("id", "")) if isinstance(entry, dict) else ""
    raise source.fault(*schema_fault(error), room)


PLAN_FORMAT = PlanFormat(
    "plan2scene-plan JSON",
    lambda plan: isinstance(plan.document, dict) and str(plan.document.get("format")) == FORMAT,
    lambda plan: house_of_plan(plan.document, plan.house_id, file=str(plan.path)),
    suffixes=(".json",),
    lacks_heights=lambda plan: FORMAT.encode() in plan.head,
)
