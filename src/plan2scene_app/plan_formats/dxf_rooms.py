"""Find rooms in a DXF whose layers have unknown names: large outlines, or lines that close."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from itertools import pairwise

from shapely import unary_union
from shapely.geometry import LineString, Point, Polygon

from plan2scene.errors import InputError
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import Source
from plan2scene_app.plan_formats.axes import (
    MAX_AXES,
    SETTINGS,
    WallAxis,
    distinct,
    is_floor,
    rooms_of_axes,
)
from plan2scene_app.plan_formats.drawing import Drawing, closed_rooms
from plan2scene_app.plan_formats.dxf_content import DXF
from plan2scene_app.plan_formats.lines import axes_of_lines, bridges

#: Patterns of names of layers whose outlines are no floor, in English and German.
VOIDS = ("*void*", "*atrium*", "*shaft*", "*schacht*", "*luftraum*")


def rooms_of_layers(
    outlines: Mapping[str, Sequence[LineString]],
) -> list[tuple[str, Polygon]]:
    """Return (layer, floor) for the closed outlines, in metres, on layers that seem to hold rooms.

    An outline that contains or overlaps smaller rooms is the floor that these leave, such as a
    corridor. The list is empty for fewer than `DXF.least_rooms` rooms.
    """
    floors: list[tuple[str, Polygon]] = []
    small: list[tuple[str, Polygon]] = []
    holes: list[Polygon] = []
    for layer, lines in outlines.items():
        areas = [Polygon(line).buffer(0) for line in lines if line.is_closed]
        areas = [area for area in areas if isinstance(area, Polygon) and is_floor(area)]
        if any(fnmatchcase(layer.casefold(), pattern) for pattern in VOIDS):
            holes += areas
            continue
        large = [area for area in areas if area.area >= DXF.room[0]]
        if large and len(large) >= DXF.outlines * len(areas):
            floors += [(layer, area) for area in large]
            small += [(layer, a) for a in areas if DXF.tiny <= a.area < DXF.room[0]]
    furnished = unary_union([area for _, area in floors])
    floors += [(layer, area) for layer, area in small if not area.intersects(furnished)]
    floors.sort(key=lambda pair: pair[1].area)
    rooms: list[tuple[str, Polygon]] = []
    for layer, area in floors:
        inside = [room for _, room in rooms if area.contains(room.representative_point())]
        taken = [room for _, room in rooms if area.intersects(room)]
        if area.intersection(unary_union(taken)).area > (1 - DXF.outlines) * area.area or inside:
            # The rest keeps the thickness of a wall (0.15 m) away from the other rooms.
            free = area.difference(unary_union([*taken, *holes]).buffer(0.15, join_style="mitre"))
            free = free.buffer(-DXF.corridor / 2).buffer(DXF.corridor / 2, join_style="mitre")
            parts = [p for p in getattr(free, "geoms", [free]) if p.area >= DXF.left_over]
            rooms += [(layer, part.simplify(0.05)) for part in parts if len(taken) < len(floors)]
        elif area.area <= DXF.room[1]:
            rooms.append((layer, area))
    return rooms if len(rooms) >= DXF.least_rooms else []


@dataclass(frozen=True)
class LineReading:
    """A layer's lines read as walls: their drawing, the floors they close, the count of doors."""

    layer: str
    drawing: Drawing
    faces: tuple[Polygon, ...]
    doors: int


def rooms_of_lines(
    source: Source,
    strokes: Mapping[str, Sequence[LineString]],
    doors: Sequence[Segment],
    words: Iterable[Point],
) -> LineReading | None:
    """Return the best reading of one layer's lines as walls: most doors, then most floor.

    The rooms that a layer of walls closes have doors or names, and few are too small for a room. If
    a file holds several drawings, one is read.
    """
    best: LineReading | None = None
    spots = list(words)
    for layer, lines in strokes.items():
        pieces = sum(len(line.coords) - 1 for line in lines)
        if not DXF.least_lines <= pieces <= MAX_AXES:
            continue
        single = [WallAxis(*pair) for line in lines for pair in pairwise(line.coords)]
        for way in (axes_of_lines, lambda _, single=single: distinct(single)):
            try:
                axes = way(lines)
                drawing = Drawing(axes=axes + bridges(axes, doors), openings=list(doors))
                if _is_pattern(rooms_of_axes(source, drawing.axes)):
                    continue
                faces = closed_rooms(replace(source, warnings=[]), drawing)
            except InputError:  # too many lines side by side for walls
                continue
            for view in _views(faces):
                around = unary_union(view).buffer(SETTINGS.opening_reach)
                swung = sum(around.contains(Point(door.start)) for door in doors)
                named = sum(any(face.contains(spot) for spot in spots) for face in view)
                tiny = sum(face.area < DXF.tiny for face in view)
                if swung + named < 2 or tiny > DXF.tiny_share * len(view):
                    continue
                reading = LineReading(layer, drawing, tuple(view), swung)
                if best is None or _rank(reading) > _rank(best):
                    best = reading
    return best


def _is_pattern(faces: Sequence[Polygon]) -> bool:
    """Return whether the faces between lines are those of a grid, tiles or steps."""
    tiny = sum(face.area < DXF.tiny for face in faces)
    return tiny > DXF.pattern and tiny > DXF.tiny_share * len(faces)


def _rank(reading: LineReading) -> tuple[int, float]:
    return reading.doors, sum(face.area for face in reading.faces)


def _views(faces: Sequence[Polygon]) -> list[list[Polygon]]:
    """Return floors grouped into plans; floors that are a wall's thickness apart are in one."""
    if not faces:
        return []
    joined = unary_union([face.buffer(SETTINGS.faces[1] / 2) for face in faces])
    parts = getattr(joined, "geoms", [joined])
    return [[f for f in faces if part.contains(f.representative_point())] for part in parts]
