"""Rooms that bear only a number: a list beside the plan tells their names and areas."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

from plan2scene.plans.room_names import room_types
from plan2scene_app.plan_formats.measures import read_areas
from plan2scene_app.tracing.lettering import TextLine

#: The number of a room, alone or with its name: ``3``, ``3.``, ``(3)``, ``0.03``, ``A3``.
_NUMBERED = re.compile(r"[(\[]?([A-Za-z]?\d{1,2}(?:\.\d{1,2})?)[.):\]]*(?:\s+(\D.*))?")
_LEAST_ROWS = 3  #: of a list, and numbers of it that rooms bear
_COLUMN, _GAP = 2.0, 10.0  #: width of a column of numbers, widest gap to the name; text heights


@dataclass(frozen=True)
class _Row:
    key: str
    lines: tuple[TextLine, ...]  #: the number, the name and perhaps areas
    told: str  #: name and areas


def with_legend(lines: Sequence[TextLine]) -> list[TextLine]:
    """Return the lines without the list, each room's number replaced by what its row tells.

    If the lists of several storeys use a number twice, the nearest row counts. Without a list, the
    lines stay as they are.
    """
    rows = [row for line in lines if (row := _row_of(line, lines)) is not None]
    rows = [row for row in rows if len(_column(row, rows)) >= _LEAST_ROWS]
    listed = {id(line) for row in rows for line in row.lines}
    keys = {row.key for row in rows}
    others = [line for line in lines if id(line) not in listed]
    if len(keys & {_number(line) for line in others}) < _LEAST_ROWS:
        return list(lines)
    told = []
    for line in others:
        key = _number(line)
        if key in keys:
            row = min((r for r in rows if r.key == key), key=lambda r: _apart(r.lines[0], line))
            line = replace(line, text=row.told)
        told.append(line)
    return told


def _parts(line: TextLine) -> tuple[str, str]:
    """Return the number and the name that a line consists of, empty for none."""
    found = _NUMBERED.fullmatch(line.text.strip())
    return (found[1], found[2] or "") if found else ("", "")


def _number(line: TextLine) -> str:
    """Return the number that a line is, empty for none."""
    key, name = _parts(line)
    return "" if name else key


def _row_of(line: TextLine, lines: Sequence[TextLine]) -> _Row | None:
    """Return the row that begins with a line, if the line is a number with a name behind it."""
    key, name = _parts(line)
    if not key:
        return None
    cells = [x for x in lines if _left(x) > line.middle[0]]
    cells = [x for x in cells if abs(x.middle[1] - line.middle[1]) < line.size[1] / 2]
    cells.sort(key=_left)
    used = [line]
    if not name and cells and _left(cells[0]) - _right(line) < _GAP * line.size[1]:
        used.append(cells.pop(0))
        name = used[-1].text
    if not room_types(name):
        return None
    areas = list(takewhile(lambda cell: read_areas(cell.text), cells))
    return _Row(key, (*used, *areas), " ".join([name, *(cell.text for cell in areas)]))


def _column(row: _Row, rows: Sequence[_Row]) -> set[str]:
    """Return the numbers that stand above and below that of a row, and its own."""
    first = row.lines[0]
    return {r.key for r in rows if abs(_left(r.lines[0]) - _left(first)) < _COLUMN * first.size[1]}


def _left(line: TextLine) -> float:
    return line.middle[0] - line.size[0] / 2


def _right(line: TextLine) -> float:
    return line.middle[0] + line.size[0] / 2


def _apart(one: TextLine, other: TextLine) -> float:
    (x, y), (u, v) = one.middle, other.middle
    return (x - u) ** 2 + (y - v) ** 2
