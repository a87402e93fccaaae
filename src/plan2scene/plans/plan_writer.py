"""Any house as this program's own plan JSON: what the editor opens."""

from __future__ import annotations

import statistics
from typing import Any

from plan2scene.house import House, Level, Opening, Point, Stairs, Wall
from plan2scene.plans.geometry import point_along
from plan2scene.plans.plan_json import DEFAULT_DEPTH, FORMAT, SNAP_TOLERANCE, plan_schema

#: Places after the point of a coordinate in metres.
_DIGITS = 4


def house_to_plan(house: House) -> dict[str, Any]:
    """Return a house as a document of ``plan.schema.json``.

    Levels, rooms, types, heights, openings and stairs stay; walls follow the outlines again when
    it is read, all with the usual thickness of this house's. Objects and icons are left out. A
    hole that two rooms have in walls of their own is one opening, between them where both are
    near enough.
    """
    depths = [wall.depth for wall in house.walls] or [DEFAULT_DEPTH]
    limits = plan_schema()["properties"]["wall_depth"]
    depth = min(max(statistics.median(depths), limits["minimum"]), limits["maximum"])
    rooms = []
    for room in house.rooms:
        entry = {"id": room.id, "types": list(room.types), "polygon": _ring(room.rings[0])}
        if room.rings[1:]:
            entry["holes"] = [_ring(ring) for ring in room.rings[1:]]
        rooms.append({**entry, "height": round(room.height, _DIGITS), **_on(room.level)})
    plan: dict[str, Any] = {"format": FORMAT, "version": 1, "wall_depth": round(depth, _DIGITS)}
    if house.levels:
        plan["levels"] = [_level(level) for level in house.levels]
    plan.update(rooms=rooms, openings=_openings(house))
    if house.stairs:
        plan["stairs"] = [_flight(stairs) for stairs in house.stairs]
    return plan


def _on(level_id: str) -> dict[str, str]:
    """Return the entry of what is on a level; none in a plan without levels."""
    return {"level": level_id} if level_id else {}


def _level(level: Level) -> dict[str, Any]:
    heights = {"elevation": level.elevation, "height": level.height}
    rounded = {key: round(value, _DIGITS) for key, value in heights.items()}
    return {"id": level.id, "name": level.name, **rounded}


def _flight(stairs: Stairs) -> dict[str, Any]:
    ends = {"from": _point(stairs.start), "to": _point(stairs.end)}
    return {"id": stairs.id, **ends, "width": round(stairs.width, _DIGITS), **_on(stairs.level)}


def _openings(house: House) -> list[dict[str, Any]]:
    """Return every opening once, as a segment."""
    found: dict[str, list[tuple[Wall, Opening]]] = {}
    for wall in house.walls:
        for opening in wall.openings:
            found.setdefault(opening.id, []).append((wall, opening))
    entries = []
    for name, places in found.items():
        (wall, opening), *others = places
        start, end = _ends(wall, opening)
        if others:
            start, end = _between((start, end), _ends(*others[0]))
        entries.append(
            {
                "id": name,
                "kind": opening.kind,
                "from": _point(start),
                "to": _point(end),
                "bottom": round(max(opening.bottom, 0.0), _DIGITS),
                "top": round(opening.top, _DIGITS),
                **_on(house.room(wall.room_ids[0]).level),
            }
        )
    return entries


def _ends(wall: Wall, opening: Opening) -> tuple[Point, Point]:
    return point_along(wall, opening.start), point_along(wall, opening.end)


def _between(one: tuple[Point, Point], other: tuple[Point, Point]) -> tuple[Point, Point]:
    """Return the segment midway of two that face each other, the first where they are far."""
    (a, b), (c, d) = one, other
    if (b[0] - a[0]) * (d[0] - c[0]) + (b[1] - a[1]) * (d[1] - c[1]) < 0:
        c, d = d, c
    apart = max(abs(a[0] - c[0]), abs(a[1] - c[1]), abs(b[0] - d[0]), abs(b[1] - d[1]))
    if apart > 2 * SNAP_TOLERANCE:
        return one
    return ((a[0] + c[0]) / 2, (a[1] + c[1]) / 2), ((b[0] + d[0]) / 2, (b[1] + d[1]) / 2)


def _ring(ring: tuple[Point, ...]) -> list[list[float]]:
    return [_point(point) for point in ring]


def _point(point: Point) -> list[float]:
    return [round(point[0], _DIGITS) + 0.0, round(point[1], _DIGITS) + 0.0]
