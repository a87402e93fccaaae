"""Read a DXF's entities out of its blocks, and find its code page and its true unit."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.plans.parse import Source

#: Largest number of entities of a drawing, also in its blocks, and deepest nesting of blocks.
MAX_ENTITIES = 100_000
MAX_NESTING = 12
#: The usual units of drawings, in metres.
UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inches": 0.0254, "feet": 0.3048}


@dataclass(frozen=True)
class DxfSettings:
    """The tuned numbers of reading DXF, by usual sizes of buildings and their drawings."""

    possible_door: tuple[float, float] = (0.4, 1.6)  #: m of the median leaf if the unit is right
    usual_door: tuple[float, float] = (0.6, 1.1)  #: m of the median leaf for another unit
    swing: tuple[float, float] = (10.0, 100.0)  #: degrees that a door's arc turns
    hinge: float = 0.1  #: share of an arc's radius within which a leaf fits it
    one_leaf: float = 0.7  #: share of a door's longer side, in plan, that its only leaf takes
    least_leaves: int = 3  #: fewest leaves, or fewest printed areas, that tell a unit
    printed: float = 0.1  #: share by which a unit may differ from that of the printed areas
    room: tuple[float, float] = (4.0, 1500.0)  #: m2 of outlines that are rooms
    outlines: float = 0.7  #: least share of such large outlines on a layer of rooms
    left_over: float = 10.0  #: m2 of the smallest floor that other outlines leave (a corridor)
    corridor: float = 0.9  #: m of its narrowest place
    least_rooms: int = 3  #: fewest outlines of a drawing that are its rooms
    least_lines: int = 8  #: fewest straight lines of a layer of walls
    tiny: float = 1.5  #: m2: smaller faces between lines are furniture
    tiny_share: float = 0.34  #: with a larger share of tiny faces, lines are no walls
    pattern: int = 50  #: with more tiny faces (and that share), lines are a grid, tiles or steps
    more: float = 1.5  #: another reading is taken if it has more than this times the floor


DXF = DxfSettings()


def each_entity(
    source: Source, entities: Iterable[Any], kind_of: Callable[[Any], str | None]
) -> Iterator[tuple[Any, str]]:
    """Yield (entity, kind), with blocks taken apart; a part without a kind has that of its block.

    `kind_of(entity)` gives the kind of an entity, None for one that is not shown: it is left out.
    Blocks of doors and windows stay whole; attributes of blocks are texts.
    """
    count = 0
    queue = [(entity, "", 0) for entity in reversed(list(entities))]
    if len(queue) > MAX_ENTITIES:
        raise source.fault(f"at most {MAX_ENTITIES} entities", "more")
    while queue:
        entity, block_kind, depth = queue.pop()
        count += 1
        own_kind = kind_of(entity)
        if own_kind is None:
            continue
        kind = own_kind or block_kind
        if entity.dxftype() not in ("INSERT", "MLINE") or kind in ("doors", "windows"):
            yield entity, kind
            continue
        if depth >= MAX_NESTING:
            raise source.fault(f"blocks at most {MAX_NESTING} deep", "deeper")
        try:
            parts = [*entity.virtual_entities(), *getattr(entity, "attribs", ())]
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            continue
        for part in parts:
            if str(part.dxf.get("layer", "0")) == "0":  # layer 0: that of the insert
                part.dxf.layer = str(entity.dxf.get("layer", "0"))
        queue += [(part, kind, depth + 1) for part in reversed(parts)]
        if count + len(queue) > MAX_ENTITIES:
            raise source.fault(f"at most {MAX_ENTITIES} entities", "more")


_NEW = (b"AC1021", b"AC1024", b"AC1027", b"AC1032")
_TWO_BYTES = re.compile(rb"[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc]")


def alphabet(path: Path) -> str | None:
    """Return the true code page of a text DXF that names none, or names just ANSI_1252.

    None: as the file says. Japanese programs write code page 932 without naming it.
    """
    with path.open("rb") as file:
        content = file.read()
    page = re.search(rb"\$DWGCODEPAGE\s+3\s+(\S+)", content[:100_000])
    version = re.search(rb"\$ACADVER\s+1\s+(\S+)", content[:100_000])
    named = page is not None and page[1].lower() not in (b"ansi_1252", b"undefined", b"ascii")
    if content.isascii() or named or (version is not None and version[1] in _NEW):
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
    """A door's open leaf: its hinge and its tip when closed (x, y), drawing units; its line."""

    hinge: tuple[float, float]
    closed: tuple[float, float]
    line: Any

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The ends of the opening."""
        return self.hinge, self.closed

    @property
    def length(self) -> float:
        """Width of the door."""
        return float(np.hypot(*np.subtract(self.closed, self.hinge)))


def leaves_of(entities: Iterable[Any]) -> list[Leaf]:
    """Return the doors' leaves: lines with an arc around one end, of their length as radius."""
    from scipy.spatial import cKDTree  # slow to import (0.3 s); no other format needs it

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
        centre = arc.ocs().to_wcs(arc.dxf.center)
        radius, hinge = float(arc.dxf.radius), (centre.x, centre.y)
        if not DXF.swing[0] <= turn <= DXF.swing[1] or not np.isfinite([radius, *hinge]).all():
            continue
        swing = np.array([(p.x, p.y) for p in (arc.start_point, arc.end_point)])
        found = []
        for k in sorted(tree.query_ball_point(hinge, DXF.hinge * radius)):
            tip = np.array(ends[k ^ 1])
            if abs(float(np.linalg.norm(tip - hinge)) - radius) <= DXF.hinge * radius:
                found.append((np.linalg.norm(swing - tip, axis=1), kinds["LINE"][k // 2]))
        if found:  # a wall of the same length may begin at the hinge, too
            distances, line = min(found, key=lambda pair: float(pair[0].min()))
            leaves.append(Leaf(hinge, tuple(swing[distances.argmax()].tolist()), line))
    return leaves


def unit_of(source: Source, header: float | None, leaves: list[Leaf]) -> float | None:
    """Return the unit in metres: the header's, unless the widths of doors show that it is wrong."""
    low, high = DXF.possible_door
    lengths = [leaf.length for leaf in leaves]
    middle = float(np.median(lengths)) if len(lengths) >= DXF.least_leaves else None
    if middle is None or (header is not None and low <= middle * header <= high):
        return header
    fitting_units = [
        (abs(np.log(middle * metres / 0.85)), name)
        for name, metres in UNITS.items()
        if DXF.usual_door[0] <= middle * metres <= DXF.usual_door[1]
    ]
    if not fitting_units:
        return header
    name = min(fitting_units)[1]
    given = "none" if header is None else f"doors {middle * header:.3g} m wide"
    source.warn("a unit that fits the doors' widths", f"{given}; the unit {name} is used")
    return UNITS[name]
