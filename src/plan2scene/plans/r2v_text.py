"""Parser of the two raster-to-vector text dialects, in pixels (x right, y down)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from plan2scene.house import ROOM_TYPES, Point
from plan2scene.plans.parse import R2V_TYPES, Source

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
    {
        "bathtub",
        "cooking_counter",
        "entrance",
        "special",
        "stairs",
        "toilet",
        "washing_basin",
    }
)
#: Labels that name a room. `stairs` and `entrance` are icons, which name a room without label.
ROOM_LABELS = frozenset({*R2V_TYPES, *(name.lower() for name in ROOM_TYPES)}) - ICON_LABELS
#: Largest number of walls, and of other lines, of one file.
MAX_LINES = 2000
#: Largest pixel coordinate.
MAX_PIXEL = 100_000.0


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
    """All of a raster-to-vector file."""

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
