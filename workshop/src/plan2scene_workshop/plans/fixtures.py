"""Drawings of plans with fixtures of baths and kitchens, and the label of every pixel.

A fixture is drawn in a box of width x depth metres, back at y = 0, in one of many ways.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry import Polygon

from plan2scene_app.tracing.settings import FIXTURE_LABELS
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.plans.drawing import DrawnPlan, draw_plan
from plan2scene_workshop.plans.furnish import place
from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.style import PlanStyle, draw_style
from plan2scene_workshop.plans.symbols import PIECES, SYMBOLS, Lines, Symbol, box, oval, segment

#: Pixels per metre of the drawings, before they are reduced to the network's scale.
_PPM = (60.0, 90.0)
_MARKS = ("W", "D", "DW", "F", "REF", "OVEN", "FRIDGE", "WM", "CUB", "C", "K")


class Part(NamedTuple):
    """A symbol in the box of a fixture: its lower corner and size in metres, and its label."""

    draw: Callable[[np.random.Generator, float, float], Lines]
    x: float
    y: float
    width: float
    depth: float
    label: str = ""


def _rounded(x0: float, y0: float, x1: float, y1: float, radius: float) -> np.ndarray:
    """Return a closed rectangle with round corners."""
    r = min(radius, (x1 - x0) / 2.01, (y1 - y0) / 2.01)
    corners = (
        (x1 - r, y1 - r, 0),
        (x0 + r, y1 - r, 90),
        (x0 + r, y0 + r, 180),
        (x1 - r, y0 + r, 270),
    )
    ring = np.concatenate([oval(x, y, r, r, a, a + 90)[::4] for x, y, a in corners])
    return np.concatenate([ring, ring[:1]])


def _bowl(w: float, d: float, back: float, width: float, straight: float) -> np.ndarray:
    """Return a bowl that begins at `back`: straight sides over a share of its depth, then round."""
    left, right = (w - width) / 2, (w + width) / 2
    turn = back + straight * (d - back)
    ring = np.concatenate(
        [[(right, back)], oval(w / 2, turn, width / 2, d - turn, 0, 180), [(left, back)]]
    )
    return np.concatenate([ring, ring[:1]])


def _toilet(rng: np.random.Generator, w: float, d: float) -> Lines:
    tank = float(rng.uniform(0.12, 0.24)) if rng.random() < 0.85 else 0.0
    width = w * float(rng.uniform(0.7, 1.0))
    lines = []
    if tank:
        side = w * float(rng.uniform(0.0, 0.1))
        lines.append(
            _rounded(side, 0, w - side, tank, 0.04)
            if rng.random() < 0.4
            else box(side, 0, w - side, tank)
        )
    back = tank + float(rng.choice([0.0, 0.04, -0.05]))
    if rng.random() < 0.5:
        middle = (back + d) / 2
        lines.append(oval(w / 2, middle, width / 2, (d - back) / 2))
        inner = oval(w / 2, middle, 0.36 * width, 0.36 * (d - back))
    else:
        lines.append(_bowl(w, d, back, width, float(rng.uniform(0.2, 0.6))))
        inner = _bowl(w, d - 0.06, back + 0.05, 0.7 * width, 0.4)
    if rng.random() < 0.5:
        lines.append(inner)
    if rng.random() < 0.2:
        lines.append(box(w / 2 - 0.06, tank - 0.02, w / 2 + 0.06, tank + 0.05))
    return lines


def _taps(rng: np.random.Generator, x: float, y: float) -> Lines:
    """Return the taps of a basin whose back is at (x, y)."""
    if rng.random() < 0.5:
        return [
            oval(x + k, y, 0.02, 0.02)
            for k in ((-0.07, 0.0, 0.07) if rng.random() < 0.5 else (0.0,))
        ]
    return [
        segment(x, y - 0.02, x + float(rng.choice([0, 0.05])), y + 0.1),
        segment(x - 0.05, y, x + 0.05, y),
    ]


def _basin(rng: np.random.Generator, w: float, d: float) -> Lines:
    way = rng.random()
    rim = float(rng.uniform(0.03, 0.09))
    lines: Lines = []
    if way < 0.45:
        lines.append(box(0, 0, w, d) if rng.random() < 0.7 else _rounded(0, 0, w, d, 0.1))
        lines.append(oval(w / 2, d * 0.54, w / 2 - rim, d * 0.46 - rim))
    elif way < 0.65:
        lines += [
            _bowl(w, d, 0, w, float(rng.uniform(0.1, 0.5))),
            _bowl(w, d - rim, rim, w - 2 * rim, 0.3),
        ]
    elif way < 0.85:
        lines.append(box(0, 0, w, d))
        lines.append(_rounded(rim, 1.5 * rim, w - rim, d - rim, float(rng.uniform(0.01, 0.12))))
    else:
        lines += [oval(w / 2, d / 2, w / 2, d / 2), oval(w / 2, d / 2, w / 2 - rim, d / 2 - rim)]
    if rng.random() < 0.6:
        lines.append(oval(w / 2, d * 0.52, 0.025, 0.025))
    if rng.random() < 0.6:
        lines += _taps(rng, w / 2, 0.05)
    return lines


def _sink(rng: np.random.Generator, w: float, d: float) -> Lines:
    """Return a sink of a kitchen: one or two bowls, perhaps a draining board."""
    lines = [box(0, 0, w, d)] if rng.random() < 0.8 else []
    split = 1 if w < 0.6 else int(rng.integers(1, 3))
    board = w > 0.75 and rng.random() < 0.6
    end = w * 0.55 if board else w
    for k in range(split):
        a, b = k * end / split + 0.04, (k + 1) * end / split - 0.04
        radius = float(rng.choice([0.0, 0.05, 0.15]))
        lines.append(
            _rounded(a, 0.09, b, d - 0.05, radius) if radius else box(a, 0.09, b, d - 0.05)
        )
        lines.append(oval((a + b) / 2, d / 2, 0.025, 0.025))
    if board:
        lines += [segment(end, y, w - 0.04, y) for y in np.arange(0.12, d - 0.05, 0.07)]
    return lines + _taps(rng, end / 2, 0.05)


def _bath(rng: np.random.Generator, w: float, d: float) -> Lines:
    rim = float(rng.uniform(0.04, 0.1))
    lines = [box(0, 0, w, d)] if rng.random() < 0.9 else []
    way = rng.random()
    if way < 0.35:
        round_end = oval(w - rim - d / 2 + rim, d / 2, d / 2 - rim, d / 2 - rim, -90, 90)
        lines.append(np.concatenate([round_end, [(rim, d - rim), (rim, rim)], round_end[:1]]))
    elif way < 0.6:
        lines.append(_rounded(rim, rim, w - rim, d - rim, float(rng.uniform(0.05, 0.35))))
    elif way < 0.75:
        lines.append(oval(w / 2, d / 2, w / 2 - rim, d / 2 - rim))
    elif way < 0.88:
        lines.append(box(rim, rim, w - rim, d - rim))
    else:  # narrower in the middle
        x = np.linspace(rim, w - rim, 30)
        half = (d / 2 - rim) * (0.82 + 0.18 * np.cos(4 * np.pi * (x - rim) / (w - 2 * rim)))
        half[[0, -1]] *= 0.6
        ring = np.concatenate([np.c_[x, d / 2 + half], np.c_[x, d / 2 - half][::-1]])
        lines.append(np.concatenate([ring, ring[:1]]))
    drain = w - 3 * rim if rng.random() < 0.3 else 3 * rim
    if rng.random() < 0.8:
        lines.append(oval(drain, d / 2, 0.03, 0.03))
    if rng.random() < 0.3:
        lines += [oval(rim / 2, d / 2 + k, 0.02, 0.02) for k in (-0.08, 0.08)]
    return lines


def _shower(rng: np.random.Generator, w: float, d: float) -> Lines:
    way = rng.random()
    if way < 0.2:  # a quarter of a circle
        return [
            np.concatenate([[(0, 0)], oval(0, 0, w, d, 0, 90), [(0, 0)]]),
            oval(0.12, 0.12, 0.03, 0.03),
        ]
    lines = [box(0, 0, w, d)]
    if rng.random() < 0.3:
        lines.append(box(0.05, 0.05, w - 0.05, d - 0.05))
    if way < 0.55:
        lines += [segment(0, 0, w, d), segment(0, d, w, 0)]
    elif way < 0.65:
        lines += [segment(0, y, w, y) for y in np.arange(0.1, d, 0.1)]
    if rng.random() < 0.5:
        lines.append(oval(w / 2, d / 2, 0.04, 0.04))
    elif rng.random() < 0.6:  # the head at the back, with its rays
        lines.append(oval(w / 2, 0.1, 0.06, 0.06))
        lines += [segment(w / 2 + 0.06 * k, 0.16, w / 2 + 0.12 * k, 0.3) for k in (-1, 0, 1)]
    return lines


def _stove(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)] if rng.random() < 0.85 else []
    front = d - (0.08 if rng.random() < 0.3 else 0.0)
    radius = float(rng.uniform(0.055, 0.1))
    for x in (0.28 * w, 0.72 * w):
        for y in (0.28 * front, 0.72 * front):
            r = radius * float(rng.choice([1.0, 0.75])) if rng.random() < 0.4 else radius
            lines.append(oval(x, y, r, r))
            if rng.random() < 0.3:
                lines.append(oval(x, y, r / 2, r / 2))
            if rng.random() < 0.15:
                lines += [segment(x - r, y, x + r, y), segment(x, y - r, x, y + r)]
    if w > 0.7 and rng.random() < 0.6:
        lines.append(oval(w / 2, front / 2, radius, radius))
    if front < d:
        lines += [segment(0, front, w, front)]
        lines += [oval(x, d - 0.04, 0.015, 0.015) for x in np.linspace(0.15, 0.85, 4) * w]
    return lines


def _plain(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d)]


def _worktop(rng: np.random.Generator, w: float, d: float) -> list[Part]:
    """Return a worktop with a stove, a sink, or both."""
    parts = [Part(_plain, 0, 0, w, d, "counter")]
    way = rng.random()
    x = float(rng.uniform(0.0, 0.3))
    for name in (("stove", "sink"), ("sink", "stove"), ("stove",), ("sink",), ())[int(way * 5)]:
        wide = float(rng.uniform(0.5, 0.75) if name == "stove" else rng.uniform(0.45, 1.0))
        deep = min(d - 0.04, float(rng.uniform(0.42, 0.58)))
        if x + wide > w:
            break
        parts.append(
            Part(_stove if name == "stove" else _sink, x, (d - deep) / 2, wide, deep, name)
        )
        x += wide + float(rng.uniform(0.0, 1.2))
    if rng.random() < 0.3:
        parts += [
            Part(lambda _, a, b: [segment(0, 0, 0, b)], k, 0, 0, d) for k in np.arange(0.6, w, 0.6)
        ]
    return parts


def _vanity(rng: np.random.Generator, w: float, d: float) -> list[Part]:
    """Return a worktop of a bathroom with one basin, or two."""
    count = 2 if w > 1.2 and rng.random() < 0.6 else 1
    wide, deep = min(0.55, w / count - 0.06), min(0.42, d - 0.06)
    basins = [
        Part(_basin, (k + 0.5) * w / count - wide / 2, (d - deep) / 2, wide, deep, "sink")
        for k in range(count)
    ]
    return [Part(_plain, 0, 0, w, d, "counter"), *basins]


def _alone(symbol: Callable[[np.random.Generator, float, float], Lines], label: str) -> _Parts:
    return lambda _, w, d: [Part(symbol, 0, 0, w, d, label)]


_Parts = Callable[[np.random.Generator, float, float], list[Part]]
#: Range of width and depth in metres, the parts, and whether it stands away from walls.
_FIXTURES: dict[str, tuple[tuple[float, float], tuple[float, float], _Parts, bool]] = {
    "toilet": ((0.34, 0.5), (0.5, 0.8), _alone(_toilet, "toilet"), False),
    "basin": ((0.36, 0.75), (0.3, 0.55), _alone(_basin, "sink"), False),
    "vanity": ((0.6, 2.0), (0.4, 0.62), _vanity, False),
    "bath": ((1.4, 2.0), (0.65, 0.95), _alone(_bath, "bath"), False),
    "free bath": ((1.5, 1.9), (0.7, 0.9), _alone(_bath, "bath"), True),
    "shower": ((0.7, 1.6), (0.7, 1.1), _alone(_shower, "shower"), False),
    "worktop": ((1.4, 4.2), (0.52, 0.7), _worktop, False),
    "island": ((1.4, 3.0), (0.6, 1.1), _worktop, True),
    "cooker": ((0.5, 0.9), (0.5, 0.65), _alone(_stove, "stove"), False),
    "kitchen sink": ((0.5, 1.1), (0.45, 0.55), _alone(_sink, "sink"), False),
}
#: Names of what stands in baths and kitchens, in the order in which it is placed.
_ROOMS = {
    "Bathroom": ["toilet", "bath", "vanity", "basin", "shower", "free bath", "washer"],
    "Kitchen": [
        "worktop",
        "worktop",
        "worktop",
        "cooker",
        "kitchen sink",
        "fridge",
        "island",
        "table",
    ],
}


def fixture_plan(
    number: int, seed_house: int, rng: np.random.Generator, *, held_out: bool
) -> DrawnPlan:
    """Return a drawing of a synthetic home whose labels are those of `FIXTURE_LABELS`."""
    style = replace(draw_style(rng, held_out=held_out), furniture="none", hand=False)
    house = generate_house(f"{'test' if held_out else 'train'}_{number}", seed_house)
    drawn = draw_plan(house, style, float(rng.uniform(*_PPM)), rng, finer=1)
    sheet = Sheet(drawn.labels.shape, drawn.ppm, drawn.origin, style.paper)
    sheet.image = drawn.image.copy()
    labels = np.zeros_like(drawn.labels)
    plan = drawn.plan
    clear = shapely.union_all(
        [Polygon(gap.corners(gap.depth + 1.1)) for gap in plan.gaps if gap.kind != "window"]
    )
    filled, black = rng.random() < 0.4, rng.random() < 0.2
    for room, types in zip(plan.rooms, plan.types, strict=True):
        inner = plan.inner_depth / 2
        free = room.buffer(-inner - 0.005).difference(clear)
        for name in [n for kind in types for n in _ROOMS.get(kind, PIECES[kind])]:
            if rng.random() < 0.3:
                continue
            sizes = _FIXTURES.get(name)
            symbol = (
                SYMBOLS[name]
                if sizes is None
                else Symbol(name, sizes[0], sizes[1], _plain, sizes[3])
            )
            gap = inner + (0.01 if rng.random() < 0.7 else 0.05)
            placed = place(symbol, room, free, gap, rng)
            if placed is None:
                continue
            piece, (w, d), frame = placed
            free = free.difference(piece.buffer(0.01 if name == "worktop" else 0.05))
            parts = sizes[2](rng, w, d) if sizes else [Part(symbol.draw, 0, 0, w, d)]
            for part in parts:
                _draw_part(sheet, labels, part, frame, style, rng, filled=filled, black=black)
            if name in ("worktop", "washer", "fridge") and rng.random() < 0.4:
                spot = np.array([rng.uniform(0.1, 0.9) * w, d / 2]) @ frame[:2] + frame[2]
                sheet.write(str(rng.choice(_MARKS)), spot, 0.12, style.pen, style.font)
    return replace(drawn, image=sheet.image, labels=labels)


def _draw_part(
    sheet: Sheet,
    labels: np.ndarray,
    part: Part,
    frame: np.ndarray,
    style: PlanStyle,
    rng: np.random.Generator,
    *,
    filled: bool,
    black: bool,
) -> None:
    """Draw a part of a fixture and mark its label; `black` fills the plates of stoves."""

    def placed(points: np.ndarray) -> np.ndarray:
        return np.asarray((points + (part.x, part.y)) @ frame[:2] + frame[2])

    outline = placed(box(0, 0, part.width, part.depth))
    if part.label:
        sheet.mark(labels, Polygon(outline), FIXTURE_LABELS.index(part.label))
    lines = part.draw(rng, part.width, part.depth)
    if filled and part.width and part.depth:
        sheet.fill(placed(lines[0]), style.paper if rng.random() < 0.7 else style.tint)
    for line in lines:
        if black and part.label == "stove" and len(line) == 25:  # a round plate
            sheet.fill(placed(line), style.ink)
        sheet.line(placed(line), style.pen, style.thin)
