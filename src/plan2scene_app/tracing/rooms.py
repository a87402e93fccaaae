"""The traced rooms: their polygons, names as written, types and ids.

Every long straight piece of a room's outline gives a line; nearly equal lines along the picture's
axes are merged. The lines cut the plane into cells. A cell belongs to the room that covers most of
it, and the cells of a room make its polygon, so that neighbours share their walls.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from scipy import ndimage
from shapely.geometry import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry
from skimage.measure import find_contours

from plan2scene.house import OPEN_AIR
from plan2scene.plans.room_names import room_types
from plan2scene_app.ids import free_id
from plan2scene_app.plan_formats.measures import (
    read_areas,
    read_length,
    read_sides,
    without_measures,
)
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.openings import TracedOpening, edge_of, edges_of
from plan2scene_app.tracing.regions import Regions
from plan2scene_app.tracing.settings import LABEL_OF_TYPE, ROOM, SETTINGS


@dataclass(frozen=True)
class _Piece:
    """A straight piece of an outline in pixels; `points` (n, 2) are the outline's points on it."""

    start: np.ndarray
    end: np.ndarray
    points: np.ndarray

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))

    @property
    def axis(self) -> int | None:
        """0 along x, 1 along y, None for neither."""
        dx, dy = np.abs(self.end - self.start)
        angle = np.degrees(np.arctan2(dy, dx))
        if angle < SETTINGS.along_axis:
            return 0
        return 1 if angle > 90 - SETTINGS.along_axis else None


def room_polygons(regions: Regions, numbers: Sequence[int] | None = None) -> dict[int, Polygon]:
    """Return the polygons (pixels x, y) by the room's number; rooms that get no cells are left out.

    `numbers` are the rooms of one drawing; all rooms by default.
    """
    numbers = range(1, regions.count + 1) if numbers is None else numbers
    boxes = ndimage.find_objects(regions.rooms, regions.count)
    pieces = [p for n in numbers if boxes[n - 1] for p in _pieces(regions, n, boxes[n - 1])]
    straight = [[p for p in pieces if p.axis == axis] for axis in (0, 1)]
    slanted = [
        p for p in pieces if p.axis is None and p.length > 1.5 * SETTINGS.shortest * regions.ppm
    ]
    least = max(SETTINGS.merged * regions.ppm, 0.6 * regions.wall_px, 2.0)
    ys = _coordinates(straight[0], 1, SETTINGS.shortest * regions.ppm, least)
    xs = _coordinates(straight[1], 0, SETTINGS.shortest * regions.ppm, least)
    if len(xs) < 2 or len(ys) < 2:
        return {}
    return _cells(regions, numbers, xs, ys, _slanted_lines(slanted, least))


def _pieces(regions: Regions, number: int, box: tuple[slice, slice]) -> list[_Piece]:
    """Return the straight pieces of a room's outlines; `box` is the room's rows and columns."""
    mask = np.pad(regions.rooms[box] == number, 1).astype(np.float32)
    tolerance = max(1.5, SETTINGS.tolerance * regions.ppm)
    pieces = []
    for contour in find_contours(mask, 0.5):
        ring = contour[:-1, ::-1] - 1 + (box[1].start, box[0].start)
        if len(ring) < 8:
            continue
        corners = cv2.approxPolyDP(ring.astype(np.float32)[:, None], tolerance, True)[:, 0]
        places = [int(np.argmin(np.abs(ring - corner).sum(1))) for corner in corners]
        for a, b in zip(places, places[1:] + places[:1], strict=True):
            along = ring[a : b + 1] if b > a else np.concatenate([ring[a:], ring[: b + 1]])
            if len(along) < 3:
                continue
            trim = len(along) // 6
            pieces.append(_Piece(ring[a], ring[b], along[trim : len(along) - trim]))
    return pieces


def _coordinates(pieces: list[_Piece], across: int, shortest: float, least: float) -> list[float]:
    """Return the x (`across` 0) or y (1) of the pieces' lines, at least `least` pixels apart."""
    places = sorted(
        (float(np.median(p.points[:, across])), p.length) for p in pieces if p.length >= shortest
    )
    groups: list[list[tuple[float, float]]] = []
    for place, length in places:
        if groups and place - _mean(groups[-1]) < least:
            groups[-1].append((place, length))
        else:
            groups.append([(place, length)])
    return [_mean(group) for group in groups]


def _mean(group: list[tuple[float, float]]) -> float:
    """Return the mean of places weighted by length."""
    places, lengths = np.array(group).T
    return float((places * lengths).sum() / lengths.sum())


def _slanted_lines(pieces: list[_Piece], least: float) -> list[LineString]:
    """Return one line for each slanted wall, although both rooms beside it have a piece of it."""
    lines: list[LineString] = []
    for piece in sorted(pieces, key=lambda p: -p.length):
        way = (piece.end - piece.start) / piece.length
        own = LineString([piece.start - way * 2 * least, piece.end + way * 2 * least])
        middle = shapely.Point((piece.start + piece.end) / 2)
        if all(line.distance(middle) > 1.5 * least for line in lines):
            lines.append(own)
    return lines


def _cells(
    regions: Regions,
    numbers: Sequence[int],
    xs: list[float],
    ys: list[float],
    slanted: list[LineString],
) -> dict[int, Polygon]:
    """Return each room's polygon, made of its cells between the lines."""
    grid = [LineString([(x, ys[0]), (x, ys[-1])]) for x in xs]
    grid += [LineString([(xs[0], y), (xs[-1], y)]) for y in ys]
    cells = list(shapely.get_parts(shapely.polygonize([shapely.union_all([*grid, *slanted])])))
    plane = np.zeros(regions.rooms.shape, np.int32)
    for number, cell in enumerate(cells, start=1):
        corners = np.round((np.array(cell.exterior.coords)[:-1] + 0.0) * 16).astype(np.int32)
        cv2.fillPoly(plane, [corners[:, None]], number, cv2.LINE_8, 4)
    count = regions.count + 1
    votes = np.bincount((plane * count + regions.rooms).ravel(), minlength=(len(cells) + 1) * count)
    winners = votes.reshape(-1, count)[: len(cells) + 1].argmax(1)
    polygons = {}
    for number in numbers:
        room_cells = [
            cell for cell, winner in zip(cells, winners[1:], strict=True) if winner == number
        ]
        shape = _largest(shapely.union_all(room_cells, grid_size=1e-3) if room_cells else Polygon())
        shape = without_spikes(shape.simplify(0.01), SETTINGS.spike * regions.ppm)
        # A room much smaller than its floor has lost its cells to another room: leave it out.
        floor = float((regions.floors == number).sum())
        if isinstance(shape, Polygon) and shape.is_valid and shape.area > floor / 2:
            polygons[number] = shape
    return polygons


def _largest(shape: BaseGeometry) -> BaseGeometry:
    """Return the largest part of a geometry."""
    if isinstance(shape, MultiPolygon):
        return max(shape.geoms, key=lambda part: part.area)
    return shape


def without_spikes(shape: BaseGeometry, width: float) -> BaseGeometry:
    """Return a polygon (pixels) without parts narrower than a width, or itself if it has none."""
    opened = shape.buffer(-width / 2, join_style="mitre").buffer(width / 2, join_style="mitre")
    opened = _largest(shapely.set_precision(opened, 1e-3)).simplify(0.01)
    return shape if shape.area - opened.area < 1.0 else opened


@dataclass(frozen=True)
class TracedRoom:
    """A room in pixels of the frame."""

    number: int  #: in the regions
    polygon: Polygon
    id: str
    name: str  #: as written, empty for none
    types: tuple[str, ...]
    named: bool  #: whether the types come from the written name
    confidence: float  #: mean probability of room over its floor
    texts: tuple[TextLine, ...]
    drawing: int = 1  #: number of the drawing that it lies in


def describe_rooms(
    regions: Regions,
    polygons: dict[int, Polygon],
    probabilities: np.ndarray,
    lines: Sequence[TextLine],
) -> list[TracedRoom]:
    """Return the rooms with names and types; `lines` of text are in the frame's pixels."""
    rooms: list[TracedRoom] = []
    taken: set[str] = set()
    boxes = ndimage.find_objects(regions.floors, regions.count)
    for number, polygon in polygons.items():
        room_lines = tuple(line for line in lines if polygon.contains(Point(line.middle)))
        name = _name_of(room_lines)[:60]
        types = _types_by_names([line.text for line in room_lines])
        box = boxes[number - 1]
        inside = probabilities[:, *box][:, regions.floors[box] == number].mean(1)
        kinds = types or _types_by_furniture(inside)
        base = name if types and name else kinds[0]
        sure = float(inside[ROOM:].sum())
        identifier = free_id(base, taken)
        rooms.append(
            TracedRoom(number, polygon, identifier, name, kinds, bool(types), sure, room_lines)
        )
    return rooms


def with_types_by_marks(
    rooms: Sequence[TracedRoom],
    openings: Sequence[TracedOpening],
    regions: Regions,
    image: np.ndarray,
    treads: Mapping[int, float],
    metres: float,
) -> list[TracedRoom]:
    """Return rooms, the unnamed ones with types by their size, doors and what is drawn in them.

    A plan that names its rooms often leaves only baths, halls, wardrobes and stairs unnamed. A type
    that the network saw is therefore kept only if no name on the plan gives it. If fewer than half
    have a name, only treads tell more. `image` (h, w, 3) uint8 has no text; `treads` is the share
    of each room's floor under treads; `metres` is the size of a pixel.
    """
    if 2 * sum(room.named for room in rooms) < len(rooms):
        taken = {room.id for room in rooms}
        stairs = {r.number for r in rooms if not r.named and treads[r.number] > SETTINGS.stairs}
        return [
            replace(room, types=("Staircase",), id=free_id("Staircase", taken))
            if room.number in stairs
            else room
            for room in rooms
        ]
    named_types = {kind for room in rooms if room.named for kind in room.types}
    light = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    slopes = cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1)
    edge = np.hypot(*slopes) > SETTINGS.mark_slope
    angle = np.degrees(np.arctan2(*np.abs(slopes)))
    askew = (angle > SETTINGS.askew[0]) & (angle < SETTINGS.askew[1]) & edge
    taken = {room.id for room in rooms if _told(room, named_types)}
    typed_rooms = []
    for room in rooms:
        if _told(room, named_types):
            typed_rooms.append(room)
            continue
        floor = (regions.floors == room.number).astype(np.uint8)
        inside = cv2.erode(floor, np.ones((5, 5), np.uint8)) > 0
        marks = int((edge & inside).sum())
        dense = marks / max(1, int(inside.sum())) / metres  # metres of edge for a square metre
        swings = int((askew & inside).sum()) > SETTINGS.swing_share * marks
        ways = sum(o.kind != "window" and room.number in (o.room, o.other) for o in openings)
        area = float(floor.sum()) * metres**2
        # Basins and tubs are as round as arcs: if no bath is named, only halls may have door arcs.
        swings = swings and ("Bathroom" in named_types or ways >= SETTINGS.ways_of_hall)
        kind = _type_by_marks(area, dense, ways, swings=swings)
        if treads[room.number] > SETTINGS.stairs:
            kind = "Staircase"
        types = (kind,) if kind else room.types
        typed_rooms.append(replace(room, types=types, id=free_id(types[0], taken)))
    return typed_rooms


def _told(room: TracedRoom, named: Collection[str]) -> bool:
    """Return whether a room's type is settled: by its name, or by furniture if no name gives it."""
    return room.named or room.types[0] not in {"Unknown", "Corridor", "Closet", *named}


def _type_by_marks(area: float, dense: float, ways: int, *, swings: bool) -> str:
    """Return the type of an unnamed room of `area` m2, or "" if nothing shows it.

    `dense` is metres of edge a m2, `ways` counts doors and passages, `swings`: doors swing into it.
    """
    low, high = SETTINGS.bath
    fixtures = dense > (SETTINGS.fixtures_by_swings if swings else SETTINGS.fixtures)
    if fixtures and ways and low < area < high:
        return "Bathroom"
    hall = ways >= SETTINGS.ways_of_hall
    if area < low or (dense < SETTINGS.fixtures and not hall and area < SETTINGS.largest_closet):
        return "Closet"
    return "Corridor" if hall and (swings or dense < SETTINGS.fixtures) else ""


def without_inner_windows(
    openings: Sequence[TracedOpening], rooms: Sequence[TracedRoom], widest: float
) -> list[TracedOpening]:
    """Return openings with each window between two indoor rooms as a door or a passage.

    The network takes a gap with nothing drawn in it for a window. Up to `widest` pixels it becomes
    a door, else a passage, with a confidence of at most 0.5.
    """
    indoors = {room.number for room in rooms if not OPEN_AIR.intersection(room.types)}
    kept = []
    for opening in openings:
        if opening.kind == "window" and {opening.room, opening.other} <= indoors:
            kind = "door" if opening.width <= widest else "passage"
            sure = min(opening.confidence, 0.5)
            opening = replace(opening, kind=kind, confidence=sure)
        kept.append(opening)
    return kept


def without_rails(
    openings: Sequence[TracedOpening], polygons: Mapping[int, Polygon], open_air: Set[int]
) -> list[TracedOpening]:
    """Return openings without the rails of terraces and balconies, which look like long windows.

    `open_air` are the numbers of these rooms.
    """
    edges = edges_of(polygons)
    return [
        opening
        for opening in openings
        if opening.kind != "window"
        or opening.other
        or opening.room not in open_air
        or opening.width < SETTINGS.rail * edge_of(opening, edges).length
    ]


def with_garage_doors(
    openings: Sequence[TracedOpening], garages: Collection[int], least: float
) -> list[TracedOpening]:
    """Return openings with wide windows (from `least` pixels on) of `garages` as garage doors."""
    return [
        replace(opening, kind="door")
        if opening.room in garages and not opening.other and opening.width >= least
        else opening
        for opening in openings
    ]


def with_terrace_doors(
    openings: Sequence[TracedOpening], open_air: Set[int], least: float
) -> list[TracedOpening]:
    """Return openings, the widest window between a room and a terrace as the door between them.

    Sliding doors are drawn like windows. `open_air` are the numbers of terraces, balconies and
    yards, `least` is the least width in pixels. A room gets one door to a terrace at most.
    """
    ways = [{opening.room, opening.other} for opening in openings if opening.kind != "window"]
    doors: list[TracedOpening] = []
    for opening in sorted(openings, key=lambda opening: -opening.width):
        sides = {opening.room, opening.other}
        out = opening.kind == "window" and opening.other and len(open_air & sides) == 1
        if out and opening.width >= least and sides not in ways:
            ways.append(sides)
            doors.append(opening)
    return [
        replace(opening, kind="door", confidence=min(opening.confidence, 0.5))
        if opening in doors
        else opening
        for opening in openings
    ]


def _types_by_names(texts: Sequence[str]) -> tuple[str, ...]:
    """Return the types that the texts in a room give; labels of its wardrobes are ignored."""
    text_types = [types for text in texts if _is_name(text) and (types := room_types(text))]
    text_types = text_types or [types for text in texts if (types := room_types(text))]
    rooms = [types for types in text_types if types != ("Closet",) or not _lived_in(text_types)]
    return tuple(dict.fromkeys(kind for types in rooms for kind in types))


def _lived_in(told: Sequence[tuple[str, ...]]) -> bool:
    return any(set(types) - {"Closet", "Staircase"} for types in told)


def _name_of(lines: Sequence[TextLine]) -> str:
    """Return the name that the texts in a room make: "Dining / Living" where it names two rooms.

    Texts on appliances and wardrobes are left out. A word right above or below a name is added to
    it. A text that is written twice counts once.
    """
    line_by_text: dict[str, TextLine] = {}
    for line in lines:
        if _is_name(line.text):
            line_by_text.setdefault(line.text.casefold(), line)
    names = list(line_by_text.values())
    typed_lines = [line for line in names if room_types(line.text)]
    if _lived_in([room_types(line.text) for line in typed_lines]):
        typed_lines = [line for line in typed_lines if room_types(line.text) != ("Closet",)]
    name, last = "", None
    for line in names:
        more = not room_types(line.text) and any(_stacked(line, one) for one in typed_lines)
        if line not in typed_lines and not more:
            continue
        if last is not None:
            name += " " if _stacked(last, line) else " / "
        name, last = name + without_measures(line.text), line
    return name


def _stacked(one: TextLine, other: TextLine) -> bool:
    """Return whether two lines of text of similar size stand one above the other."""
    across = 0 if one.upright else 1
    apart = np.abs(np.subtract(one.middle, other.middle))
    sizes = np.array([one.size, other.size])
    low, high = np.sort(sizes[:, across])
    near = apart[across] < 1.6 * high and apart[1 - across] < sizes[:, 1 - across].max() / 2
    return bool(one.upright == other.upright and near and high < 1.5 * low)


def _is_name(text: str) -> bool:
    """Return whether a text has a word and is no measure; "Kitchen 12 m2" names a room, too."""
    if read_areas(text) or read_length(text) or read_sides(text):
        return bool(room_types(without_measures(text)))
    return bool(re.search(r"[^\W\d_]{2,}", text.replace(".", "")))


def _types_by_furniture(inside: np.ndarray) -> tuple[str, ...]:
    """Return a room's type by its furniture: `inside` (labels,) are its mean probabilities."""
    kinds = inside[ROOM:]
    best = int(kinds.argmax())
    if best == 0 or kinds[best] < SETTINGS.furniture_share * kinds.sum():
        return ("Unknown",)
    return (next(name for name, label in LABEL_OF_TYPE.items() if label == ROOM + best),)
