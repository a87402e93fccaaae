"""Walls and their holes out of scene.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from plan2scene.house import Opening, Room, Wall
from plan2scene.plans.geometry import walls_of_rooms
from plan2scene.plans.parse import SAME_POINT, Source

#: A hole may reach this far (metres) beyond its wall; it is cut there with a warning.
HOLE_TOLERANCE = 0.3
#: A hole with less than this left (metres) after cutting is outside its wall.
MIN_HOLE = 0.05
#: Excess (metres) of rounding, cut without a warning.
ROUNDING = 1e-6
_DEFAULTS = {"depth": 0.1, "extraHeight": 0.035}
_KINDS = {"door": "door", "window": "window", "passage": "passage", "opening": "passage"}


def room_ids_of(source: Source, element: Mapping[str, Any]) -> list[str]:
    """Return the room ids of an element: `roomId` is a string or a list."""
    value = element.get("roomId", element.get("room_id"))
    values = value if isinstance(value, list) else [value] if value not in (None, "") else []
    return list(dict.fromkeys(source.identifier(v, "a roomId") for v in values if v is not None))


def read_walls(
    source: Source,
    arch: Mapping[str, Any],
    elements: list[dict[str, Any]],
    rooms: Mapping[str, Room],
) -> list[Wall]:
    """Return the walls as in the file; a room without any gets them from its outline."""
    raw = arch.get("defaults")
    raw = raw.get("Wall") if isinstance(raw, dict) else None
    defaults = {**_DEFAULTS, **(raw if isinstance(raw, dict) else {})}
    walls: list[Wall] = []
    for element in elements:
        if element.get("type") == "Wall":
            wall = _read_wall(source, element, defaults, rooms, len(walls))
            walls += [wall] if wall else []
    bounded = {room_id for wall in walls for room_id in wall.room_ids}
    for room in rooms.values():
        if room.id not in bounded:
            source.warn("walls", "none; made from the outline", room.id)
            depth = source.number(defaults["depth"], "a wall's depth", room.id)
            walls += walls_of_rooms([room], depth=depth, shared=False)
    return walls


def _read_wall(
    source: Source,
    element: Mapping[str, Any],
    defaults: Mapping[str, Any],
    rooms: Mapping[str, Room],
    number: int,
) -> Wall | None:
    """Return a wall, or None (with a warning) for one without a length or a room."""
    room_ids = room_ids_of(source, element)
    missing = next((room_id for room_id in room_ids if room_id not in rooms), None)
    if missing is not None:
        raise source.fault("a roomId of this plan", missing)
    wall_id = source.identifier(element.get("id", f"wall_{number}"), "a wall id")
    if not room_ids or len(room_ids) > 2:
        source.warn(f"one or two rooms of wall {wall_id}", f"{len(room_ids)}; wall left out")
        return None
    room = room_ids[0]
    points = source.items(element.get("points"), "a wall's points")
    if len(points) != 2:
        raise source.fault(f"two points of wall {wall_id}", len(points), room)
    (x0, _, z0), (x1, _, z1) = (source.point(p, "a wall", room) for p in points)
    tall = max(rooms[room_id].height for room_id in room_ids)
    extra = element.get("extra_height", element.get("extraHeight", defaults["extraHeight"]))
    wall = Wall(
        id=wall_id,
        room_ids=tuple(room_ids),
        start=(x0, z0),
        end=(x1, z1),
        height=source.number(_given(element.get("height"), tall), "a wall's height", room),
        depth=source.number(_given(element.get("depth"), defaults["depth"]), "a depth", room),
        extra_height=source.number(extra, "extra_height", room),
    )
    if wall.length <= SAME_POINT:
        source.warn(f"wall {wall_id} with a length", "none; wall left out", room)
        return None
    holes = source.items(element.get("holes"), "a wall's holes")
    openings = [_read_hole(source, hole, wall, k) for k, hole in enumerate(holes)]
    once = {opening.id: opening for opening in reversed(openings)}
    if len(once) < len(openings):
        source.warn(f"hole ids that differ on wall {wall_id}", "one twice; first kept", room)
    return replace(wall, openings=tuple(o for o in openings if once[o.id] is o))


def _given(value: Any, otherwise: Any) -> Any:
    """Return `value` unless it is None."""
    return otherwise if value is None else value


def _read_hole(source: Source, value: Any, wall: Wall, number: int) -> Opening:
    """Return the opening of a wall's hole, cut to the wall where it overlaps an end slightly."""
    hole = source.mapping(value, "a hole")
    room = wall.room_ids[0]
    hole_id = source.identifier(hole.get("id", f"{wall.id}_hole_{number}"), "a hole id", room)
    kind = _KINDS.get(str(hole.get("type", "")).lower())
    if kind is None:
        raise source.fault(f"Door or Window for hole {hole_id}", repr(hole.get("type")), room)
    box = source.mapping(hole.get("box"), f"the box of hole {hole_id}")
    corners = [source.items(box.get(name), f"box of hole {hole_id}") for name in ("min", "max")]
    if any(len(corner) != 2 for corner in corners):
        raise source.fault(f"[along, up] in the box of hole {hole_id}", "another length", room)
    (x0, y0), (x1, y1) = (
        [source.number(v, f"box of hole {hole_id}", room) for v in corner] for corner in corners
    )
    if y0 >= y1:
        raise source.fault(f"hole {hole_id} with top above bottom", f"{y0:g} to {y1:g} m", room)
    name = f"hole {hole_id} on wall {wall.id}"
    start, end = _cut(source, min(x0, x1), max(x0, x1), wall.length, f"{name}, along", room)
    # Low walls (balconies) carry full doors in real plans: the hole is cut at any excess.
    bottom, top = _cut(source, y0, y1, wall.height, f"{name}, up", room, tall=True)
    return Opening(hole_id, "passage" if hole.get("passage") else kind, start, end, bottom, top)


def _cut(
    source: Source,
    low: float,
    high: float,
    limit: float,
    name: str,
    room: str,
    *,
    tall: bool = False,
) -> tuple[float, float]:
    """Return (low, high) cut to [0, limit]; InputError when too much lies outside."""
    inside = (max(low, 0.0), min(high, limit))
    excess = max(-low, 0.0 if tall else high - limit)
    if excess > HOLE_TOLERANCE or inside[1] - inside[0] < min(MIN_HOLE, high - low):
        raise source.fault(f"{name} within 0 to {limit:.3f} m", f"{low:.3f} to {high:.3f} m", room)
    if max(-low, high - limit) > ROUNDING:
        found = f"{low:.3f} to {high:.3f} m, cut"
        source.warn(f"{name} within 0 to {limit:.3f} m", found, room)
    return inside
