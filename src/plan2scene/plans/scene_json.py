"""Reader of scene.json, the paper's extension of the Smart Scene Toolkit's scene state.

It repairs the faults of real files (docs/floorplans.md); each repair is a warning of the house.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from plan2scene.house import (
    DEFAULT_HEIGHT,
    FROM_PHOTOS,
    GROUND,
    USUAL,
    Door,
    House,
    IconBox,
    Level,
    Opening,
    PlacedObject,
    Ring,
    Room,
    Stairs,
    Wall,
)
from plan2scene.io import read_text
from plan2scene.plans.geometry import find_doors, walls_of_rooms
from plan2scene.plans.levels import level_of, linked, read_flight, read_levels, used_levels
from plan2scene.plans.parse import SAME_POINT, Source, parse_json
from plan2scene.plans.plan_file import PlanFormat
from plan2scene.plans.scene_frame import upright

STOREY = 1.8  #: Floors at successive heights at least this far apart (metres) are two storeys


def levels_of_rooms(
    source: Source, arch: Mapping[str, Any], room_ids: Sequence[str], floors: Mapping[str, float]
) -> tuple[tuple[Level, ...], dict[str, Level]]:
    """Return the levels, and the level of each room, which its entry in `rooms` names.

    If the file has no levels, they are made of `floors` (y in metres by room) a storey apart.
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
    level_by_room = {
        room_id: by_id[level_of(source, entries.get(room_id, {}), levels, "a room", room_id)]
        for room_id in room_ids
    }
    return levels, level_by_room


def _levels_of_floors(
    room_ids: Sequence[str], floors: Mapping[str, float]
) -> tuple[tuple[Level, ...], dict[str, Level]]:
    """Return levels at heights that are `STOREY` apart; none if there is only one such height."""
    heights = sorted(floors.values())
    starts = [y for k, y in enumerate(heights) if k == 0 or y - heights[k - 1] >= STOREY]
    if len(starts) < 2:
        return (), dict.fromkeys(room_ids, GROUND)
    levels = tuple(
        Level(f"level_{k}", f"Level {k}", y, DEFAULT_HEIGHT) for k, y in enumerate(starts)
    )
    at = {room_id: bisect_right(starts, floors.get(room_id, starts[0])) - 1 for room_id in room_ids}
    return levels, {room_id: levels[at[room_id]] for room_id in room_ids}


def read_stairs(source: Source, arch: Mapping[str, Any], levels: Sequence[Level]) -> list[Stairs]:
    """Return the flights of stairs, not yet linked with rooms."""
    flights = []
    for entry in source.items(arch.get("stairs"), "stairs"):
        item = source.mapping(entry, "stairs")
        name = source.identifier(item.get("id"), "an id of stairs")
        lowest = levels[0].id if levels else ""
        level = level_of(source, item, levels, f"stairs {name}") if "level" in item else lowest
        flights.append(read_flight(source, name, item, level))
    return flights


#: A hole may reach this far (metres) beyond its wall; it is cut there with a warning.
HOLE_TOLERANCE = 0.3
MIN_HOLE = 0.05  #: A hole with less than this left (metres) after cutting is outside its wall
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
    values = {key: value for key, value in element.items() if value is not None}
    tall = max(rooms[room_id].height for room_id in room_ids)
    extra = element.get("extra_height", element.get("extraHeight", defaults["extraHeight"]))
    wall = Wall(
        id=wall_id,
        room_ids=tuple(room_ids),
        start=(x0, z0),
        end=(x1, z1),
        height=source.number(values.get("height", tall), "a wall's height", room),
        depth=source.number(values.get("depth", defaults["depth"]), "a depth", room),
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
    # In real plans low walls (balconies) have doors of full height: cut the hole at any excess.
    bottom, top = _cut(source, y0, y1, wall.height, f"{name}, up", room, tall=True)
    guessed = hole.get("guessed") is True
    kind = "passage" if hole.get("passage") else kind
    return Opening(hole_id, kind, start, end, bottom, top, guessed)


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


def read_scene_json(path: str | Path, house_id: str) -> House:
    """Return the house of a scene.json file, named `house_id`: the file's own id is not used.

    It holds ``{"format": "sceneState", "scene": {...}}``, ``{"scene": {...}}`` or an ``arch``.

    Raises InputError with file, house and room for a fault that can't be repaired.
    """
    return house_of_scene(parse_json(read_text(path), path, house_id), house_id, file=str(path))


def house_of_scene(document: Any, house_id: str, *, file: str = "") -> House:
    """Return the house of a parsed scene.json; see :func:`read_scene_json`."""
    source = Source(file, house_id)
    source.identifier(house_id, "a house name")
    outer = source.mapping(document, "the document")
    scene = source.mapping(outer.get("scene", outer), "'scene'")
    arch = source.mapping(scene.get("arch", scene), "'arch'")
    if scene.get("unit") not in (None, 1):
        raise source.fault("unit 1 (metres)", repr(scene["unit"]))
    scene, arch = upright(source, scene, arch)
    elements = [
        source.mapping(e, "an element") for e in source.items(arch.get("elements"), "elements")
    ]
    if not elements:
        raise source.fault("a list of elements, as in scene.json", "none")
    rooms, levels = _read_rooms(source, arch, elements)
    levels = used_levels(source, levels, rooms.values())
    walls = read_walls(source, arch, elements, rooms)
    return House(
        id=house_id,
        rooms=tuple(rooms.values()),
        walls=tuple(walls),
        doors=_read_doors(source, arch, rooms, walls),
        objects=_read_objects(source, scene),
        icons=_read_icons(source, arch, levels),
        levels=levels,
        stairs=linked(read_stairs(source, arch, levels), tuple(rooms.values()), levels),
        name=source.shown_name(arch.get("name")),
        heights=next((told for told in (USUAL, FROM_PHOTOS) if told == arch.get("heights")), ""),
        warnings=tuple(source.warnings),
    )


def _read_rooms(
    source: Source, arch: Mapping[str, Any], elements: list[dict[str, Any]]
) -> tuple[dict[str, Room], tuple[Level, ...]]:
    """Return the rooms by id, and the levels that they are on.

    Outlines come from floors (if missing, from ceilings), heights from ceilings.
    """
    plates = _read_plates(source, elements)
    types = _room_types(source, arch, list(plates["Floor"] or plates["Ceiling"]))
    shown_names = {
        str(entry.get("id")): source.shown_name(entry.get("name"))
        for entry in source.items(arch.get("rooms"), "rooms")
    }
    for room_id in [*plates["Floor"], *plates["Ceiling"]]:
        if room_id not in types:
            source.warn("an entry of 'rooms'", "none; read as Unknown", room_id)
            types[room_id] = ("Unknown",)
    floors, ceilings = (
        {room_id: _read_rings(source, plate, room_id) for room_id, plate in plates[kind].items()}
        for kind in ("Floor", "Ceiling")
    )
    low = {room_id: y for room_id, (_, y) in floors.items()}
    levels, level_by_room = levels_of_rooms(source, arch, list(types), low)
    rooms = {}
    for room_id, names in types.items():
        plate = floors.get(room_id) or ceilings.get(room_id)
        if plate is None:
            raise source.fault("a Floor element of the room", "none", room_id)
        if room_id not in floors:
            source.warn("a Floor element", "none; outline of the ceiling used", room_id)
        level = level_by_room[room_id]
        base = low.get(room_id, level.elevation)
        if abs(base - level.elevation) > SAME_POINT:
            there = f"{level.elevation:g}"
            source.warn(f"a floor at y = {there}", f"y = {base:g}, moved to {there}", room_id)
        top = ceilings[room_id][1] if room_id in ceilings else None
        height = _room_height(source, room_id, base, top, elements)
        rooms[room_id] = Room(
            room_id, names, plate[0], height, level.id, shown_names.get(room_id, "")
        )
    return rooms, levels


def _read_plates(
    source: Source, elements: list[dict[str, Any]]
) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the Floor and the Ceiling elements, by room."""
    plates: dict[str, dict[str, dict[str, Any]]] = {"Floor": {}, "Ceiling": {}}
    for element in elements:
        kind = str(element.get("type"))
        if kind not in (*plates, "Wall", "Ground"):
            source.warn("elements of type Floor, Ceiling, Wall or Ground", f"{kind!r}, left out")
        if kind in plates:
            for room_id in room_ids_of(source, element):
                if room_id in plates[kind]:
                    raise source.fault(f"one {kind} element", "two", room_id)
                plates[kind][room_id] = element
    return plates


def _room_types(
    source: Source, arch: Mapping[str, Any], floor_ids: list[str]
) -> dict[str, tuple[str, ...]]:
    """Return the types of each room in the order of the file's `rooms`."""
    if arch.get("rooms") is None:
        source.warn("a list of 'rooms'", "none; every room is Unknown")
        return {room_id: ("Unknown",) for room_id in floor_ids}
    types: dict[str, tuple[str, ...]] = {}
    for entry in source.items(arch["rooms"], "rooms"):
        room_id = source.identifier(source.mapping(entry, "a room").get("id"), "a room id")
        if room_id in types:
            raise source.fault("room ids that differ", f"{room_id} twice", room_id)
        names = entry.get("types", entry.get("type"))
        names = [names] if isinstance(names, str) else source.items(names, "room types")
        if not names:
            source.warn("a room type", "none; read as Unknown", room_id)
        listed_types = [source.room_type(name, room_id) for name in names] or ["Unknown"]
        types[room_id] = tuple(dict.fromkeys(listed_types))
    return types


def _read_rings(
    source: Source, element: Mapping[str, Any], room: str
) -> tuple[tuple[Ring, ...], float]:
    """Return the rings (x, z) of a Floor or Ceiling, `offset` added, and their elevation y."""
    offset = (0.0, 0.0, 0.0)
    if element.get("offset") is not None:
        offset = source.point(element["offset"], "an offset", room)
    points = source.items(element.get("points"), "points")
    first = points[0] if points else None
    nested = isinstance(first, list) and bool(first) and isinstance(first[0], list)
    rings = []
    elevation = 0.0
    for ring in points if nested else [points]:
        corners = [
            source.point(p, "an outline", room) for p in source.items(ring, "a ring of points")
        ]
        elevation = corners[0][1] + offset[1] if corners else 0.0
        rings.append(source.ring([(x + offset[0], z + offset[2]) for x, _, z in corners], room))
    return tuple(rings), elevation


def _room_height(
    source: Source, room: str, low: float, ceiling: float | None, elements: list[dict[str, Any]]
) -> float:
    """Return the height in metres: ceiling over floor, else the highest wall, else the default."""
    if ceiling is not None:
        height = round(ceiling - low, 9) if low else ceiling
        if height > SAME_POINT:
            return height
    walls = [
        source.number(e["height"], "a wall's height", room)
        for e in elements
        if e.get("type") == "Wall" and e.get("height") is not None
        if room in room_ids_of(source, e)
    ]
    height = max(walls, default=DEFAULT_HEIGHT)
    source.warn("a ceiling above the floor", f"none; height {height:g} m used", room)
    return height


def _read_doors(
    source: Source, arch: Mapping[str, Any], rooms: Mapping[str, Room], walls: list[Wall]
) -> tuple[Door, ...]:
    """Return each room-door-room relation once; if the file has none, from the walls' doors."""
    if arch.get("rdr") is None:
        doors = find_doors(tuple(rooms.values()), walls)
        if doors:
            source.warn("a list 'rdr'", f"none; {len(doors)} relations found by geometry")
        return doors
    holes = {opening.id for wall in walls for opening in wall.openings}
    doors_by_key: dict[tuple[str, frozenset[str | None]], Door] = {}
    for entry in source.items(arch["rdr"], "rdr"):
        triple = source.items(entry, "an rdr entry")
        if len(triple) != 3:
            raise source.fault("[room, hole, room] in rdr", f"{len(triple)} entries")
        hole = source.identifier(triple[1], "a hole id of rdr")
        ends = [
            source.identifier(end, "a room id of rdr")
            for end in (triple[0], triple[2])
            if end not in (None, "")
        ]
        missing = next((end for end in ends if end not in rooms), None)
        if missing is not None or not ends:
            raise source.fault(f"rooms of this plan at door {hole}", missing or "no room")
        if hole not in holes:
            source.warn("a hole of some wall for each rdr entry", f"no hole {hole}")
        door = Door(ends[0], hole, ends[1] if len(ends) == 2 else None)
        if door.room_b is not None and rooms[door.room_a].level != rooms[door.room_b].level:
            levels = f"{door.room_a} and {door.room_b} are on two; left out"
            source.warn(f"door {hole} between rooms of one level", levels, door.room_a)
            continue
        doors_by_key.setdefault((hole, frozenset((door.room_a, door.room_b))), door)
    return tuple(doors_by_key.values())


def _read_objects(source: Source, scene: Mapping[str, Any]) -> tuple[PlacedObject, ...]:
    """Return the placed object models; one that can't be read is left out with a warning."""
    objects = []
    for number, entry in enumerate(source.items(scene.get("object"), "object")):
        transform = entry.get("transform") if isinstance(entry, dict) else None
        data = transform.get("data") if isinstance(transform, dict) else transform
        model = entry.get("modelId") if isinstance(entry, dict) else None
        if not isinstance(model, str) or not isinstance(data, list) or len(data) != 16:
            source.warn("modelId and a 4x4 transform of each object", f"object {number} without")
            continue
        places = [entry.get("index", number), entry.get("parentIndex", -1)]
        index, parent = (int(source.number(v, "an object's index")) for v in places)
        values = tuple(source.number(v, "an object's transform") for v in data)
        objects.append(PlacedObject(model, index, parent, values))
    return tuple(objects)


def _read_icons(
    source: Source, arch: Mapping[str, Any], levels: Sequence[Level]
) -> tuple[IconBox, ...]:
    """Return the icon boxes that :func:`write_scene_json` keeps under `arch.icons`."""
    icons = (source.mapping(entry, "an icon") for entry in source.items(arch.get("icons"), "icons"))
    lowest = levels[0].id if levels else ""
    return tuple(
        IconBox(
            str(icon.get("type", "")),
            *source.box(icon, "an icon"),
            level_of(source, icon, levels, "an icon") if "level" in icon else lowest,
        )
        for icon in icons
    )


PLAN_FORMAT = PlanFormat(
    "scene.json",
    lambda plan: plan.document is not None,
    lambda plan: house_of_scene(plan.document, plan.house_id, file=str(plan.path)),
    suffixes=(".json",),
    fallback=True,
)
