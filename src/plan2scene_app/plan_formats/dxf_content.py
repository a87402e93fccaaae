"""What a DXF holds beside its layers: entities in blocks, its alphabet, its true unit."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.plans.parse import Source

#: Most entities of a drawing, of its blocks too, and the nesting of blocks.
MAX_ENTITIES = 100_000
MAX_NESTING = 12
#: Metres of the units that drawings are made in.
UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inches": 0.0254, "feet": 0.3048}


@dataclass(frozen=True)
class DxfSettings:
    """The tuned numbers of reading DXF, as buildings and their drawings usually are."""

    possible_door: tuple[float, float] = (0.4, 1.6)  #: m of the leaves of a drawing, median
    usual_door: tuple[float, float] = (0.6, 1.1)  #: m of those that tell a unit
    swing: tuple[float, float] = (10.0, 100.0)  #: degrees that a door's arc turns
    hinge: float = 0.1  #: shares of its radius within which a leaf fits an arc
    least_leaves: int = 3  #: that tell it
    printed: float = 0.1  #: share by which printed areas may differ from a unit
    room: tuple[float, float] = (4.0, 1500.0)  #: m2 of outlines that are rooms
    outlines: float = 0.7  #: share of a layer's outlines that are so large where it has rooms
    left_over: float = 10.0  #: m2 of the smallest floor that other outlines leave
    corridor: float = 0.9  #: m of its narrowest place
    least_rooms: int = 3  #: outlines of a drawing that are its rooms
    least_lines: int = 8  #: straight lines of a layer that may be of walls
    tiny: float = 1.5  #: m2: smaller faces between lines are furniture
    tiny_share: float = 0.34  #: share of them above which lines are no walls
    pattern: int = 50  #: of them that are no drawing of rooms
    more: float = 1.5  #: times the floor that another reading must have


DXF = DxfSettings()


def each_entity(
    source: Source, entities: Iterable[Any], kind_of: Callable[[Any], str]
) -> Iterator[tuple[Any, str]]:
    """Yield entities and the kind of the blocks that they are in; blocks come apart.

    `kind_of(entity)` tells the kind of an entity; blocks of doors and windows stay whole.
    """
    count = 0
    queue = [(entity, "", 0) for entity in reversed(list(entities))]
    if len(queue) > MAX_ENTITIES:
        raise source.fault(f"at most {MAX_ENTITIES} entities", "more")
    while queue:
        entity, above, depth = queue.pop()
        count += 1
        kind = kind_of(entity) or above
        if entity.dxftype() != "INSERT" or kind in ("doors", "windows"):
            yield entity, kind
            continue
        if depth >= MAX_NESTING:
            raise source.fault(f"blocks at most {MAX_NESTING} deep", "deeper")
        try:
            parts = list(entity.virtual_entities())
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            continue
        for part in parts:
            if str(part.dxf.get("layer", "0")) == "0":  # drawn on the layer of the insert
                part.dxf.layer = str(entity.dxf.get("layer", "0"))
        queue += [(part, kind, depth + 1) for part in reversed(parts)]
        if count + len(queue) > MAX_ENTITIES:
            raise source.fault(f"at most {MAX_ENTITIES} entities", "more")


_NEW = (b"AC1021", b"AC1024", b"AC1027", b"AC1032")
_TWO_BYTES = re.compile(rb"[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc]")


def alphabet(path: Path) -> str | None:
    """Return the code page of a text DXF that names none (or ANSI_1252 for want of another).

    None: as the file says. Japanese programs write code page 932 without a word.
    """
    with path.open("rb") as file:
        content = file.read()
    named = re.search(rb"\$DWGCODEPAGE\s+3\s+(\S+)", content[:100_000])
    version = re.search(rb"\$ACADVER\s+1\s+(\S+)", content[:100_000])
    told = named is not None and named[1].lower() not in (b"ansi_1252", b"undefined", b"ascii")
    if content.isascii() or told or (version is not None and version[1] in _NEW):
        return None
    if content.startswith(b"AutoCAD Binary DXF"):
        return None
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        pass
    else:
        return "utf-8"
    high = sum(byte >= 0x80 for byte in content)
    pairs = sum(sum(b >= 0x80 for b in pair) for pair in _TWO_BYTES.findall(content))
    try:
        content.decode("cp932")
    except UnicodeDecodeError:
        return None
    return "cp932" if pairs >= 0.8 * high and pairs >= 8 else None


@dataclass(frozen=True)
class Leaf:
    """A door's leaf, open: hinge and where it closes (x, y) in units of the drawing, its line."""

    hinge: tuple[float, float]
    closed: tuple[float, float]
    line: Any

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The ends of the opening."""
        return self.hinge, self.closed

    @property
    def length(self) -> float:
        """How wide the door is."""
        return float(np.hypot(*np.subtract(self.closed, self.hinge)))


def leaves_of(entities: Iterable[Any]) -> list[Leaf]:
    """Return the lines that an arc swings: it has their end as centre, their length as radius."""
    from scipy.spatial import cKDTree  # a third of a second that no other format needs

    kinds: dict[str, list[Any]] = {"ARC": [], "LINE": []}
    for entity in entities:
        if entity.dxftype() in kinds:
            kinds[entity.dxftype()].append(entity)
    ends = [(p.x, p.y) for line in kinds["LINE"] for p in (line.dxf.start, line.dxf.end)]
    if not ends or not np.isfinite(ends).all():
        return []
    tree = cKDTree(ends)
    leaves = []
    for arc in kinds["ARC"]:
        turn = (arc.dxf.end_angle - arc.dxf.start_angle) % 360
        radius, hinge = float(arc.dxf.radius), (arc.dxf.center.x, arc.dxf.center.y)
        if not DXF.swing[0] <= turn <= DXF.swing[1] or not np.isfinite([radius, *hinge]).all():
            continue
        for k in sorted(tree.query_ball_point(hinge, DXF.hinge * radius)):
            line, tip = kinds["LINE"][k // 2], np.array(ends[k ^ 1])
            if abs(float(np.linalg.norm(tip - hinge)) - radius) <= DXF.hinge * radius:
                swing = [(p.x, p.y) for p in (arc.start_point, arc.end_point)]
                closed = max(swing, key=lambda p: float(np.hypot(*np.subtract(p, tip))))
                leaves.append(Leaf(hinge, closed, line))
                break
    return leaves


def unit_of(source: Source, header: float | None, leaves: list[Leaf]) -> float | None:
    """Return metres of the unit: the header's, unless the doors' leaves say that it is wrong."""
    low, high = DXF.possible_door
    lengths = [leaf.length for leaf in leaves]
    middle = float(np.median(lengths)) if len(lengths) >= DXF.least_leaves else None
    if middle is None or (header is not None and low <= middle * header <= high):
        return header
    usual = [
        (abs(np.log(middle * metres / 0.85)), name)
        for name, metres in UNITS.items()
        if DXF.usual_door[0] <= middle * metres <= DXF.usual_door[1]
    ]
    if not usual:
        return header
    name = min(usual)[1]
    said = "none" if header is None else f"{middle * header:.3g} m by it"
    source.warn("a unit of the header that suits the doors", f"{said}; {name} by their widths")
    return UNITS[name]
