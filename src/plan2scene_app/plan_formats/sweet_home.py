"""Reader of Sweet Home 3D files: the Home.xml in the archive (version 5.3 and later).

Centimetres, x right, y down, angles in radians. Only Home.xml is unpacked: the entry Home is a
serialised Java object, and the 3D models are not needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from xml.etree.ElementTree import Element

from plan2scene.house import House, IconBox, Point, Ring
from plan2scene.plans.levels import MAX_LEVELS
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import MAX_ITEMS, Source
from plan2scene.plans.plan_file import PlanFormat
from plan2scene_app.plan_formats.axes import MAX_AXES, SETTINGS, WallAxis
from plan2scene_app.plan_formats.containers import attribute, parse_xml, zip_entry, zip_names
from plan2scene_app.plan_formats.drawing import Drawing, DrawnRoom, DrawnStorey, house_of_storeys

ENTRY = "Home.xml"
#: The file's unit in metres.
CM = 0.01
#: Largest angle of a curved wall, less than a full circle.
MAX_TURN = math.radians(350.0)
_WINDOWS = ("window", "fenster", "fenêtre", "fenetre", "ventana", "finestra", "raam")
_FRAMES = ("frame", "opening", "passage", "arch")
_PIECES = ("pieceOfFurniture", "light", "shelfUnit")


def is_sweet_home(path: Path) -> bool:
    """Return whether an archive is a Sweet Home 3D file, of any version."""
    names = zip_names(path)
    return names is not None and (ENTRY in names or "Home" in names)


def house_of_sweet_home(path: Path, house_id: str) -> House:
    """Return the house of a Sweet Home 3D file with its levels.

    Raises InputError for a file older than version 5.3, which holds a Java object only.
    """
    source = Source(str(path), house_id)
    if ENTRY not in (zip_names(path) or ()):
        expected = "Home.xml in the archive (open it in Sweet Home 3D 5.3 or later and save it)"
        raise source.fault(expected, "a Java object only")
    root = parse_xml(source, zip_entry(source, path, ENTRY))
    if root.tag != "home":
        raise source.fault("<home> in Home.xml", f"<{root.tag}>")
    home = _Home(source, root)
    return house_of_storeys(
        source, _with_layers(home.storey(level) for level in home.drawn_levels())
    )


def _with_layers(storeys: Iterable[DrawnStorey]) -> list[DrawnStorey]:
    """Return storeys, with a layer of rooms only and one of walls at its elevation merged."""
    merged: list[DrawnStorey] = []
    for storey in storeys:
        for k, other in enumerate(merged):
            pair = sorted((storey, other), key=lambda one: not one.drawing.rooms)
            rooms, walls = pair[0].drawing, pair[1].drawing
            level = abs(storey.elevation - other.elevation) < CM
            if level and rooms.rooms and walls.axes and not (rooms.axes or walls.rooms):
                rooms.axes += walls.axes
                rooms.openings += walls.openings
                rooms.icons += walls.icons
                rooms.height = walls.height
                merged[k] = pair[0]
                break
        else:
            merged.append(storey)
    return merged


class _Home:
    """A parsed Home.xml."""

    def __init__(self, source: Source, root: Element) -> None:
        self.source, self.root = source, root
        self.levels = {level.get("id", ""): level for level in root.findall("level")}

    def drawn_levels(self) -> list[str]:
        """Return the ids of levels with rooms or walls, else of the first, "" without levels."""
        drawn_ids = {
            self._level(element.get("level", ""))
            for tag in ("room", "wall")
            for element in self.root.findall(tag)
        }
        if len(drawn_ids) > MAX_LEVELS:
            raise self.source.fault(f"at most {MAX_LEVELS} levels", len(drawn_ids))
        return [name for name in self.levels if name in drawn_ids] or [self._level("")]

    def _level(self, named: str) -> str:
        """Return the level that an element names, or the first if the file has no such level."""
        return named if named in self.levels else next(iter(self.levels), "")

    def _elevation(self, level: str) -> float:
        element = self.levels.get(level)
        return (
            0.0 if element is None else attribute(self.source, element, "elevation", 0.0, scale=CM)
        )

    def storey(self, level: str) -> DrawnStorey:
        """Return a level as a storey with its drawing."""
        element = self.levels.get(level)
        height = attribute(self.source, self.root, "wallHeight", 250.0, scale=CM)
        if element is not None:
            height = attribute(self.source, element, "height", height / CM, scale=CM)
        if height <= 0:
            raise self.source.fault("a wall height above 0", f"{height:g} m")
        name = level if element is None else element.get("name") or level
        return DrawnStorey(name[:100], self._elevation(level), self._drawing(level, height))

    def _drawing(self, level: str, height: float) -> Drawing:
        """Return the drawing of a level: its walls, rooms, openings and furniture."""
        drawing = Drawing(height=height)
        for element in self._on_level(("wall",), level):
            drawing.axes += self._wall(element, height)
            if len(drawing.axes) > MAX_AXES:
                raise self.source.fault(f"at most {MAX_AXES} walls", "more")
        for element in self._on_level(("room",), level):
            if len(element.findall("point")) < 3:
                self.source.warn("rooms of at least 3 points", "one of fewer, left out")
                continue
            ring = self._ring(element)
            drawing.rooms.append(DrawnRoom(element.get("name", "").strip(), (ring,)))
        for number, element in enumerate(self._on_level(("doorOrWindow",), level)):
            drawing.openings.append(self._opening(element, f"opening_{number}"))
        for element in self._on_level(_PIECES, level):
            drawing.icons.append(self._box(element))
        if len(drawing.icons) > MAX_ITEMS:
            raise self.source.fault(f"at most {MAX_ITEMS} pieces of furniture", len(drawing.icons))
        heights = [axis.height for axis in drawing.axes if axis.height > 0]
        drawing.height = max(heights, default=height)
        return drawing

    def _on_level(self, tags: tuple[str, ...], level: str) -> Iterator[Element]:
        """Yield the visible elements with these tags on a level, also those in groups."""
        queue = [(element, element.get("level", "")) for element in reversed(self.root)]
        while queue:
            element, own_level = queue.pop()
            if self._level(own_level) != level:
                continue
            if element.tag == "furnitureGroup":
                queue += [(child, child.get("level", own_level)) for child in reversed(element)]
            elif element.tag in tags and element.get("visible") != "false":
                yield element

    def _ends(self, wall: Element) -> tuple[Point, Point]:
        x0, z0, x1, z1 = (
            attribute(self.source, wall, name, scale=CM)
            for name in ("xStart", "yStart", "xEnd", "yEnd")
        )
        return (x0, z0), (x1, z1)

    def _wall(self, wall: Element, usual: float) -> list[WallAxis]:
        """Return a wall's axis; several for a curved wall.

        A wall without a height is `usual` metres high.
        """
        thickness = attribute(self.source, wall, "thickness", 10.0, scale=CM)
        height = attribute(self.source, wall, "height", usual / CM, scale=CM)
        height = max(height, attribute(self.source, wall, "heightAtEnd", height / CM, scale=CM))
        if thickness < 0 or height <= 0:
            sizes = f"{thickness:g} and {height:g} m"
            raise self.source.fault("a wall's thickness and height above 0", sizes)
        start, end = self._ends(wall)
        points = _arc(start, end, attribute(self.source, wall, "arcExtent", 0.0))
        return [WallAxis(a, b, max(thickness, 0.01), height) for a, b in pairwise(points)]

    def _ring(self, room: Element) -> Ring:
        name = room.get("name") or room.get("id") or "a room"
        points = [
            [attribute(self.source, point, axis, scale=CM) for axis in "xy"]
            for point in room.findall("point")
        ]
        return self.source.outline(points, name)

    def _opening(self, piece: Element, name: str) -> Segment:
        """Return the hole that a door or window cuts into its wall."""

        def share(key: str, default: float) -> float:
            return attribute(self.source, piece, key, default)

        width = attribute(self.source, piece, "width", scale=CM)
        height = attribute(self.source, piece, "height", scale=CM)
        bottom = attribute(self.source, piece, "elevation", 0.0, scale=CM)
        top = bottom + height * (1 - share("wallTop", 0.0))
        bottom = top - height * share("wallHeight", 1.0)
        left = share("wallLeft", 0.0) * width
        right = left + share("wallWidth", 1.0) * width
        if piece.get("modelMirrored") == "true":
            left, right = width - right, width - left
        angle = attribute(self.source, piece, "angle", 0.0)
        x, z = (attribute(self.source, piece, axis, scale=CM) for axis in "xy")
        ends = [
            (x + (at - width / 2) * math.cos(angle), z + (at - width / 2) * math.sin(angle))
            for at in (left, right)
        ]
        if not (width > 0 and top > bottom):
            raise self.source.fault("doors and windows with a size", f"{width:g} x {height:g} m")
        return Segment(name, _kind(piece, bottom), ends[0], ends[1], bottom, top)

    def _box(self, piece: Element) -> IconBox:
        """Return the box around a piece of furniture."""
        angle = attribute(self.source, piece, "angle", 0.0)
        x, z = (attribute(self.source, piece, axis, scale=CM) for axis in "xy")
        width, depth = (
            attribute(self.source, piece, side, 0.0, scale=CM) for side in ("width", "depth")
        )
        c, s = abs(math.cos(angle)), abs(math.sin(angle))
        dx, dz = (width * c + depth * s) / 2, (width * s + depth * c) / 2
        name = (piece.get("name") or piece.get("catalogId") or "furniture")[:100]
        return IconBox(name, (x - dx, z - dz), (x + dx, z + dz))


def _kind(piece: Element, bottom: float) -> str:
    """Return the kind of opening of a piece: window, passage or door."""
    if bottom >= SETTINGS.sill:
        return "window"
    name = f"{piece.get('catalogId', '')} {piece.get('name', '')}".lower()
    if any(word in name for word in _WINDOWS):
        return "window"
    if piece.find("sash") is None and any(word in name for word in _FRAMES):
        return "passage"
    return "door"


def _arc(start: Point, end: Point, extent: float) -> list[Point]:
    """Return points along a wall; `extent` is the angle in radians of a curved wall's arc."""
    extent = max(-MAX_TURN, min(extent, MAX_TURN))
    chord = math.dist(start, end)
    if abs(extent) < 1e-3 or chord == 0:
        return [start, end]
    radius = chord / (2 * math.sin(abs(extent) / 2))
    middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    away = radius * math.cos(extent / 2) * math.copysign(1.0, extent)
    nx, nz = -(end[1] - start[1]) / chord, (end[0] - start[0]) / chord
    cx, cz = middle[0] + away * nx, middle[1] + away * nz
    first = math.atan2(start[1] - cz, start[0] - cx)
    steps = max(2, math.ceil(abs(extent) / SETTINGS.arc_step))
    inner = (first + extent * k / steps for k in range(1, steps))
    points = [(cx + radius * math.cos(a), cz + radius * math.sin(a)) for a in inner]
    return [start, *points, end]


PLAN_FORMAT = PlanFormat(
    "Sweet Home 3D",
    lambda plan: plan.binary.startswith("a ZIP") and is_sweet_home(plan.path),
    lambda plan: house_of_sweet_home(plan.path, plan.house_id),
    suffixes=(".sh3d",),
)
