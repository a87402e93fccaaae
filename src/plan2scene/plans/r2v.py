"""Reader of raster-to-vector plans (annotation and network output), docs/floorplans.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from shapely.geometry import LineString, Polygon, box

from plan2scene.errors import InputError
from plan2scene.house import House, IconBox, Room, Wall
from plan2scene.plans.formats import PlanFile, PlanFormat, Unscaled
from plan2scene.plans.geometry import (
    find_doors,
    point_along,
    room_polygon,
    walls_of_rooms,
)
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import Source
from plan2scene.plans.r2v_rooms import room_polygons, side_labels
from plan2scene.plans.r2v_text import (
    ICON_LABELS,
    ROOM_LABELS,
    PixelBox,
    PixelPlan,
    is_r2v,
    parse_r2v,
)

#: The reference converter's constants, in metres.
WALL_HEIGHT = 2.8
WALL_DEPTH = 0.1
BALCONY_WALL_HEIGHT = 1.4
DOOR_HEIGHTS = (0.0, 2.5)
WINDOW_HEIGHTS = (1.0, 2.0)
#: An opening this near (pixels) to a wall lies on it.
DOOR_MARGIN = 20.0
#: A label or entrance belongs to the room that holds at least this share of its box.
LABEL_SHARE = 0.4
ENTRANCE_SHARE = 0.6
#: Rooms whose own outer walls are parapets.
_LOW_WALLED = frozenset({"Balcony"})


def house_of_r2v(text: str, house_id: str, metres_per_pixel: float, *, file: str = "") -> House:
    """Return the house of raster-to-vector text of either dialect.

    Rooms are the faces that the walls close. Openings between two rooms are doors; of a room
    with an entrance the nearest opening to the outside is one too; the others are windows.
    The drawing's x becomes x, its y becomes z, times `metres_per_pixel`.
    """
    source = Source(file, house_id)
    source.identifier(house_id, "a house name")
    plan = parse_r2v(source, text)
    faces, loose = room_polygons(source, plan.walls)
    if loose > 0.5:
        found = f"{loose * metres_per_pixel:.2f} m of walls that don't, left out"
        source.warn("walls that close a room", found)
    rooms = _rooms(source, plan, faces, metres_per_pixel)
    walls = [_lower(wall, rooms) for wall in walls_of_rooms(rooms, depth=WALL_DEPTH)]
    walls = _openings(source, plan, rooms, walls, metres_per_pixel)
    icons = [
        item.scaled(metres_per_pixel)
        for item in plan.boxes
        if item.label not in ROOM_LABELS and item.label != "entrance"
    ]
    return House(
        id=house_id,
        rooms=tuple(rooms),
        walls=tuple(walls),
        doors=find_doors(rooms, walls),
        icons=tuple(IconBox(icon.label, icon.low, icon.high) for icon in icons),
        warnings=tuple(source.warnings),
    )


def _rooms(
    source: Source, plan: PixelPlan, faces: Sequence[Polygon], metres_per_pixel: float
) -> list[Room]:
    """Return a room for each face, with the types that its labels mean, in metres."""
    labels: list[list[str]] = [[] for _ in faces]
    marks: list[list[str]] = [[] for _ in faces]
    for item in plan.boxes:
        face = _face_of(item, faces, LABEL_SHARE)
        if item.label.lower() in ROOM_LABELS:
            if face is None:
                source.warn("each room label inside a room", f"{item.label} outside")
            else:
                labels[face].append(item.label)
        elif item.label not in ICON_LABELS:
            source.warn("a known label", f"{item.label!r}, kept as an icon")
        elif face is not None and item.label in ("entrance", "stairs"):
            marks[face].append(item.label)
    rooms = []
    m = metres_per_pixel
    for k, face in enumerate(faces):
        room_id = f"room_{k}"
        votes = side_labels(face, plan.walls)
        votes.pop("outside", None)
        if votes and not labels[k]:
            labels[k] = [max(votes, key=lambda label: votes[label])]
        # An entrance or stairs name a room only where nothing else does.
        names = [source.room_type(label, room_id) for label in labels[k] or marks[k]]
        if not names:
            source.warn("a label for each room", "none; read as Unknown", room_id)
        rings = tuple(
            source.outline([(x * m, y * m) for x, y in ring.coords], room_id)
            for ring in (face.exterior, *face.interiors)
        )
        rooms.append(Room(room_id, tuple(dict.fromkeys(names)) or ("Unknown",), rings, WALL_HEIGHT))
    return rooms


def _face_of(item: PixelBox, faces: Sequence[Polygon], share: float) -> int | None:
    """Return the face that holds most of a box, at least `share` of it."""
    shape = box(*item.low, *item.high)
    if shape.area <= 0:
        shape = shape.buffer(0.5)
    shares = [face.intersection(shape).area / shape.area for face in faces]
    best = max(range(len(faces)), key=lambda k: shares[k])
    return best if shares[best] >= share else None


def _lower(wall: Wall, rooms: Sequence[Room]) -> Wall:
    """Return a balcony's own wall as a parapet, any other wall as it is."""
    types = {name for room in rooms if room.id in wall.room_ids for name in room.types}
    return replace(wall, height=BALCONY_WALL_HEIGHT) if types <= _LOW_WALLED else wall


def _openings(
    source: Source,
    plan: PixelPlan,
    rooms: Sequence[Room],
    walls: list[Wall],
    metres_per_pixel: float,
) -> list[Wall]:
    """Return the walls with their doors and windows."""
    tolerance = DOOR_MARGIN * metres_per_pixel
    placed = walls
    for number, door in enumerate(plan.doors):
        segment = _segment(door, f"hole_{number}", metres_per_pixel)
        try:
            given = (source, placed, [segment])
            placed = place_openings(*given, tolerance=tolerance, both_sides=False)
        except InputError as error:
            # One stray door of a recognised drawing is no reason to lose the house.
            source.warnings.append(f"{error}; left out")
    doors = _outer_doors(plan, rooms, placed, metres_per_pixel)
    return [_with_heights(wall, doors) for wall in placed]


def _segment(door: PixelBox, name: str, metres_per_pixel: float) -> Segment:
    """Return the middle line of a door's box along its longer side, in metres."""
    (x0, y0), (x1, y1) = door.low, door.high
    m = metres_per_pixel
    if x1 - x0 >= y1 - y0:
        y0 = y1 = (y0 + y1) / 2
    else:
        x0 = x1 = (x0 + x1) / 2
    return Segment(name, "door", (x0 * m, y0 * m), (x1 * m, y1 * m), *DOOR_HEIGHTS)


def _outer_doors(
    plan: PixelPlan, rooms: Sequence[Room], walls: Sequence[Wall], metres_per_pixel: float
) -> set[str]:
    """Return the openings to the outside that are doors: the nearest to each entrance."""
    polygons = [room_polygon(room) for room in rooms]
    doors = set()
    for item in plan.boxes:
        if item.label != "entrance":
            continue
        mark = item.scaled(metres_per_pixel)
        face = _face_of(mark, polygons, ENTRANCE_SHARE)
        if face is None:
            continue
        shape = box(*mark.low, *mark.high)
        best = (math.inf, "")
        for wall in walls:
            if wall.room_ids == (rooms[face].id,):
                for opening in wall.openings:
                    ends = point_along(wall, opening.start), point_along(wall, opening.end)
                    best = min(best, (LineString(ends).distance(shape), opening.id))
        doors.add(best[1])
    return doors


def _with_heights(wall: Wall, doors: set[str]) -> Wall:
    """Return a wall, its openings as doors or windows with the usual heights, cut to it."""
    openings = []
    for opening in wall.openings:
        door = len(wall.room_ids) > 1 or opening.id in doors
        kind, (bottom, top) = ("door", DOOR_HEIGHTS) if door else ("window", WINDOW_HEIGHTS)
        top = min(top, wall.height)
        openings.append(replace(opening, kind=kind, bottom=bottom, top=top))
    return replace(wall, openings=tuple(openings))


def _look(plan: PlanFile) -> Unscaled:
    """Return the size by the walls."""
    walls = parse_r2v(Source("", plan.house_id), plan.text).walls
    if not walls:
        return Unscaled("pixel")
    width, depth = np.ptp([point for wall in walls for point in (wall.start, wall.end)], axis=0)
    return Unscaled("pixel", (float(width), float(depth)))


PLAN_FORMAT = PlanFormat(
    "raster-to-vector text",
    lambda plan: is_r2v(plan.text),
    lambda plan: house_of_r2v(
        plan.text, plan.house_id, plan.metres_per_pixel or 0.0, file=str(plan.path)
    ),
    suffixes=(".txt",),
    needs_scale=True,
    look=_look,
)
