"""Reader of DXF drawings by ezdxf (the extra `formats`): rooms and walls by layer.

Closed outlines on a layer of rooms are rooms. On a layer of walls, a closed rectangle is a wall's
body, two parallel lines are a wall's faces, and any other line is an axis. What lies on a layer
of doors or windows, or in a block named so, is an opening. The drawing's y goes up: (x, y) becomes
(x, -y).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from shapely.affinity import affine_transform
from shapely.geometry import LineString, Point, Polygon, box
from shapely.strtree import STRtree

from plan2scene.errors import InputError
from plan2scene.house import USUAL, House
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import MAX_ROOMS, Source
from plan2scene.plans.plan_file import PlanFile, PlanFormat, Unscaled
from plan2scene_app.plan_formats.axes import (
    HEIGHTS,
    MAX_AXES,
    SETTINGS,
    NearestAxis,
    WallAxis,
    axis_of_area,
)
from plan2scene_app.plan_formats.drawing import (
    Drawing,
    DrawnRoom,
    bordering_share,
    closed_rooms,
    house_of_drawing,
)
from plan2scene_app.plan_formats.dxf_content import (
    DXF,
    MAX_ENTITIES,
    MAX_NESTING,
    UNITS,
    Leaf,
    alphabet,
    each_entity,
    leaves_of,
    unit_of,
)
from plan2scene_app.plan_formats.dxf_rooms import rooms_of_layers, rooms_of_lines
from plan2scene_app.plan_formats.lines import (
    axes_of_lines,
    bridges,
    groups_of_lines,
    rooms_of_outlines,
)
from plan2scene_app.plan_formats.measures import read_areas

#: Patterns of layer and block names, as in CAD programs: separated by commas, each for the whole
#: name in any case; ``*`` any letters, ``?`` one, ``[aä]`` one of these, ``[!a-z]`` none of these.
LAYERS = {
    "rooms": "*room*,*raum*,*r[aä]ume*,*space*,*area,*area[!l]*,*zone*,*fl[aä]che*,*pi[eè]ce*,"
    "*locale*,*habitac*,*ruimte*",
    "doors": "*door*,*t[uü]r*,*tuer*,*porte,*porte[!u]*,*puerta*,*porta*,*deur*",
    "windows": "*window*,*fenster*,*fen[eê]tre*,*ventana*,*finestra*,*raam*,*glaz*",
    "walls": "*wall*,*wand*,*w[aä]nde*,*mauer*,mur*,*[!a-z]mur*,*muro*,*parete*,*muur*",
}
#: Patterns of names of layers and blocks of tags, texts and hatches, which are none of these kinds.
NOTES = "*-iden*,*-dims*,*-patt*,*-symb*,*-text*,*-note*,*tag,*label*,*stempel*,*beschrift*"
#: Largest number of letters of a pattern.
MAX_PATTERN = 300


def layers_of(pairs: Sequence[str]) -> dict[str, str]:
    """Return {kind: pattern} of ``KIND=PATTERN`` texts, for `layers` of :func:`house_of_dxf`."""
    patterns: dict[str, str] = {}
    for pair in pairs:
        kind, _, pattern = pair.partition("=")
        if kind not in LAYERS or not pattern:
            expected = f"a DXF layer as KIND=PATTERN, KIND one of {', '.join(LAYERS)}"
            raise InputError(expected, repr(pair))
        patterns[kind] = pattern
    return patterns


def layer_of(entity: Any) -> str:
    """Return the name of an entity's layer; empty if it has none."""
    return str(entity.dxf.get("layer", "")) if entity.dxf.is_supported("layer") else ""


def names_of(entity: Any) -> list[str]:
    """Return the names that give an entity's kind: its block's, if it is one, and its layer's."""
    names = [layer_of(entity)]
    if entity.dxftype() == "INSERT":
        names.insert(0, str(entity.dxf.get("name", "")))
    return names


class LayerKinds:
    """Finds the kind (of `LAYERS`) that a layer's name means; `layers` replaces our patterns."""

    def __init__(self, source: Source, layers: Mapping[str, str]) -> None:
        self.patterns = {} if layers else {"": NOTES.split(",")}
        self._known: dict[str, str] = {}
        for kind in ("doors", "windows", "rooms", "walls"):
            text = layers.get(kind) or LAYERS[kind]
            if len(text) > MAX_PATTERN:
                expected = f"at most {MAX_PATTERN} letters of {kind} in dxf_layers"
                raise source.fault(expected, len(text))
            self.patterns[kind] = [part.strip().casefold() for part in text.split(",")]

    def of_name(self, name: str) -> str:
        """Return the kind that a layer's or block's name means; empty for none."""
        if name not in self._known:  # cached, as many entities have few names
            folded = name.casefold()
            kinds = (
                kind
                for kind, patterns in self.patterns.items()
                if any(fnmatchcase(folded, pattern) for pattern in patterns)
            )
            self._known[name] = next(kinds, "")
        return self._known[name]

    def of(self, entity: Any) -> str:
        """Return an entity's kind by its block's name, else by its layer's; empty for none."""
        return next((kind for name in names_of(entity) if (kind := self.of_name(name))), "")


class ShownKinds:
    """Finds the kinds of a document's entities; None for those that its layers hide."""

    def __init__(self, document: Any, kinds: LayerKinds) -> None:
        layers = {str(layer.dxf.name).casefold(): layer for layer in document.layers}
        self.kinds = kinds
        self.frozen = {name for name, layer in layers.items() if layer.is_frozen()}
        self.hidden = {name for name, layer in layers.items() if layer.is_off()} | self.frozen
        xrefs = {str(b.block.dxf.xref_path) for b in document.blocks if b.block and b.block.is_xref}
        self.left_out = {f"xref {name}" for name in xrefs}
        if not len(document.modelspace()):
            self.left_out |= {f"layout {name}" for name in document.layout_names_in_taborder()[1:]}

    def of(self, entity: Any) -> str | None:
        """Return an entity's kind; blocks on layers that are off may have parts on others."""
        layer, kind = layer_of(entity), self.kinds.of(entity)
        whole = entity.dxftype() != "INSERT" or kind in ("doors", "windows")
        if layer.casefold() not in (self.hidden if whole else self.frozen):
            return kind
        self.left_out.add(f"layer {layer} (off or frozen)")
        return None


#: Largest number of points of one curve.
MAX_POINTS = 2000
CURVES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")


class Curves:
    """Reads the curves of a parsed document in metres."""

    def __init__(self, source: Source, document: Any, metres: float) -> None:
        self.source, self.document, self.metres = source, document, metres
        self.boxes: dict[str, Polygon | None] = {}

    def line(self, entity: Any) -> LineString | None:
        """Return a curve in metres, (x, -y); a closed one repeats its first point at the end."""
        from ezdxf import path

        try:
            curve = path.make_path(entity)
            points = [(p.x, -p.y) for p in curve.flattening(SETTINGS.flat / self.metres, 4)]
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            return None
        if len(points) > MAX_POINTS:
            raise self.source.fault(f"at most {MAX_POINTS} points of a curve", len(points))
        array = np.array(points, dtype=np.float64).reshape(-1, 2) * self.metres
        if len(array) < 2 or not np.isfinite(array).all():
            return None
        closed = bool(getattr(entity, "is_closed", False) or getattr(entity, "closed", False))
        if (closed or np.hypot(*(array[0] - array[-1])) < 1e-3) and len(array) > 2:
            array = np.vstack(
                [array[:-1] if np.allclose(array[0], array[-1], atol=1e-3) else array, array[:1]]
            )
        return LineString(array)

    def borders(self, hatch: Any) -> list[LineString]:
        """Return the outlines of a hatch in metres, (x, -y), as closed lines."""
        from ezdxf import path

        try:
            paths = list(path.from_hatch(hatch))
            rings = [[(p.x, -p.y) for p in one.flattening(0.05 / self.metres)] for one in paths]
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            return []
        arrays = [np.array(ring, dtype=np.float64) * self.metres for ring in rings if len(ring) > 3]
        if sum(len(array) for array in arrays) > MAX_POINTS:
            raise self.source.fault(f"at most {MAX_POINTS} points of a hatch", "more")
        return [LineString([*array, array[0]]) for array in arrays if np.isfinite(array).all()]

    def block_area(self, insert: Any, depth: int = 0) -> Polygon | None:
        """Return the box around an inserted block's curves, turned and scaled by the insert."""
        name = str(insert.dxf.get("name", ""))
        if name not in self.boxes:
            self.boxes[name] = None
            self.boxes[name] = self._block_box(name, depth)
        area = self.boxes[name]
        if area is None:
            return None
        m = insert.matrix44()
        corners = [m.transform((x, -y, 0)) for x, y in list(area.exterior.coords)[:4]]
        points = np.array([(p.x, -p.y) for p in corners]) * (self.metres if depth == 0 else 1.0)
        polygon = Polygon(points) if np.isfinite(points).all() else None
        return polygon if polygon is not None and polygon.area > 0 else None

    def _block_box(self, name: str, depth: int) -> Polygon | None:
        """Return the box around a block's curves in its own units, (x, -y)."""
        if depth > MAX_NESTING:
            raise self.source.fault(f"blocks at most {MAX_NESTING} deep", "deeper")
        bounds = []
        for count, entity in enumerate(self.document.blocks.get(name) or ()):
            if count >= MAX_ENTITIES:
                raise self.source.fault(f"at most {MAX_ENTITIES} entities of block {name}", "more")
            if entity.dxftype() == "INSERT":
                area = self.block_area(entity, depth + 1)
                bounds += [] if area is None else [area.bounds]
            elif entity.dxftype() in CURVES:
                line = self.line(entity)
                if line is not None:
                    bounds.append(tuple(v / self.metres for v in line.bounds))
        if not bounds:
            return None
        array = np.array(bounds)
        low, high = array[:, :2].min(axis=0), array[:, 2:].max(axis=0)
        return box(*low, *np.maximum(high, low + 1e-9))


#: Largest number of bytes of a drawing.
MAX_BYTES = 100_000_000
_HEAD = re.compile(rb"\s*(?:999\s*\r?\n[^\n]*\n\s*)*0\s*\r?\n\s*SECTION\b")


def is_dxf(head: bytes) -> bool:
    """Return whether a file begins as a DXF drawing does, text or binary."""
    return bool(_HEAD.match(head)) or head.startswith(b"AutoCAD Binary DXF")


def house_of_dxf(
    path: Path,
    house_id: str,
    metres_per_unit: float | None = None,
    layers: Mapping[str, str] | None = None,
) -> House:
    """Return the house of a DXF drawing.

    `metres_per_unit`, if given, replaces the unit of the header; `layers` holds patterns that
    replace those of :data:`LAYERS`. Raises InputError if the unit is unknown.
    """
    source = Source(str(path), house_id)
    document = load_dxf(source, path)
    kinds = LayerKinds(source, layers or {})
    shown = ShownKinds(document, kinds)
    entities = list(each_entity(source, document.modelspace(), shown.of))
    left_out = f"{', '.join(sorted(shown.left_out)[:5])} left out"
    if shown.left_out:
        source.warn("everything shown, in this file's model space", left_out)
    blocks = [entity for entity, kind in entities if kind == "doors"]
    parts = each_entity(source, [e for e in blocks if e.dxftype() == "INSERT"], lambda _: "")
    leaves = leaves_of(entity for entity, _ in (*entities, *parts))
    metres = metres_per_unit or _unit(source, document, leaves)
    drawing = _Drawing(source, document, metres, entities, leaves)
    try:
        house = house_of_drawing(source, drawing.read())
    except InputError as error:
        if not shown.left_out:
            raise
        raise source.fault(error.expected, f"{error.found}; {left_out}") from None
    printed = None if metres_per_unit else drawing.printed_unit(house)
    if printed is None:
        return house
    again = Source(str(path), house_id)
    again.warn("a unit that fits the written areas", f"another; a unit of {printed:g} m is used")
    rescaled = _Drawing(again, document, printed, entities, leaves).read()
    return replace(house_of_drawing(again, rescaled), heights=USUAL)


def load_dxf(source: Source, path: Path) -> Any:
    """Return the parsed document."""
    import ezdxf

    if path.stat().st_size > MAX_BYTES:
        raise source.fault(f"at most {MAX_BYTES} bytes of DXF", path.stat().st_size)
    damage = (
        *(ezdxf.DXFError, OSError, ValueError, LookupError, TypeError, AttributeError),
        StopIteration,  # the file ends in the middle of a point
    )
    try:
        return ezdxf.readfile(path, encoding=alphabet(path))
    except damage as error:
        raise source.fault("a DXF drawing that can be read", repr(error)) from None


def _unit(source: Source, document: Any, leaves: list[Leaf]) -> float:
    """Return the unit in metres: the header's, or the one that the widths of doors show."""
    from ezdxf import units

    code = document.header.get("$INSUNITS", 0)
    try:
        metres = float(units.conversion_factor(units.InsertUnits(code), units.InsertUnits.Meters))
    except (ValueError, KeyError, TypeError):
        metres = 0.0
    header_unit = metres if code != 0 and 0 < metres <= 1000 else None
    unit = unit_of(source, header_unit, leaves)
    if unit is None:
        expected = "a unit in the header ($INSUNITS), or metres_per_pixel for the drawing's unit"
        raise source.fault(expected, f"$INSUNITS {code}")
    return unit


def entities_of(source: Source, document: Any) -> Iterator[Any]:
    """Yield the entities of the model space."""
    for count, entity in enumerate(document.modelspace()):
        if count >= MAX_ENTITIES:
            raise source.fault(f"at most {MAX_ENTITIES} entities", "more")
        yield entity


_LETTERS = re.compile(r"[^\W\d_]{2}")
#: A mark: its kind, area, and insertion point (if it is a block) of a door or window.
_Mark = tuple[str, Polygon, Point | None]


class _Drawing:
    """Reads the entities of the model space, with their kinds, as a drawing in metres."""

    def __init__(
        self,
        source: Source,
        document: Any,
        metres: float,
        entities: Sequence[tuple[Any, str]],
        leaves: Sequence[Leaf],
    ) -> None:
        self.source, self.metres = source, metres
        self.entities, self.leaves = entities, leaves
        self.curves = Curves(source, document, metres)
        self.written: list[tuple[str, Point]] = []
        self.doors: list[Segment] = []  # those of the leaves

    def read(self) -> Drawing:
        """Return the drawing: rooms with their names, walls and openings."""
        lines: dict[str, list[LineString]] = {key: [] for key in LAYERS}
        lines_by_layer: dict[str, list[LineString]] = {}
        hatches: dict[str, list[LineString]] = {key: [] for key in LAYERS}
        marks: list[_Mark] = []
        pieces = 0
        swung = {id(leaf.line) for leaf in self.leaves}
        for entity, kind in self.entities:
            if entity.dxftype() == "INSERT":
                area = self.curves.block_area(entity)
                marks += [] if area is None else [(kind, area, self._place(entity))]
            elif entity.dxftype() in ("TEXT", "MTEXT", "ATTRIB"):
                self.written += self._text(entity)
            elif entity.dxftype() == "HATCH" and kind:
                hatches[kind] += self.curves.borders(entity)
            elif entity.dxftype() in CURVES and (kind == "doors" or id(entity) not in swung):
                line = self.curves.line(entity)
                if line is None or line.length == 0:
                    continue
                if not kind:
                    straight = line.is_closed or entity.dxftype() not in ("ARC", "CIRCLE")
                    lines_by_layer.setdefault(str(entity.dxf.layer), []).extend([line] * straight)
                    continue
                lines[kind].append(line)
                pieces += (len(line.coords) - 1) * (kind == "walls")
                if pieces > 2 * MAX_AXES:
                    raise self.source.fault(f"at most {2 * MAX_AXES} lines of walls", "more")
        for kind in ("walls", "rooms"):
            lines[kind] = lines[kind] or hatches[kind]
        room_lines = [*lines["rooms"], *lines["walls"]]
        shift = _shift(
            room_lines or [line for layer_lines in lines_by_layer.values() for line in layer_lines]
        )
        self.written = [(text, _move(point, shift)) for text, point in self.written]
        marks = [(kind, _move(area, shift), at and _move(at, shift)) for kind, area, at in marks]
        moved, left = (
            {
                key: [_move(line, shift) for line in layer_lines]
                for key, layer_lines in group.items()
            }
            for group in (lines, lines_by_layer)
        )
        for leaf in self.leaves:
            ends = [(x * self.metres + shift[0], shift[1] - y * self.metres) for x, y in leaf.ends]
            name = f"leaf_{len(self.doors)}"
            self.doors.append(Segment(name, "door", ends[0], ends[1], *HEIGHTS["door"]))
        self.doors = _with_double(self.doors)
        names = [(text, place) for text, place in self.written if _LETTERS.search(text)]
        return self._unlayered(self._drawing(moved, marks, names), left, marks, names)

    def printed_unit(self, house: House) -> float | None:
        """Return the unit by the areas written in rooms; None if they fit already or are few."""
        rooms = [Polygon(room.rings[0]).buffer(0) for room in house.rooms]
        shares = [
            float(np.sqrt(read_areas(text)[0][0] / room.area))
            for text, place in self.written
            if read_areas(text)
            for room in rooms
            if room.contains(place)
        ]
        if len(shares) < DXF.least_leaves:
            return None
        printed_metres = float(np.median(shares)) * self.metres
        nearest = min(UNITS.values(), key=lambda unit: abs(np.log(unit / printed_metres)))
        off = abs(nearest / printed_metres - 1)
        return nearest if off <= DXF.printed and nearest != self.metres else None

    def _unlayered(
        self,
        named: Drawing,
        others: Mapping[str, list[LineString]],
        marks: list[_Mark],
        names: list[tuple[str, Point]],
    ) -> Drawing:
        """Return the drawing by its layers' names, or by the other layers if these show more."""
        if named.rooms and not named.axes:
            return named
        trial = replace(named, axes=list(named.axes), openings=list(named.openings))
        faces = closed_rooms(replace(self.source, warnings=[]), trial) if named.axes else []
        if not named.rooms:
            for face in faces:
                trial.rooms.append(self._room([ring.coords[:-1] for ring in _rings(face)], names))
            named = trial
        if faces and bordering_share(named.axes, faces) >= SETTINGS.bordering:
            return named
        floor = max(named.floor(), sum(face.area for face in faces))
        by_layer = rooms_of_layers(others)
        if sum(area.area for _, area in by_layer) > DXF.more * floor:
            drawing = Drawing()
            alone = Counter(layer for layer, _ in by_layer)
            for layer, area in by_layer:
                room = self._room([ring.coords[:-1] for ring in _rings(area)], names)
                drawing.rooms.append(replace(room, name=room.name or layer))
            self._add_openings(drawing, marks)
            layers = ", ".join(sorted(alone)[:5])
            found = f"none; {len(by_layer)} outlines on {len(alone)} layers ({layers} ...)"
            self.source.warn("layers of rooms", found)
            return drawing
        reading = rooms_of_lines(self.source, others, self.doors, [place for _, place in names])
        if reading is None or sum(face.area for face in reading.faces) <= DXF.more * floor:
            if not faces and not named.rooms and others:
                layers = ", ".join(sorted(others, key=lambda k: -len(others[k]))[:8])
                what = f"{len(named.axes)} walls that close none; layers {layers}"
                raise self.source.fault("rooms, or walls that close some (dxf_layers)", what)
            return named
        self.source.warn("layers of walls", f"none; lines of layer {reading.layer!r} read as walls")
        drawing = Drawing(axes=reading.drawing.axes, openings=reading.drawing.openings)
        for face in reading.faces:
            drawing.rooms.append(self._room([ring.coords[:-1] for ring in _rings(face)], names))
        self._add_openings(drawing, marks)
        return drawing

    def _drawing(
        self,
        lines: Mapping[str, list[LineString]],
        marks: list[_Mark],
        texts: list[tuple[str, Point]],
    ) -> Drawing:
        drawing = Drawing()
        for line in lines["rooms"]:
            if not line.is_closed or len(line.coords) < 4:
                continue
            drawing.rooms.append(self._room([list(line.coords)[:-1]], texts))
            if len(drawing.rooms) > MAX_ROOMS:
                raise self.source.fault(f"at most {MAX_ROOMS} rooms", "more")
        walls, loose = lines["walls"], []
        for line in walls:
            axis = _body_axis(line)
            drawing.axes += [axis] if axis else []
            loose += [] if axis else [line]
        drawing.axes += axes_of_lines(loose)
        for kind in ("doors", "windows"):
            marks += [(kind, area, None) for area in groups_of_lines(lines[kind])]
        self._add_openings(drawing, marks)
        gaps = bridges(drawing.axes, drawing.openings)
        if not drawing.rooms:
            for area in rooms_of_outlines(walls, gaps) if walls else ():
                rings = (area.exterior, *area.interiors)
                drawing.rooms.append(self._room([list(ring.coords)[:-1] for ring in rings], texts))
        drawing.axes += gaps
        return drawing

    def _room(self, rings: list[Any], texts: list[tuple[str, Point]]) -> DrawnRoom:
        """Return a room, named by the texts inside it."""
        area = Polygon(rings[0], rings[1:])
        area = area if area.is_valid else area.convex_hull
        name = " ".join(text for text, place in texts if area.contains(place))[:100]
        outlines = tuple(self.source.outline(ring, name[:40]) for ring in rings)
        return DrawnRoom(name, outlines)

    def _add_openings(self, drawing: Drawing, marks: Sequence[_Mark]) -> None:
        """Add an opening to a drawing for each mark of a door or window."""
        outlines = [
            WallAxis(a, b)
            for room in drawing.rooms
            for a, b in zip(room.rings[0], room.rings[0][1:] + room.rings[0][:1], strict=True)
        ]
        nearest = NearestAxis(drawing.axes or outlines)
        lines = [LineString([door.start, door.end]) for door in self.doors]
        tree, taken = STRtree(lines), set[int]()
        for kind, area, anchor in marks:
            name = f"opening_{len(drawing.openings)}"
            within = tree.query(area.buffer(SETTINGS.touch), predicate="contains").tolist()
            within = [k for k in within if lines[k].length >= SETTINGS.widths[0]]
            if kind == "doors" and anchor is None and within:  # loose lines, of several doors
                drawing.openings += [self.doors[k] for k in within if k not in taken]
                taken.update(within)
                continue
            leaf = max(within, key=lambda k: (lines[k].length, -k), default=-1)
            side = np.hypot(*np.diff(area.exterior.coords, axis=0).T).max()
            segment: Segment | None
            if kind == "doors" and leaf >= 0 and lines[leaf].length >= DXF.one_leaf * side:
                segment = replace(self.doors[leaf], id=name)
            else:
                segment = nearest.edge_segment(area, name, kind[:-1], anchor)
            if segment is None:
                continue
            width = float(np.hypot(*np.subtract(segment.end, segment.start)))
            if SETTINGS.widths[0] <= width <= SETTINGS.widths[1]:
                drawing.openings.append(segment)
            else:
                expected = (
                    f"doors and windows {SETTINGS.widths[0]:g} to {SETTINGS.widths[1]:g} m wide"
                )
                self.source.warn(expected, f"{width:.2f} m, left out")

    def _text(self, entity: Any) -> list[tuple[str, Point]]:
        """Return [(words, place)] of a text entity; empty if it has no place."""
        is_lines = entity.dxftype() == "MTEXT"
        lines = entity.plain_text(split=True) if is_lines else [entity.dxf.get("text", "")]
        place = self._place(entity)
        texts = [" ".join(str(line).split())[:100] for line in lines]
        return [(text, place) for text in texts] if place is not None else []

    def _place(self, entity: Any) -> Point | None:
        """Return the insertion point of a text or block."""
        place = entity.dxf.get("insert")
        if place is None:
            return None
        if entity.dxftype() != "MTEXT":  # the others are mirrored by their extrusion
            place = entity.ocs().to_wcs(place)
        return Point(place.x * self.metres, -place.y * self.metres)


def _rings(area: Polygon) -> list[Any]:
    return [area.exterior, *area.interiors]


def _with_double(doors: Sequence[Segment]) -> list[Segment]:
    """Return doors with one instead of two whose leaves meet: from hinge to hinge."""
    tree = STRtree([Point(door.end) for door in doors])
    left = dict(enumerate(doors))
    for k, door in enumerate(doors):
        for j in tree.query(Point(door.end), "dwithin", SETTINGS.touch).tolist():
            ways = np.subtract(door.start, door.end), np.subtract(doors[j].start, doors[j].end)
            if j > k and j in left and k in left and ways[0] @ ways[1] < 0:
                left[k] = replace(door, end=left.pop(j).start)
                break
    return list(left.values())


def _shift(lines: Sequence[LineString]) -> tuple[float, float]:
    """Return the shift to the origin of a drawing that lies more than 500 m from it, else 0, 0."""
    bounds = np.array([line.bounds for line in lines] or [(0.0, 0.0, 0.0, 0.0)])
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    is_far = max(np.abs(low).max(), np.abs(high).max()) > 500.0
    return (-float(low[0]), -float(low[1])) if is_far else (0.0, 0.0)


def _move(shape: Any, shift: tuple[float, float]) -> Any:
    return affine_transform(shape, [1, 0, 0, 1, *shift]) if any(shift) else shape


def _body_axis(line: LineString) -> WallAxis | None:
    """Return the axis of a closed outline that is a rectangle, up to 1 m thick, else None."""
    if not line.is_closed or len(line.coords) < 4:
        return None
    area = Polygon(line)
    frame = area.minimum_rotated_rectangle
    axis = axis_of_area(area)
    if axis is None or area.area < SETTINGS.rectangle * frame.area or axis.thickness > 1.0:
        return None
    return axis


#: Largest number of layers and blocks that are listed; those with the most entities come first.
MAX_NAMES = 200
#: Metres of a unit that are assumed for reading curves while the unit is unknown.
TRIAL = 1e-3


@dataclass(frozen=True)
class DxfName:
    """A layer, or an inserted block."""

    name: str
    count: int  #: number of its entities
    block: bool
    kind: str  #: the kind as which it is read now (a key of `LAYERS`); empty: left out


def contents_of_dxf(
    path: Path, house_id: str, layers: Mapping[str, str] | None = None
) -> tuple[list[DxfName], tuple[float, float] | None]:
    """Return the layers and blocks of the model space, and width and depth of its rooms and walls.

    The size is in units of the drawing, or None if no layer is one of rooms or walls.
    """
    source = Source(str(path), house_id)
    document = load_dxf(source, path)
    kinds, curves = LayerKinds(source, layers or {}), Curves(source, document, TRIAL)
    counts: Counter[tuple[str, bool]] = Counter()
    bounds = []
    for entity in entities_of(source, document):
        *block, layer = names_of(entity)
        counts.update([(layer, False), *((name, True) for name in block)])
        if entity.dxftype() in CURVES and kinds.of(entity) in ("rooms", "walls"):
            line = curves.line(entity)
            bounds += [] if line is None else [line.bounds]
    names = [
        DxfName(name, count, block, kinds.of_name(name))
        for (name, block), count in counts.most_common(MAX_NAMES)
    ]
    if not bounds:
        return names, None
    array = np.array(bounds)
    width, depth = (array[:, 2:].max(axis=0) - array[:, :2].min(axis=0)) / TRIAL
    return names, (float(width), float(depth))


def _look(plan: PlanFile) -> Unscaled:
    names, size = contents_of_dxf(plan.path, plan.house_id, plan.dxf_layers)
    return Unscaled("unit", size, tuple(names))


PLAN_FORMAT = PlanFormat(
    "DXF",
    lambda plan: is_dxf(plan.head),
    lambda plan: house_of_dxf(plan.path, plan.house_id, plan.metres_per_pixel, plan.dxf_layers),
    suffixes=(".dxf",),
    needs="plan2scene[formats]",
    look=_look,
    lacks_heights=lambda _: True,
)
