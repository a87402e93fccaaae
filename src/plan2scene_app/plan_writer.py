"""Convert a house to the format of ``plan.schema.json``, which the editor opens."""

from __future__ import annotations

import statistics
from typing import Any

import numpy as np

from plan2scene.house import USUAL, House, IconBox, Level, Point, Stairs
from plan2scene.plans.geometry import point_along, room_polygon
from plan2scene.plans.plan_json import DEFAULT_DEPTH, FORMAT, SNAP_TOLERANCE, plan_schema
from plan2scene.plans.wall_sides import find_openings, room_sides

#: Decimal places of a coordinate in metres.
_DIGITS = 4


def house_to_plan(house: House) -> dict[str, Any]:
    """Return a house as a document of ``plan.schema.json``.

    Levels, rooms, types, heights, openings, stairs and icons are kept. Walls are not written: the
    reader makes them from the rooms' outlines, all with the median thickness of this house's walls.
    Object models are left out. If two rooms have walls of their own with one hole through both,
    it is written as one opening, midway between the walls if they are close enough.
    """
    depths = [wall.depth for wall in house.walls] or [DEFAULT_DEPTH]
    limits = plan_schema()["properties"]["wall_depth"]
    depth = min(max(statistics.median(depths), limits["minimum"]), limits["maximum"])
    rooms = []
    for room in house.rooms:
        entry: dict[str, Any] = {"id": room.id, **({"name": room.name} if room.name else {})}
        entry |= {"types": list(room.types), "polygon": _ring(room.rings[0])}
        if room.rings[1:]:
            entry["holes"] = [_ring(ring) for ring in room.rings[1:]]
        rooms.append({**entry, "height": round(room.height, _DIGITS), **_on(room.level)})
    plan: dict[str, Any] = {"format": FORMAT, "version": 1}
    plan |= {"name": house.name} if house.name else {}
    plan["wall_depth"] = round(depth, _DIGITS)
    plan |= {"heights": USUAL} if house.heights else {}
    if house.levels:
        plan["levels"] = [_level_entry(level) for level in house.levels]
    plan.update(rooms=rooms, openings=_opening_entries(house))
    if house.stairs:
        plan["stairs"] = [_flight_entry(stairs) for stairs in house.stairs]
    if house.icons:
        plan["fixtures"] = [_fixture_entry(icon) for icon in house.icons]
    return plan


def _fixture_entry(icon: IconBox) -> dict[str, Any]:
    return {"type": icon.type, "from": _point(icon.p1), "to": _point(icon.p2), **_on(icon.level)}


def _on(level_id: str) -> dict[str, str]:
    """Return the entry that names the level of a thing; empty in a plan without levels."""
    return {"level": level_id} if level_id else {}


def _level_entry(level: Level) -> dict[str, Any]:
    heights = {"elevation": level.elevation, "height": level.height}
    rounded = {key: round(value, _DIGITS) for key, value in heights.items()}
    return {"id": level.id, "name": level.name, **rounded}


def _flight_entry(stairs: Stairs) -> dict[str, Any]:
    ends = {"from": _point(stairs.start), "to": _point(stairs.end)}
    return {"id": stairs.id, **ends, "width": round(stairs.width, _DIGITS), **_on(stairs.level)}


def _opening_entries(house: House) -> list[dict[str, Any]]:
    """Return every opening once, as a segment; one through two close walls lies midway."""
    entries: dict[str, dict[str, Any]] = {}
    for level, storey in house.storeys():
        polygons = {room.id: room_polygon(room) for room in storey.rooms}
        for portal in find_openings(storey, room_sides(storey, polygons), polygons).portals:
            wall, opening = portal.side.wall, portal.hole.opening
            if opening.guessed:  # it is not in the plan; an import guesses it again
                continue
            ends = np.array([point_along(wall, s) for s in (opening.start, opening.end)])
            if portal.other and len(wall.room_ids) == 1 and portal.depth <= 2 * SNAP_TOLERANCE:
                ends = _midway(ends, portal.back)
            entry = {
                "id": opening.id,
                "kind": opening.kind,
                "from": _point(ends[0]),
                "to": _point(ends[1]),
                "bottom": round(max(opening.bottom, 0.0), _DIGITS),
                "top": round(opening.top, _DIGITS),
                **_on(level.id),
            }
            entries.setdefault(opening.id, entry)
    return list(entries.values())


def _midway(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the segment (2, 2) midway between two facing ones, along their common extent."""
    way = (one[1] - one[0]) / np.linalg.norm(one[1] - one[0])
    along = np.sort((other - one[0]) @ way)
    across = other.mean(axis=0) - one.mean(axis=0)
    start = max(along[0], 0.0)
    end = min(along[1], (one[1] - one[0]) @ way)
    return one[0] + (across - across @ way * way) / 2 + np.outer((start, end), way)


def _ring(ring: tuple[Point, ...]) -> list[list[float]]:
    return [_point(point) for point in ring]


def _point(point: Point | np.ndarray) -> list[float]:
    return [round(float(value), _DIGITS) + 0.0 for value in point]
