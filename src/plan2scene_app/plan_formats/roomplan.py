"""Reader of RoomPlan scans: the JSON of Apple's CapturedRoom and CapturedStructure.

Metres, y up; every surface has `dimensions` [width, height, depth] and a `transform` of 16 numbers,
column by column. Walls are the faces that the scanner saw.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry import Polygon

from plan2scene.house import House, IconBox, Ring
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import MAX_ITEMS, MAX_ROOMS, Source
from plan2scene.plans.plan_file import PlanFormat
from plan2scene.plans.room_names import room_types
from plan2scene_app.plan_formats.axes import MAX_AXES, WallAxis
from plan2scene_app.plan_formats.drawing import (
    Drawing,
    DrawnRoom,
    DrawnStorey,
    closed_rooms,
    house_of_storeys,
)

#: Largest numbers of a scan's parts.
_LIMITS = {"walls": MAX_AXES, "floors": MAX_ROOMS, "objects": MAX_ITEMS}
_KINDS = {"doors": "door", "windows": "window", "openings": "passage"}


def is_roomplan(document: Any) -> bool:
    """Return whether a JSON document is a captured room or structure."""
    if not isinstance(document, dict):
        return False
    first = next(iter(_rooms(document)), None)
    walls = first.get("walls") if isinstance(first, dict) else None
    wall = walls[0] if isinstance(walls, list) and walls else None
    return isinstance(wall, dict) and {"transform", "dimensions"} <= wall.keys()


def house_of_roomplan(document: Any, house_id: str, *, file: str = "") -> House:
    """Return the house of a captured room or structure, with its lowest storey at elevation 0."""
    source = Source(file, house_id)
    rooms = [source.mapping(room, "a room") for room in _rooms(document)]
    counts = {key: sum(len(source.items(room.get(key), key)) for room in rooms) for key in _LIMITS}
    for what, limit in _LIMITS.items():
        if max(counts[what], len(rooms)) > limit:
            raise source.fault(f"at most {limit} {what} and rooms", max(counts[what], len(rooms)))
    stories: dict[int, list[dict[str, Any]]] = defaultdict(list)
    for room in rooms:
        stories[_story(source, room)].append(room)
    floors = {
        story: min(_floor_height(source, room) for room in group)
        for story, group in stories.items()
    }
    lowest = min(floors.values())
    return house_of_storeys(
        source,
        (
            DrawnStorey(f"storey {story}", floors[story] - lowest, _drawing(source, group))
            for story, group in sorted(stories.items())
        ),
    )


def _rooms(document: dict[str, Any]) -> list[Any]:
    """Return the captured rooms of a structure, or the document itself if it is one room."""
    rooms = document.get("rooms")
    return rooms if isinstance(rooms, list) and rooms else [document]


def _story(source: Source, room: dict[str, Any]) -> int:
    surfaces = [
        *source.items(room.get("floors"), "floors"),
        *source.items(room.get("walls"), "walls"),
    ]
    story = room.get(
        "story", source.mapping(surfaces[0], "a surface").get("story", 0) if surfaces else 0
    )
    return story if isinstance(story, int) else 0


def _drawing(source: Source, rooms: list[dict[str, Any]]) -> Drawing:
    """Return the drawing of the rooms of one storey."""
    drawing = Drawing()
    for number, room in enumerate(rooms):
        base = _floor_height(source, room)
        walls = _walls(source, room, base)
        height = max((wall.height for wall in walls), default=drawing.height)
        _add_openings(source, room, base, drawing)
        scan = Drawing(axes=walls, openings=drawing.openings)
        floors = source.items(room.get("floors"), "floors")
        parts = _parts(source, room, height, scan, len(floors))
        for part in parts:
            drawing.add_room(part)
        drawing.axes += scan.axes
        if len(drawing.axes) > MAX_AXES:
            raise source.fault(f"at most {MAX_AXES} walls", "more")
        for floor in () if parts else floors:
            drawing.add_room(_room(source, room, floor, height, f"room {number}"))
        for item in source.items(room.get("objects"), "objects"):
            drawing.icons.append(_icon(source, item))
    drawing.height = max((axis.height for axis in drawing.axes), default=drawing.height)
    return drawing


def _walls(source: Source, room: dict[str, Any], base: float) -> list[WallAxis]:
    """Return a room's walls; their height goes from the floor at `base` to their top."""
    walls = [_upright(source, wall, "a wall") for wall in source.items(room.get("walls"), "walls")]
    return [WallAxis(start, end, 0.0, top - base) for start, end, _, top in walls]


def _parts(
    source: Source, room: dict[str, Any], height: float, scan: Drawing, floors: int
) -> list[DrawnRoom]:
    """Return the rooms that a scan's walls close, if it has fewer floors than rooms.

    Such a scan has more sections, one for each room, than floors. The list is empty if the walls
    close no more rooms than there are floors.
    """
    if len(source.items(room.get("sections"), "sections")) <= floors or not scan.axes:
        return []
    parts = []
    for face in closed_rooms(source, scan):
        ring = [(float(x), float(z)) for x, z in face.exterior.coords[:-1]]
        parts.append(_labelled(source, room, source.ring(ring, "a room"), height))
    if len(parts) <= floors:
        return []
    source.warn("a floor for each room", f"{floors} for {len(parts)}, closed from walls")
    return parts


def _floor_height(source: Source, room: dict[str, Any]) -> float:
    """Return the lowest y of the room's walls."""
    walls = source.items(room.get("walls"), "walls")
    return min((_upright(source, wall, "a wall")[2] for wall in walls), default=0.0)


def _surface(source: Source, value: Any, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a surface's (4, 4) matrix and its (3,) dimensions."""
    item = source.mapping(value, what)
    flat = source.items(item.get("transform"), f"transform of {what}")
    if len(flat) == 4:
        flat = [v for column in flat for v in source.items(column, f"transform of {what}")]
    sizes = source.items(item.get("dimensions"), f"dimensions of {what}")
    if len(flat) != 16 or len(sizes) != 3:
        expected = f"16 numbers of transform and 3 of dimensions for {what}"
        raise source.fault(expected, f"{len(flat)} and {len(sizes)}")
    numbers = [source.number(v, f"transform of {what}") for v in flat]
    matrix = np.array(numbers).reshape(4, 4).T
    return matrix, np.array([source.number(v, f"dimensions of {what}") for v in sizes])


def _upright(
    source: Source, value: Any, what: str
) -> tuple[tuple[float, float], tuple[float, float], float, float]:
    """Return the ends (x, z), the bottom and the top of an upright rectangle."""
    matrix, (width, height, _) = _surface(source, value, what)
    ends = [matrix @ np.array([side * width / 2, 0.0, 0.0, 1.0]) for side in (-1, 1)]
    middle = float(matrix[1, 3])
    start, end = ((float(p[0]), float(p[2])) for p in ends)
    return start, end, middle - height / 2, middle + height / 2


def _room(source: Source, room: dict[str, Any], floor: Any, height: float, name: str) -> DrawnRoom:
    """Return a floor as a room."""
    return _labelled(source, room, _floor_ring(source, floor, name), height)


def _labelled(source: Source, room: dict[str, Any], ring: Ring, height: float) -> DrawnRoom:
    """Return a room with the names and types of the sections inside it."""
    polygon = Polygon(ring)
    labels = []
    for section in source.items(room.get("sections"), "sections"):
        item = source.mapping(section, "a section")
        x, _, z = source.point(item.get("center"), "a section's centre")
        if polygon.is_valid and polygon.buffer(0.2).contains(ShapelyPoint(x, z)):
            labels.append(str(item.get("label", "")))
    types = [kind for label in labels for kind in room_types(label)]
    return DrawnRoom(" ".join(labels), (ring,), height, tuple(dict.fromkeys(types)), called=False)


def _floor_ring(source: Source, floor: Any, name: str) -> Ring:
    """Return a floor's outline (x, z): its corners, else the rectangle of its dimensions."""
    matrix, (width, height, depth) = _surface(source, floor, "a floor")
    corners = [
        source.point(c, "a floor's corner", name)
        for c in source.items(floor.get("polygonCorners"), "polygonCorners")
    ]
    if not corners:
        flat = depth > height
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        half = (width / 2, (depth if flat else height) / 2)
        pairs = [(sx * half[0], sy * half[1]) for sx, sy in signs]
        corners = [(x, 0.0, y) if flat else (x, y, 0.0) for x, y in pairs]
    points = np.column_stack([np.array(corners), np.ones(len(corners))]) @ matrix.T
    return source.ring([(float(p[0]), float(p[2])) for p in points], name)


def _add_openings(source: Source, room: dict[str, Any], base: float, drawing: Drawing) -> None:
    """Add those doors, windows and openings of a room that no other room has added already."""
    for key, kind in _KINDS.items():
        for value in source.items(room.get(key), key):
            start, end, bottom, top = _upright(source, value, key)
            if not drawing.shows(start, end, kind):
                low = max(bottom - base, 0.0)
                name = f"opening_{len(drawing.openings)}"
                drawing.openings.append(Segment(name, kind, start, end, low, max(top - base, low)))


def _icon(source: Source, value: Any) -> IconBox:
    """Return the box around an object."""
    matrix, (width, _, depth) = _surface(source, value, "an object")
    corners = np.array([[sx * width / 2, 0, sz * depth / 2, 1] for sx in (-1, 1) for sz in (-1, 1)])
    places = (corners @ matrix.T)[:, [0, 2]]
    category = value.get("category")
    name = next(iter(category), "object") if isinstance(category, dict) else str(category)
    low, high = places.min(axis=0), places.max(axis=0)
    return IconBox(name[:100], (float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


PLAN_FORMAT = PlanFormat(
    "RoomPlan JSON",
    lambda plan: is_roomplan(plan.document),
    lambda plan: house_of_roomplan(plan.document, plan.house_id, file=str(plan.path)),
    suffixes=(".json",),
)
