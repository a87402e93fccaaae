"""Reader of DXF drawings by ezdxf (the extra `formats`): rooms and walls by layer.

Closed outlines on a layer of rooms are rooms. On a layer of walls, closed rectangles are walls'
bodies, two parallel lines a wall's faces, any other line an axis. What lies on layers of doors
and windows, or is a block named so, is an opening. The drawing's y goes up: (x, y) becomes (x, -y).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from shapely.affinity import affine_transform
from shapely.geometry import LineString, Point, Polygon

from plan2scene.house import House
from plan2scene.plans.parse import MAX_ROOMS, Source
from plan2scene_app.plan_formats.areas import NearestAxis, axis_of_area
from plan2scene_app.plan_formats.axes import MAX_AXES, WallAxis
from plan2scene_app.plan_formats.drawing import Drawing, DrawnRoom, house_of_drawing
from plan2scene_app.plan_formats.dxf_curves import CURVES, MAX_ENTITIES, Curves
from plan2scene_app.plan_formats.dxf_layers import LAYERS, LayerKinds
from plan2scene_app.plan_formats.lines import (
    axes_of_lines,
    bridges,
    groups_of_lines,
    rooms_of_outlines,
)

#: Most bytes of a drawing.
MAX_BYTES = 100_000_000
#: Openings are this wide (metres).
WIDTHS = (0.4, 6.0)
#: A closed outline that fills less of the rectangle around it is no wall's body.
RECTANGLE = 0.85
_HEAD = re.compile(rb"\s*(?:999\s*\r?\n[^\n]*\n\s*)*0\s*\r?\n\s*SECTION\b")


def is_dxf(head: bytes) -> bool:
    """Return whether a file begins as a DXF drawing does, in text or binary."""
    return bool(_HEAD.match(head)) or head.startswith(b"AutoCAD Binary DXF")


def house_of_dxf(
    path: Path,
    house_id: str,
    metres_per_unit: float | None = None,
    layers: Mapping[str, str] | None = None,
) -> House:
    """Return the house of a DXF drawing.

    `metres_per_unit` goes before the unit of the header; `layers` holds patterns in
    place of `dxf_layers.LAYERS`. Raises InputError where neither tells the unit.
    """
    source = Source(str(path), house_id)
    document = load_dxf(source, path)
    drawing = _Drawing(source, document, metres_per_unit or _unit(source, document), layers or {})
    return house_of_drawing(source, drawing.read())


def load_dxf(source: Source, path: Path) -> Any:
    """Return the parsed document."""
    import ezdxf

    if path.stat().st_size > MAX_BYTES:
        raise source.fault(f"at most {MAX_BYTES} bytes of DXF", path.stat().st_size)
    damage = (ezdxf.DXFError, OSError, ValueError, LookupError, TypeError, AttributeError)
    try:
        return ezdxf.readfile(path)
    except damage as error:
        raise source.fault("a DXF drawing that can be read", repr(error)) from None


def _unit(source: Source, document: Any) -> float:
    """Return metres of the unit in the header."""
    from ezdxf import units

    code = document.header.get("$INSUNITS", 0)
    try:
        metres = float(units.conversion_factor(units.InsertUnits(code), units.InsertUnits.Meters))
    except (ValueError, KeyError, TypeError):
        metres = 0.0
    if code == 0 or not 0 < metres <= 1000:
        expected = "a unit in the header ($INSUNITS), or metres_per_pixel for the drawing's unit"
        raise source.fault(expected, f"$INSUNITS {code}")
    return metres


def entities_of(source: Source, document: Any) -> Iterator[Any]:
    """Yield the entities of the model space."""
    for count, entity in enumerate(document.modelspace()):
        if count >= MAX_ENTITIES:
            raise source.fault(f"at most {MAX_ENTITIES} entities", "more")
        yield entity


#: A door's or window's layer, its area, its insertion point where it is a block.
_Mark = tuple[str, Polygon, Point | None]


class _Drawing:
    """Entities of the model space, in metres."""

    def __init__(
        self, source: Source, document: Any, metres: float, layers: Mapping[str, str]
    ) -> None:
        self.source, self.document, self.metres = source, document, metres
        self.kinds = LayerKinds(source, layers)
        self.curves = Curves(source, document, metres)

    def read(self) -> Drawing:
        """Return the drawing: rooms, walls, openings, names."""
        lines: dict[str, list[LineString]] = {key: [] for key in LAYERS}
        marks: list[_Mark] = []
        texts: list[tuple[str, Point]] = []
        pieces = 0
        for entity in entities_of(self.source, self.document):
            kind = self.kinds.of(entity)
            if entity.dxftype() == "INSERT":
                area = self.curves.block_area(entity) if kind in ("doors", "windows") else None
                marks += [] if area is None else [(kind, area, self._place(entity))]
            elif entity.dxftype() in ("TEXT", "MTEXT"):
                texts += self._text(entity)
            elif kind and entity.dxftype() in CURVES:
                line = self.curves.line(entity)
                if line is None or line.length == 0:
                    continue
                lines[kind].append(line)
                pieces += (len(line.coords) - 1) * (kind == "walls")
                if pieces > 2 * MAX_AXES:
                    raise self.source.fault(f"at most {2 * MAX_AXES} lines of walls", "more")
        shift = _shift([*lines["rooms"], *lines["walls"]])
        moved = {key: [_move(line, shift) for line in found] for key, found in lines.items()}
        texts = [(text, _move(point, shift)) for text, point in texts]
        marks = [(kind, _move(area, shift), at and _move(at, shift)) for kind, area, at in marks]
        return self._drawing(moved, marks, texts)

    def _drawing(
        self,
        lines: Mapping[str, list[LineString]],
        marks: list[_Mark],
        texts: list[tuple[str, Point]],
    ) -> Drawing:
        found = Drawing()
        for line in lines["rooms"]:
            if not line.is_closed or len(line.coords) < 4:
                continue
            found.rooms.append(self._room([list(line.coords)[:-1]], texts))
            if len(found.rooms) > MAX_ROOMS:
                raise self.source.fault(f"at most {MAX_ROOMS} rooms", "more")
        walls, loose = lines["walls"], []
        for line in walls:
            axis = _body_axis(line)
            found.axes += [axis] if axis else []
            loose += [] if axis else [line]
        found.axes += axes_of_lines(loose)
        for kind in ("doors", "windows"):
            marks += [(kind, area, None) for area in groups_of_lines(lines[kind])]
        self._add_openings(found, marks)
        gaps = bridges(found.axes, found.openings)
        if not found.rooms:
            for area in rooms_of_outlines(walls, gaps) if walls else ():
                rings = (area.exterior, *area.interiors)
                found.rooms.append(self._room([list(ring.coords)[:-1] for ring in rings], texts))
        found.axes += gaps
        return found

    def _room(self, rings: list[Any], texts: list[tuple[str, Point]]) -> DrawnRoom:
        """Return a room named by the texts inside it."""
        area = Polygon(rings[0], rings[1:]).buffer(0)
        name = " ".join(text for text, place in texts if area.contains(place))[:100]
        outlines = tuple(self.source.outline(ring, name[:40]) for ring in rings)
        return DrawnRoom(name, outlines)

    def _add_openings(self, found: Drawing, marks: Sequence[_Mark]) -> None:
        """Add the openings that the marks of doors and windows mean."""
        outlines = [
            WallAxis(a, b)
            for room in found.rooms
            for a, b in zip(room.rings[0], room.rings[0][1:] + room.rings[0][:1], strict=True)
        ]
        nearest = NearestAxis(found.axes or outlines)
        for kind, area, anchor in marks:
            name = f"opening_{len(found.openings)}"
            segment = nearest.edge_segment(area, name, kind[:-1], anchor)
            if segment is None:
                continue
            width = float(np.hypot(*np.subtract(segment.end, segment.start)))
            if WIDTHS[0] <= width <= WIDTHS[1]:
                found.openings.append(segment)
            else:
                expected = f"doors and windows {WIDTHS[0]:g} to {WIDTHS[1]:g} m wide"
                self.source.warn(expected, f"{width:.2f} m, left out")

    def _text(self, entity: Any) -> list[tuple[str, Point]]:
        """Return a text's words and place; nothing for measures."""
        text = entity.plain_text() if entity.dxftype() == "MTEXT" else entity.dxf.get("text", "")
        text = " ".join(str(text).split())[:100]
        place = self._place(entity)
        return [(text, place)] if place is not None and re.search(r"[^\W\d_]{2}", text) else []

    def _place(self, entity: Any) -> Point | None:
        """Return the insertion point of a text or block."""
        place = entity.dxf.get("insert")
        return None if place is None else Point(place.x * self.metres, -place.y * self.metres)


def _shift(lines: Sequence[LineString]) -> tuple[float, float]:
    """Return how far to move a drawing that lies far from its origin."""
    bounds = np.array([line.bounds for line in lines] or [(0.0, 0.0, 0.0, 0.0)])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    far = max(np.abs(low).max(), np.abs(high).max()) > 500.0
    return (-float(low[0]), -float(low[1])) if far else (0.0, 0.0)


def _move(shape: Any, shift: tuple[float, float]) -> Any:
    return affine_transform(shape, [1, 0, 0, 1, *shift]) if any(shift) else shape


def _body_axis(line: LineString) -> WallAxis | None:
    """Return the axis of a closed outline that is a long rectangle; None for any other line."""
    if not line.is_closed or len(line.coords) < 4:
        return None
    area = Polygon(line)
    frame = area.minimum_rotated_rectangle
    axis = axis_of_area(area)
    if axis is None or area.area < RECTANGLE * frame.area or axis.thickness > 1.0:
        return None
    return axis
