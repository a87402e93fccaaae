"""Build a house from the drawing of another program, with one storey or several.

A drawing has rooms as outlines, walls as axes with a thickness, or both; openings are segments.
Rooms without walls get walls along their outlines. Walls without rooms get the rooms that they
close (:mod:`plan2scene_app.plan_formats.axes`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from shapely import unary_union
from shapely.geometry import LineString, Polygon
from shapely.geometry import Point as Place
from shapely.strtree import STRtree

from plan2scene.errors import InputError
from plan2scene.house import (
    DEFAULT_HEIGHT,
    House,
    IconBox,
    Level,
    Opening,
    Point,
    Ring,
    Room,
    Stairs,
    Wall,
)
from plan2scene.plans.geometry import find_doors, walls_of_rooms
from plan2scene.plans.levels import STAIRS, linked
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import MAX_CORNERS, MAX_ROOMS, Source
from plan2scene.plans.room_names import room_types
from plan2scene_app.ids import free_id
from plan2scene_app.plan_formats.axes import (
    DEFAULT_THICKNESS,
    HEIGHTS,
    MAX_PAIRS,
    SETTINGS,
    WallAxis,
    distinct,
    gaps_in_line,
    rooms_of_axes,
)

#: Largest number of openings of a plan.
MAX_OPENINGS = 2000
#: Largest number of lost openings that get a warning each; more are counted in one warning.
MAX_LINES = 3


@dataclass(frozen=True)
class DrawnRoom:
    """A room as drawn: its name as written, its rings (x, z) in metres, its height if given.

    `types` are given by some formats, else they are read from the name. `called` tells whether a
    person gave the name (not a program), so that it is shown to people.
    """

    name: str
    rings: tuple[Ring, ...]
    height: float | None = None
    types: tuple[str, ...] = ()
    called: bool = True


@dataclass
class Drawing:
    """What a format's reader found in a file: points (x, z) in metres."""

    rooms: list[DrawnRoom] = field(default_factory=list)
    axes: list[WallAxis] = field(default_factory=list)
    openings: list[Segment] = field(default_factory=list)
    icons: list[IconBox] = field(default_factory=list)
    stairs: list[Stairs] = field(default_factory=list)  # to the next storey, from the lower end
    height: float = DEFAULT_HEIGHT
    asked: int = 0  # number of calls of `shows`

    def add_room(self, room: DrawnRoom) -> None:
        """Add a room; InputError for too many rooms or too many corners of a room."""
        if len(self.rooms) >= MAX_ROOMS:
            raise InputError(f"at most {MAX_ROOMS} rooms", "more")
        if (corners := sum(map(len, room.rings))) > MAX_CORNERS:
            raise InputError(f"at most {MAX_CORNERS} corners of a room", str(corners))
        self.rooms.append(room)

    def floor(self) -> float:
        """Return the area of the rooms in square metres."""
        return sum(Polygon(room.rings[0]).area for room in self.rooms)

    def size(self) -> float:
        """Return the floor area in square metres plus 0.001 for each metre of wall."""
        lengths = (math.dist(axis.start, axis.end) for axis in self.axes)
        return self.floor() + 1e-3 * sum(lengths)

    def shows(self, start: Point, end: Point, kind: str | None = None) -> bool:
        """Return whether the drawing has an opening (of the kind, if given) at this segment.

        Raises InputError after twice `MAX_OPENINGS` calls, as two rooms may show each opening.
        """
        self.asked += 1
        if self.asked > 2 * MAX_OPENINGS:
            raise InputError(f"at most {MAX_OPENINGS} doors and windows", "more")
        middle = np.add(start, end) / 2
        offsets = (
            np.add(o.start, o.end) / 2 - middle for o in self.openings if kind in (None, o.kind)
        )
        return any(float(np.hypot(*offset)) < SETTINGS.same_opening for offset in offsets)


def largest_storey(source: Source, storeys: Sequence[tuple[str, float]]) -> int:
    """Return the index of the largest storey (name, size); warn that the others are left out."""
    chosen = max(range(len(storeys)), key=lambda k: storeys[k][1])
    if len(storeys) > 1:
        left = ", ".join(name for k, (name, _) in enumerate(storeys) if k != chosen)
        source.warn("one storey", f"{len(storeys)}; {storeys[chosen][0]} read, left out {left}")
    return chosen


def house_of_drawing(source: Source, drawing: Drawing, taken: set[str] | None = None) -> House:
    """Return the house of a drawing; its rooms get ids not yet in `taken`, which are added there.

    An opening without a wall near it is left out with a warning. Raises InputError if there are
    neither rooms nor walls that close one, or too many of anything.
    """
    source.identifier(source.house_id, "a house name")
    drawing = replace(drawing, axes=distinct(drawing.axes))
    if len(drawing.openings) > MAX_OPENINGS:
        raise source.fault(f"at most {MAX_OPENINGS} doors and windows", len(drawing.openings))
    rooms = _rooms(source, drawing, set() if taken is None else taken)
    source.limit_corners(rooms)
    _doubt(source, drawing, rooms)
    along = _Axes(drawing.axes)
    walls = [along.applied(wall) for wall in walls_of_rooms(rooms, depth=DEFAULT_THICKNESS)]
    walls = _with_openings(source, walls, drawing.openings, along)
    walls = [_cut_to_height(wall) for wall in walls]
    if drawing.axes:
        walls = [_opened(wall, along, number) for number, wall in enumerate(walls)]
    return House(
        id=source.house_id,
        rooms=tuple(rooms),
        walls=tuple(walls),
        doors=find_doors(rooms, walls),
        icons=tuple(drawing.icons),
        warnings=tuple(source.warnings),
    )


def _doubt(source: Source, drawing: Drawing, rooms: Sequence[Room]) -> None:
    """Warn of unlikely room sizes and of walls without a room; refuse an impossible floor area."""
    polygons = [Polygon(room.rings[0], room.rings[1:]) for room in rooms]
    floor = sum(polygon.area for polygon in polygons)
    if floor > SETTINGS.most_floor[1]:
        expected = f"at most {SETTINGS.most_floor[1]:,.0f} m2 of a storey (is the unit right?)"
        raise source.fault(expected, f"{floor:,.0f} m2")
    if floor > SETTINGS.most_floor[0]:
        source.warn("the floor of a home", f"{floor:,.0f} m2: please check the unit")
    tallest = max(room.height for room in rooms)
    if tallest > SETTINGS.most_height:
        source.warn(f"rooms up to {SETTINGS.most_height:g} m high", f"{tallest:.1f} m")
    if not drawing.axes:
        return
    beside = _bordering(drawing.axes, polygons)
    if bordering_share(drawing.axes, polygons) < SETTINGS.bordering:
        what = f"{len(rooms)} rooms; {beside.count(False)} of {len(beside)} walls border none"
        source.warn("walls that close rooms", f"{what}, left out")


def _bordering(axes: Sequence[WallAxis], rooms: Sequence[Polygon]) -> list[bool]:
    """Return for each wall whether it runs along a room's outline."""
    reach = SETTINGS.opening_reach + max(axis.thickness for axis in axes) / 2
    near = unary_union([room.boundary for room in rooms]).buffer(reach)
    lines = [LineString([axis.start, axis.end]) for axis in axes]
    return [near.intersection(line).length >= line.length / 2 for line in lines]


def bordering_share(axes: Sequence[WallAxis], rooms: Sequence[Polygon]) -> float:
    """Return the share, of the length of all walls, of walls along a room's outline."""
    lengths = [math.dist(axis.start, axis.end) for axis in axes]
    beside = _bordering(axes, rooms)
    return sum(v for v, has in zip(lengths, beside, strict=True) if has) / max(sum(lengths), 1e-9)


def _rooms(source: Source, drawing: Drawing, taken: set[str]) -> list[Room]:
    """Return the drawn rooms, and those that walls close where no room is drawn."""
    drawn_rooms = list(drawing.rooms)
    if len(drawn_rooms) > MAX_ROOMS:
        raise source.fault(f"at most {MAX_ROOMS} rooms", len(drawn_rooms))
    corners = sum(len(ring) for room in drawn_rooms for ring in room.rings)
    if corners > MAX_CORNERS:
        raise source.fault(f"at most {MAX_CORNERS} corners of all rooms", corners)
    polygons = [Polygon(room.rings[0], room.rings[1:]) for room in drawn_rooms]
    polygons = [area if area.is_valid else area.convex_hull for area in polygons]
    tree = STRtree(polygons)
    faces = closed_rooms(source, drawing) if drawing.axes else []
    for face in faces:
        covered = sum(face.intersection(polygons[k]).area for k in tree.query(face))
        if covered <= SETTINGS.drawn_share * face.area:
            rings = (face.exterior, *face.interiors)
            drawn_rooms.append(DrawnRoom("", tuple(_ring(ring) for ring in rings)))
    if not drawn_rooms:
        what = f"{len(drawing.axes)} walls that close none" if drawing.axes else "none"
        raise source.fault("rooms, or walls that close some", what)
    if len(drawn_rooms) > MAX_ROOMS:
        raise source.fault(f"at most {MAX_ROOMS} rooms", len(drawn_rooms))
    rooms = []
    for room in drawn_rooms:
        name = free_id(room.name, taken)
        types = room.types or room_types(room.name)
        if not types:
            source.warn("a name that tells what room it is", f"{room.name!r}; Unknown", name)
        rings = tuple(source.outline(ring, name) for ring in room.rings)
        height = room.height or drawing.height
        shown_name = source.shown_name(room.name) if room.called else ""
        rooms.append(Room(name, types or ("Unknown",), rings, height, name=shown_name))
    return rooms


def closed_rooms(source: Source, drawing: Drawing) -> list[Polygon]:
    """Return the floors that the walls of a drawing close.

    If it has no rooms, gaps between walls in line become passages, with a warning: they are added
    to its `axes` and `openings`.
    """
    faces = rooms_of_axes(source, drawing.axes)
    gaps = [] if drawing.rooms else gaps_in_line(drawing.axes)
    if not gaps:
        return faces
    reach = SETTINGS.touch + max(axis.thickness for axis in drawing.axes) / 2
    for _ in range(2):  # drop the gaps that close a cupboard, then those beside them
        closed = rooms_of_axes(source, [*drawing.axes, *gaps])
        tree = STRtree([face.exterior for face in closed])
        kept = []
        for gap in gaps:
            middle = Place(np.add(gap.start, gap.end) / 2)
            beside = tree.query(middle, predicate="dwithin", distance=reach)
            areas = [closed[k].area for k in beside]
            kept += [gap] if areas and min(areas) >= SETTINGS.gap_room else []
        gaps = kept
    closed = rooms_of_axes(source, [*drawing.axes, *gaps])
    if len(closed) <= len(faces):
        return faces
    opened = []
    for gap in gaps:
        drawing.axes.append(gap)
        if not drawing.shows(gap.start, gap.end):
            opened.append(math.dist(gap.start, gap.end))
            name = f"gap_{len(drawing.openings)}"
            drawing.openings.append(
                Segment(name, "passage", gap.start, gap.end, *HEIGHTS["passage"])
            )
    if opened:
        widths = f"{len(opened)} of {min(opened):.2f} to {max(opened):.2f} m"
        source.warn("walls without gaps", f"{widths}, read as passages: please look")
    return closed


def _ring(ring: LineString) -> Ring:
    return tuple((float(x), float(z)) for x, z in list(ring.coords)[:-1])


class _Axes:
    """Finds the wall axes that lie along a segment."""

    def __init__(self, axes: Sequence[WallAxis]) -> None:
        self.axes = axes
        self._lines = [LineString([axis.start, axis.end]) for axis in axes]
        self._tree = STRtree(self._lines)
        self._reach = (
            max((axis.thickness for axis in axes), default=0.0) / 2 + SETTINGS.opening_slack
        )

    def near(self, start: tuple[float, float], end: tuple[float, float]) -> list[tuple[float, int]]:
        """Return (metres of the segment along an axis, index of the axis), longest first."""
        line = LineString([start, end])
        followed = []
        for k in self._tree.query(line, predicate="dwithin", distance=self._reach):
            axis = self.axes[k]
            if not _parallel(start, end, axis):
                continue
            band = self._lines[k].buffer(
                axis.thickness / 2 + SETTINGS.opening_slack / 2, cap_style="flat"
            )
            length = line.intersection(band).length
            if length > 0:
                followed.append((float(length), int(k)))
        return sorted(followed, key=lambda pair: (-pair[0], pair[1]))

    def applied(self, wall: Wall) -> Wall:
        """Return a wall with the thickness and height of the axis along most of it."""
        followed = self.near(wall.start, wall.end)
        if not followed:
            return wall
        axis = self.axes[followed[0][1]]
        depth = axis.thickness or DEFAULT_THICKNESS
        return replace(wall, depth=depth, height=axis.height or wall.height)

    def thickness(self, segment: Segment) -> float | None:
        """Return the thickness of an opening's wall; None if there is no wall or no thickness."""
        followed = self.near(segment.start, segment.end)
        return self.axes[followed[0][1]].thickness or None if followed else None

    def share(self, wall: Wall) -> float:
        """Return the share of a wall's length with axes along it."""
        return min(sum(length for length, _ in self.near(wall.start, wall.end)) / wall.length, 1.0)


def _parallel(start: tuple[float, float], end: tuple[float, float], axis: WallAxis) -> bool:
    """Return whether a segment and an axis are nearly parallel."""
    a, b = np.subtract(end, start), np.subtract(axis.end, axis.start)
    cross = abs(a[0] * b[1] - a[1] * b[0])
    return bool(cross <= math.sin(SETTINGS.wall_angle) * float(np.hypot(*a) * np.hypot(*b)))


def _with_openings(
    source: Source, walls: list[Wall], openings: Sequence[Segment], along: _Axes
) -> list[Wall]:
    """Return the walls with the openings placed in them; openings near no wall give a warning."""
    placed, pairs = list(walls), 0
    lost: list[str] = []
    tree = STRtree([LineString([wall.start, wall.end]) for wall in walls])
    for segment in openings:
        thickness = along.thickness(segment)
        reach = (
            SETTINGS.opening_reach if thickness is None else thickness / 2 + SETTINGS.opening_slack
        )
        line = LineString([segment.start, segment.end])
        near = sorted(tree.query(line, predicate="dwithin", distance=2 * reach).tolist())
        pairs += len(near)
        if pairs > MAX_PAIRS:
            raise source.fault(f"at most {MAX_PAIRS} pairs of an opening and a wall", "more")
        try:
            changed = place_openings(source, [placed[k] for k in near], [segment], tolerance=reach)
        except InputError as error:
            lost.append(f"{error}; left out")
            continue
        for k, wall in zip(near, changed, strict=True):
            placed[k] = wall
    source.warnings.extend(lost[:MAX_LINES])
    if len(lost) > MAX_LINES:
        found = f"{len(lost)} of {len(openings)} that are in none, left out"
        source.warn("doors and windows in walls of rooms", found)
    return placed


def _cut_to_height(wall: Wall) -> Wall:
    """Return a wall with its openings cut to its height; those above its top are left out."""
    openings = (
        replace(opening, bottom=max(opening.bottom, 0.0), top=min(opening.top, wall.height))
        for opening in wall.openings
    )
    return replace(wall, openings=tuple(o for o in openings if o.top - o.bottom > 0.05))


def _opened(wall: Wall, along: _Axes, number: int) -> Wall:
    """Return a wall of two rooms as an open passage if no axis lies along it, else as it is."""
    open_line = len(wall.room_ids) == 2 and not wall.openings and wall.length >= SETTINGS.passage
    if not open_line or along.share(wall) >= SETTINGS.walled:
        return wall
    passage = Opening(f"open_{number}", "passage", 0.0, wall.length, 0.0, wall.height)
    return replace(wall, openings=(passage,))


#: Words in the name of a piece of furniture that mean stairs.
STAIR_WORDS = frozenset(
    {"stairs", "staircase", "stair", "treppe", "escalier", "escalera", "scala", "scale", "trap"}
)


@dataclass(frozen=True)
class DrawnStorey:
    """A storey's name as written, its floor's elevation in metres, and what is drawn on it."""

    name: str
    elevation: float
    drawing: Drawing


def house_of_storeys(source: Source, storeys: Iterable[DrawnStorey]) -> House:
    """Return the house of storeys one above the other; a single storey gives no levels.

    Of storeys at nearly the same elevation only the largest is read. The others, and storeys
    without rooms, are left out with a warning. Raises InputError if no storey has rooms.
    """
    apart = _apart(source, sorted(storeys, key=lambda storey: storey.elevation))
    if len(apart) == 1:
        return house_of_drawing(source, apart[0].drawing)
    houses: list[tuple[Level, House]] = []
    stairs: list[Stairs] = []
    taken: set[str] = set()
    names: set[str] = set()
    fault: InputError | None = None
    base = apart[0].elevation if apart and abs(apart[0].elevation) > SETTINGS.far else 0.0
    for storey in apart:
        try:
            house = house_of_drawing(source, storey.drawing, taken)
        except InputError as error:
            fault = error
            source.warnings.append(f"{error} on level {storey.name}; left out")
            continue
        height = storey.drawing.height
        label = storey.name.encode("utf-8", "replace").decode()  # replaces half a surrogate pair
        level = Level(free_id(storey.name, names, "floor"), label, storey.elevation - base, height)
        houses.append((level, house))
        stairs += [replace(flight, level=level.id) for flight in storey.drawing.stairs]
    if not houses:
        raise fault or source.fault("storeys with rooms", "none")
    return _joined(source, houses, stairs)


def _apart(source: Source, storeys: Sequence[DrawnStorey]) -> list[DrawnStorey]:
    """Return storeys, sorted by elevation, without those near the elevation of a larger one."""
    kept: list[DrawnStorey] = []
    for storey in storeys:
        if not kept or storey.elevation - kept[-1].elevation >= STAIRS.least_rise:
            kept.append(storey)
            continue
        small, large = sorted((kept[-1], storey), key=lambda one: one.drawing.size())
        kept[-1] = large
        expected = f"levels at least {STAIRS.least_rise:g} m apart"
        source.warn(expected, f"{small.name} beside {large.name}; left out")
    return kept


def _joined(
    source: Source, storeys: Sequence[tuple[Level, House]], stairs: Sequence[Stairs]
) -> House:
    """Return one house of several levels, or the house as it is for a single one."""
    if len(storeys) == 1:
        return replace(storeys[0][1], warnings=tuple(source.warnings))
    levels = tuple(level for level, _ in storeys)
    renamed = [_on_level(level, house) for level, house in storeys]
    rooms = [room for house in renamed for room in house.rooms]
    pieces = [icon for house in renamed for icon in house.icons]
    file_flights = [flight for flight in stairs if flight.level != levels[-1].id]
    flights = (*linked(file_flights, rooms, levels), *flights_of(pieces, rooms, levels))
    flights = tuple(replace(flight, id=f"stairs_{k}") for k, flight in enumerate(flights))
    return House(
        id=source.house_id,
        rooms=tuple(rooms),
        walls=tuple(wall for house in renamed for wall in house.walls),
        doors=tuple(door for house in renamed for door in house.doors),
        icons=tuple(icon for icon in pieces if not _climbs(icon, levels)),
        levels=levels,
        stairs=flights,
        warnings=tuple(source.warnings),
    )


def _on_level(level: Level, house: House) -> House:
    """Return a house with everything put on a level, and with its id in the ids of openings."""

    def named(opening_id: str) -> str:
        return f"{level.id}_{opening_id}"

    walls = [
        replace(wall, openings=tuple(replace(o, id=named(o.id)) for o in wall.openings))
        for wall in house.walls
    ]
    return replace(
        house,
        rooms=tuple(replace(room, level=level.id) for room in house.rooms),
        walls=tuple(walls),
        doors=tuple(replace(door, opening_id=named(door.opening_id)) for door in house.doors),
        icons=tuple(replace(icon, level=level.id) for icon in house.icons),
    )


def _climbs(icon: IconBox, levels: Sequence[Level]) -> bool:
    """Return whether a piece of furniture is stairs to a level above its own."""
    words = re.findall(r"[a-zäöüéè]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", icon.type).lower())
    sides = (abs(icon.p2[0] - icon.p1[0]), abs(icon.p2[1] - icon.p1[1]))
    return (
        bool(STAIR_WORDS.intersection(words))
        and icon.level != levels[-1].id
        and max(sides) >= STAIRS.least_flight
        and min(sides) > 0
    )


def flights_of(
    icons: Iterable[IconBox], rooms: Sequence[Room], levels: Sequence[Level]
) -> tuple[Stairs, ...]:
    """Return the stairs among pieces of furniture as flights along their longer side.

    Files do not say which end is the upper one: the direction that joins more rooms is taken.
    """
    flights: list[Stairs] = []
    for icon in icons:
        if not _climbs(icon, levels):
            continue
        (x0, z0), (x1, z1) = icon.p1, icon.p2
        if abs(x1 - x0) >= abs(z1 - z0):
            middle = (z0 + z1) / 2
            start, end, width = (x0, middle), (x1, middle), abs(z1 - z0)
        else:
            middle = (x0 + x1) / 2
            start, end, width = (middle, z0), (middle, z1), abs(x1 - x0)
        both = [Stairs("", icon.level, *ends, width) for ends in ((start, end), (end, start))]
        ways = linked(both, rooms, levels)
        flights.append(min(ways, key=lambda way: way.room_ids.count(None)))
    return tuple(flights)
