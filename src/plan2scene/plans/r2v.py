"""Reader of raster-to-vector plans in both text dialects (annotation and network output).

Text is parsed in pixels (x right, y down), loose wall lines are joined, straightened, split at
crossings and polygonised into rooms, and the rooms are scaled to metres (docs/floorplans.md).
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from shapely.geometry import LineString, Polygon, box
from shapely.geometry import Point as ShapelyPoint
from shapely.ops import polygonize, unary_union

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, House, IconBox, Point, Room, Wall
from plan2scene.plans.geometry import find_doors, point_along, room_polygon, walls_of_rooms
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import MAX_ITEMS, MAX_ROOMS, R2V_TYPES, Source
from plan2scene.plans.plan_file import PlanFile, PlanFormat, Unscaled

#: Room labels of the network output by index.
OUTPUT_LABELS = (
    "outside",
    "living_room",
    "kitchen",
    "bedroom",
    "bathroom",
    "restroom",
    "balcony",
    "closet",
    "corridor",
    "washing_room",
    "PS",
)
#: Labels of drawn objects.
ICON_LABELS = frozenset(
    {"bathtub", "cooking_counter", "entrance", "special", "stairs", "toilet", "washing_basin"}
)
#: Labels that name a room. The icons `stairs` and `entrance` name a room that has no label.
ROOM_LABELS = frozenset({*R2V_TYPES, *(name.lower() for name in ROOM_TYPES)}) - ICON_LABELS
MAX_LINES = 2000  #: Largest number of walls, and of other lines, of one file
MAX_PIXEL = 100_000.0  #: Largest pixel coordinate


@dataclass(frozen=True)
class PixelWall:
    """A wall line; `labels` are those left and right of its direction (network output only)."""

    start: Point
    end: Point
    labels: tuple[str, str] | None = None


@dataclass(frozen=True)
class PixelBox:
    """A labelled box: opening, icon or room label."""

    label: str
    low: Point
    high: Point

    def scaled(self, factor: float) -> PixelBox:
        """Return the box with its coordinates times a factor."""
        low, high = ((x * factor, y * factor) for x, y in (self.low, self.high))
        return PixelBox(self.label, low, high)


@dataclass(frozen=True)
class PixelPlan:
    """The contents of a raster-to-vector file."""

    walls: tuple[PixelWall, ...]
    doors: tuple[PixelBox, ...]
    boxes: tuple[PixelBox, ...]


def is_r2v(text: str) -> bool:
    """Return whether text may be of either dialect: its first field is a number."""
    try:
        float(text.split(maxsplit=1)[0])
    except (ValueError, IndexError):
        return False
    return True


def parse_r2v(source: Source, text: str) -> PixelPlan:
    """Return the walls, doors and boxes of either dialect, told apart by the first line."""
    lines = [
        (number, fields)
        for number, line in enumerate(text.splitlines(), start=1)
        if (fields := line.split())
    ]
    if not lines:
        raise source.fault("raster-to-vector lines", "none")
    walls: list[PixelWall] = []
    if len(lines[0][1]) == 2:
        walls, lines = _output_walls(source, lines)
    doors: list[PixelBox] = []
    boxes: list[PixelBox] = []
    for number, fields in lines:
        if len(fields) not in (5, 6, 7):
            found = f"{len(fields)} fields: {fields[0][:40]}"
            raise source.fault(f"x1 y1 x2 y2 label in line {number}", found)
        start, end = _ends(source, number, fields)
        if fields[4] == "wall":
            walls.append(PixelWall(start, end))
            continue
        low = (min(start[0], end[0]), min(start[1], end[1]))
        high = (max(start[0], end[0]), max(start[1], end[1]))
        box = PixelBox(fields[4], low, high)
        (doors if box.label == "door" else boxes).append(box)
    for what, count in (("walls", len(walls)), ("other lines", len(doors) + len(boxes))):
        if count > MAX_LINES:
            raise source.fault(f"at most {MAX_LINES} {what}", count)
    if not walls:
        raise source.fault("walls", "none")
    return PixelPlan(tuple(walls), tuple(doors), tuple(boxes))


def _output_walls(
    source: Source, lines: list[tuple[int, list[str]]]
) -> tuple[list[PixelWall], list[tuple[int, list[str]]]]:
    """Return the labelled walls of the network output, and the lines after them."""
    count_line = lines[1][1] if len(lines) > 1 else []
    count = int(count_line[0]) if len(count_line) == 1 and count_line[0].isdecimal() else -1
    if not 0 < count <= min(MAX_LINES, len(lines) - 2):
        found = " ".join(count_line)[:40] or "nothing"
        raise source.fault(f"the number of walls (1 to {len(lines) - 2}) in line 2", found)
    walls = []
    for number, fields in lines[2 : 2 + count]:
        if len(fields) != 6:
            raise source.fault(f"x1 y1 x2 y2 a b in line {number}", f"{len(fields)} fields")
        labels = []
        for field in fields[4:]:
            index = int(field) if field.isdecimal() and len(field) < 4 else len(OUTPUT_LABELS)
            if index >= len(OUTPUT_LABELS):
                expected = f"a room index of 0 to {len(OUTPUT_LABELS) - 1} in line {number}"
                raise source.fault(expected, field[:40])
            labels.append(OUTPUT_LABELS[index])
        start, end = _ends(source, number, fields)
        walls.append(PixelWall(start, end, (labels[0], labels[1])))
    return walls, lines[2 + count :]


def _ends(source: Source, number: int, fields: list[str]) -> tuple[Point, Point]:
    """Return the two points that a line starts with."""
    values = []
    for field in fields[:4]:
        try:
            value = float(field)
        except ValueError:
            value = math.nan
        if not abs(value) <= MAX_PIXEL:
            expected = f"pixel coordinates within {MAX_PIXEL:g} in line {number}"
            raise source.fault(expected, repr(field)[:40])
        values.append(value)
    return (values[0], values[1]), (values[2], values[3])


JOIN_MARGIN = 5.0  #: Wall ends nearer than this (pixels) meet; the reference converter's margin
MIN_FACE = 50.0  #: Faces with less area than this (square pixels) are inaccuracies, not rooms

_Edge = tuple[int, int]


def room_polygons(source: Source, walls: Sequence[PixelWall]) -> tuple[list[Polygon], float]:
    """Return the faces that the walls close, and the length (pixels) of walls that close none.

    Ends within `JOIN_MARGIN` become one node. An end that near to another wall splits it. Runs of
    nearly axis-aligned walls are made straight, and walls are split at crossings. Corners remain
    where walls meet or turn. Faces are sorted from top to bottom, then left to right. Raises
    InputError for no face, or more than `MAX_ROOMS`.
    """
    nodes, edges = _join([(wall.start, wall.end) for wall in walls])
    edges = _split_at_nodes(nodes, edges)
    nodes = _straighten(nodes, edges)
    lines = [LineString(nodes[list(edge)]) for edge in edges if edge[0] != edge[1]]
    lines = [line for line in lines if line.length > 0]
    network = unary_union(lines)
    pieces = len(getattr(network, "geoms", [network]))
    if pieces > MAX_ITEMS:
        raise source.fault(f"walls of at most {MAX_ITEMS} pieces between crossings", pieces)
    faces = [face for face in polygonize(network) if face.area >= MIN_FACE]
    if not 1 <= len(faces) <= MAX_ROOMS:
        raise source.fault(f"walls that close 1 to {MAX_ROOMS} rooms", f"{len(faces)} rooms")
    used = unary_union([face.boundary for face in faces])
    degrees = _degrees(used)
    faces = [_drop_flat_corners(face, degrees) for face in faces]
    loose = network.difference(used).length
    faces.sort(key=lambda face: (round(face.bounds[1], 3), round(face.bounds[0], 3)))
    return faces, float(loose)


def _join(segments: Iterable[tuple[tuple[float, float], ...]]) -> tuple[np.ndarray, list[_Edge]]:
    """Return nodes (n, 2) and edges; ends within the margin share a node at their mean."""
    points = np.array([end for segment in segments for end in segment], dtype=np.float64)
    group = np.arange(len(points))
    for k, point in enumerate(points):
        near = np.flatnonzero(np.linalg.norm(points - point, axis=1) < JOIN_MARGIN)
        merged = np.isin(group, group[near])
        group[merged] = group[k]
    _, index = np.unique(group, return_inverse=True)
    counts = np.bincount(index)[:, None]
    nodes = np.zeros((len(counts), 2))
    np.add.at(nodes, index, points)
    edges = [(int(index[k]), int(index[k + 1])) for k in range(0, len(points), 2)]
    return nodes / counts, list(dict.fromkeys(tuple(sorted(e)) for e in edges if e[0] != e[1]))  # type: ignore[misc]


def _split_at_nodes(nodes: np.ndarray, edges: list[_Edge]) -> list[_Edge]:
    """Return the edges cut at every node that lies within the margin of their inside."""
    pieces: dict[_Edge, None] = {}
    for a, b in edges:
        direction = nodes[b] - nodes[a]
        length = float(np.linalg.norm(direction))
        along = (nodes - nodes[a]) @ direction / length
        across = np.abs((nodes - nodes[a]) @ np.array([-direction[1], direction[0]]) / length)
        inside = (along > 0) & (along < length) & (across < JOIN_MARGIN)
        inside[[a, b]] = False
        between = [int(k) for k in np.flatnonzero(inside)]
        stops = [a, *sorted(between, key=lambda k: along[k]), b]
        for start, end in pairwise(stops):
            pieces[(min(start, end), max(start, end))] = None
    return list(pieces)


def _straighten(nodes: np.ndarray, edges: list[_Edge]) -> np.ndarray:
    """Return the nodes with runs of nearly vertical (horizontal) edges on one x (y)."""
    straight = nodes.copy()
    for axis in (0, 1):
        group = np.arange(len(nodes))
        for a, b in edges:
            off, along = np.abs(nodes[a] - nodes[b])[[axis, 1 - axis]]
            if off < min(JOIN_MARGIN, along):
                group[group == group[b]] = group[a]
        for name in np.unique(group):
            members = group == name
            straight[members, axis] = nodes[members, axis].mean()
    return straight


def _key(point: Sequence[float]) -> tuple[float, float]:
    """Return a point rounded so that equal nodes are equal keys."""
    return (round(point[0], 6), round(point[1], 6))


def _degrees(network: LineString) -> Counter[tuple[float, float]]:
    """Return how many pieces of a noded network meet at each of its points."""
    degrees: Counter[tuple[float, float]] = Counter()
    for line in getattr(network, "geoms", [network]):
        coordinates = list(line.coords)
        for start, end in pairwise(coordinates):
            degrees.update((_key(start), _key(end)))
    return degrees


def _drop_flat_corners(face: Polygon, degrees: Counter[tuple[float, float]]) -> Polygon:
    """Return a face without the points where one straight wall merely goes on."""
    rings = []
    for ring in (face.exterior, *face.interiors):
        points = list(ring.coords)[:-1]
        kept = []
        for k, point in enumerate(points):
            before, after = points[k - 1], points[(k + 1) % len(points)]
            turn = (point[0] - before[0]) * (after[1] - point[1]) - (point[1] - before[1]) * (
                after[0] - point[0]
            )
            scale = math.dist(point, before) * math.dist(after, point)
            if degrees[_key(point)] > 2 or abs(turn) > 1e-3 * scale:
                kept.append(point)
        rings.append(kept)
    return Polygon(rings[0], rings[1:])


def side_labels(face: Polygon, walls: Sequence[PixelWall]) -> dict[str, float]:
    """Return the total length (pixels) of the walls around `face` by their label on its side."""
    votes: dict[str, float] = defaultdict(float)
    for wall in walls:
        if wall.labels is None or wall.start == wall.end:
            continue
        line = LineString([wall.start, wall.end])
        near = line.intersection(face.boundary.buffer(JOIN_MARGIN / 2))
        if near.length < min(JOIN_MARGIN, line.length / 2):
            continue
        middle = np.array(near.interpolate(0.5, normalized=True).coords[0])
        direction = np.subtract(wall.end, wall.start) / line.length
        # Left of the direction in a frame with y down.
        left = np.array([direction[1], -direction[0]])
        for label, sign in zip(wall.labels, (1.0, -1.0), strict=True):
            if face.contains(ShapelyPoint(middle + sign * 1.5 * JOIN_MARGIN * left)):
                votes[label] += near.length
    return dict(votes)


#: The reference converter's constants, in metres.
WALL_HEIGHT = 2.8
WALL_DEPTH = 0.1
BALCONY_WALL_HEIGHT = 1.4
DOOR_HEIGHTS = (0.0, 2.5)
WINDOW_HEIGHTS = (1.0, 2.0)
DOOR_MARGIN = 20.0  #: An opening this near (pixels) to a wall lies on it
#: A label or entrance belongs to the room that holds at least this share of its box.
LABEL_SHARE = 0.4
ENTRANCE_SHARE = 0.6
_LOW_WALLED = frozenset({"Balcony"})  #: Rooms whose own outer walls are parapets


def house_of_r2v(text: str, house_id: str, metres_per_pixel: float, *, file: str = "") -> House:
    """Return the house of raster-to-vector text of either dialect.

    Rooms are the faces that the walls close. Openings between two rooms are doors, and so is the
    opening to the outside that is nearest to an entrance. The others are windows.
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
        # An entrance or stairs name a room only if no label does.
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
            arguments = (source, placed, [segment])
            placed = place_openings(*arguments, tolerance=tolerance, both_sides=False)
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
    """Return a wall with its openings as doors or windows of the usual heights, cut to its own."""
    openings = []
    for opening in wall.openings:
        door = len(wall.room_ids) > 1 or opening.id in doors
        kind, (bottom, top) = ("door", DOOR_HEIGHTS) if door else ("window", WINDOW_HEIGHTS)
        top = min(top, wall.height)
        openings.append(replace(opening, kind=kind, bottom=bottom, top=top))
    return replace(wall, openings=tuple(openings))


def _look(plan: PlanFile) -> Unscaled:
    """Return the size of the plan: the extent of its walls."""
    walls = parse_r2v(Source("", plan.house_id), plan.text).walls
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
