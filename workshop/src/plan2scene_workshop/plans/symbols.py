"""Symbols of furniture and fixtures: polylines in a box of width x depth metres, back at y = 0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Lines = list[np.ndarray]


@dataclass(frozen=True)
class Symbol:
    """The symbol of a piece of furniture or a fixture on a plan."""

    name: str
    width: tuple[float, float]  #: range in metres, along the wall
    depth: tuple[float, float]  #: range in metres, away from the wall
    draw: Callable[[np.random.Generator, float, float], Lines]
    free: bool = False  #: whether it stands away from walls


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """Return a closed rectangle."""
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])


def oval(
    x: float, y: float, rx: float, ry: float, start: float = 0, end: float = 360
) -> np.ndarray:
    """Return (an arc of) an ellipse."""
    t = np.deg2rad(np.linspace(start, end, 25))
    return np.c_[x + rx * np.cos(t), y + ry * np.sin(t)]


def segment(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """Return a line."""
    return np.array([(x0, y0), (x1, y1)])


def _bed(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)]
    pillows = 2 if w > 1.2 else 1
    for k in range(pillows):
        a, b = (k + 0.12) * w / pillows, (k + 0.88) * w / pillows
        lines.append(box(a, 0.06, b, 0.42))
    fold = d * float(rng.uniform(0.25, 0.4))
    lines.append(segment(0, fold, w, fold + float(rng.choice([0.0, 0.15, 0.3]))))
    return lines


def _sofa(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d), box(0.18, 0.22, w - 0.18, d)]
    seats = int(rng.integers(1, 4))
    lines += [segment(w * k / seats, 0.22, w * k / seats, d) for k in range(1, seats)]
    return lines


def _table(rng: np.random.Generator, w: float, d: float) -> Lines:
    round_one = rng.random() < 0.3
    inner = oval(w / 2, d / 2, w * 0.32, d * 0.32) if round_one else box(0.3, 0.3, w - 0.3, d - 0.3)
    lines = [inner]
    for k in range(int(rng.integers(1, 4))):
        x = w * (k + 0.5) / 3
        lines += [box(x - 0.2, 0.02, x + 0.2, 0.3), box(x - 0.2, d - 0.3, x + 0.2, d - 0.02)]
    return lines


def _low_table(rng: np.random.Generator, w: float, d: float) -> Lines:
    if rng.random() < 0.3:
        return [oval(w / 2, d / 2, w / 2, d / 2)]
    return [box(0, 0, w, d)] + ([box(0.06, 0.06, w - 0.06, d - 0.06)] if rng.random() < 0.3 else [])


def _wardrobe(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)]
    kind = rng.integers(4)
    if kind == 0:
        lines.append(segment(0, d / 2, w, d / 2))
        for x in np.arange(0.1, w, float(rng.uniform(0.08, 0.25))):
            lean = float(rng.uniform(-0.05, 0.05))
            lines.append(segment(x, 0.1 * d, x + lean, 0.9 * d))
    elif kind == 1:
        lines += [segment(0, 0, w, d), segment(0, d, w, 0)]
    elif kind == 2:
        lines += [segment(x, 0, x, d) for x in np.arange(0.5, w, 0.5)]
    return lines


def _cupboard(rng: np.random.Generator, w: float, d: float) -> Lines:
    """Return a fitted cupboard with pairs of open leaves in front."""
    leaves = 2 * max(1, round(w / 0.9))
    leaf, front = w / leaves, d - w / leaves
    lines = [box(0, 0, w, front)]
    for k in range(leaves):
        hinge, turn = (k * leaf, (0, 90)) if k % 2 == 0 else ((k + 1) * leaf, (90, 180))
        swing = oval(hinge, front, leaf, leaf, *turn)
        lines += [swing, segment(hinge, front, hinge, d)]
    return lines


def _dashed(_: np.random.Generator, w: float, d: float) -> Lines:
    """Return the dashed outline of a thing overhead: a skylight, a beam, a cupboard."""
    corners = box(0, 0, w, d)
    lines = []
    for start, end in pairwise(corners):
        stops = np.linspace(0, 1, 2 * max(2, round(float(np.linalg.norm(end - start)) / 0.25)))
        lines += [start + np.outer(pair, end - start) for pair in stops.reshape(-1, 2)]
    return lines


def _desk(_: np.random.Generator, w: float, d: float) -> Lines:
    return [
        box(0, 0, w, d * 0.6),
        oval(w / 2, d * 0.75, 0.22, 0.2),
        oval(w / 2, d * 0.8, 0.25, 0.2, 20, 160),
    ]


def _counter(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)]
    stove = float(rng.uniform(0, max(0.01, w - 0.6)))
    lines.append(box(stove, 0.04, stove + 0.58, d - 0.04))
    for a in (0.15, 0.43):
        for b in (0.17, 0.43):
            lines.append(oval(stove + a, b, 0.09, 0.09))
    sink = stove + 0.9 if stove + 1.5 < w else stove - 0.9
    if 0 < sink < w - 0.5:
        lines += [box(sink, 0.08, sink + 0.48, d - 0.08), oval(sink + 0.24, d / 2, 0.03, 0.03)]
        if rng.random() < 0.5:
            lines.append(box(sink + 0.03, 0.11, sink + 0.25, d - 0.11))
    if rng.random() < 0.5:
        lines += [segment(x, 0, x, d) for x in np.arange(0.6, w, 0.6)]
    return lines


def _fridge(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d), segment(0, 0, w, d), segment(0, d, w, 0)]


def _bath(_: np.random.Generator, w: float, d: float) -> Lines:
    inner = np.r_[
        oval(w - 0.1 - d * 0.35, d / 2, d * 0.35, d * 0.38, -90, 90),
        [(0.1, d * 0.88), (0.1, d * 0.12)],
    ]
    return [box(0, 0, w, d), np.r_[inner, inner[:1]], oval(0.25, d / 2, 0.03, 0.03)]


def _shower(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)]
    if rng.random() < 0.6:
        lines += [segment(0, 0, w, d), segment(0, d, w, 0)]
    if rng.random() < 0.4:
        lines.append(oval(0, 0, w, d, 0, 90))
    return [*lines, oval(w / 2, d / 2, 0.04, 0.04)]


def _toilet(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, 0.18), oval(w / 2, 0.18 + (d - 0.18) / 2, w * 0.45, (d - 0.18) / 2)]


def _basin(rng: np.random.Generator, w: float, d: float) -> Lines:
    outer = [box(0, 0, w, d)] if rng.random() < 0.7 else []
    return [*outer, oval(w / 2, d * 0.55, w * 0.36, d * 0.34), oval(w / 2, d * 0.4, 0.025, 0.025)]


def _washer(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d), oval(w / 2, d / 2, w * 0.36, d * 0.36)]


def _stairs(rng: np.random.Generator, w: float, d: float) -> Lines:
    lines = [box(0, 0, w, d)]
    lines += [segment(x, 0, x, d) for x in np.arange(0.27, w, 0.27)]
    lines.append(segment(0.1, d / 2, w - 0.15, d / 2))
    if rng.random() < 0.6:
        lines += [segment(w - 0.4, d / 2 - 0.12, w - 0.15, d / 2)]
        lines += [segment(w - 0.4, d / 2 + 0.12, w - 0.15, d / 2)]
    return lines


def _plant(rng: np.random.Generator, w: float, d: float) -> Lines:
    r = min(w, d) / 2
    lines = [oval(w / 2, d / 2, r, r)]
    for t in np.linspace(0, 2 * np.pi, int(rng.integers(5, 12)), endpoint=False):
        lines.append(segment(w / 2, d / 2, w / 2 + r * np.cos(t), d / 2 + r * np.sin(t)))
    return lines


def _shelf(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d), segment(0, d * 0.7, w, d * 0.7)]


def _seat(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d), box(0.1, 0.15, w - 0.1, d)]


def _square(_: np.random.Generator, w: float, d: float) -> Lines:
    return [box(0, 0, w, d)]


SYMBOLS = {
    entry.name: entry
    for entry in (
        Symbol("bed", (0.9, 1.9), (1.95, 2.15), _bed),
        Symbol("night table", (0.35, 0.55), (0.35, 0.5), _square),
        Symbol("wardrobe", (0.9, 2.6), (0.5, 0.65), _wardrobe),
        Symbol("desk", (1.0, 1.6), (0.9, 1.2), _desk),
        Symbol("sofa", (1.5, 2.6), (0.8, 1.05), _sofa),
        Symbol("armchair", (0.7, 0.95), (0.7, 0.95), _seat),
        Symbol("low table", (0.6, 1.2), (0.5, 0.8), _low_table, free=True),
        Symbol("table", (1.4, 2.2), (1.3, 1.7), _table, free=True),
        Symbol("shelf", (0.8, 2.4), (0.3, 0.5), _shelf),
        Symbol("counter", (1.6, 3.8), (0.58, 0.66), _counter),
        Symbol("fridge", (0.58, 0.75), (0.58, 0.68), _fridge),
        Symbol("bath", (1.5, 1.85), (0.68, 0.85), _bath),
        Symbol("shower", (0.75, 1.2), (0.75, 1.0), _shower),
        Symbol("toilet", (0.36, 0.45), (0.6, 0.72), _toilet),
        Symbol("basin", (0.45, 0.9), (0.38, 0.55), _basin),
        Symbol("washer", (0.55, 0.65), (0.55, 0.65), _washer),
        Symbol("stairs", (1.6, 3.4), (0.8, 1.1), _stairs),
        Symbol("cupboard", (0.8, 2.8), (0.95, 1.2), _cupboard),
        Symbol("dashed", (0.4, 2.0), (0.3, 0.6), _dashed, free=True),
        Symbol("island", (1.2, 2.8), (0.7, 1.1), _square, free=True),
        Symbol("plant", (0.3, 0.7), (0.3, 0.7), _plant),
        Symbol("seat", (0.5, 0.65), (0.5, 0.65), _seat, free=True),
    )
}
#: Names of the symbols in rooms of each type, in the order in which they are placed.
PIECES = {
    "Bedroom": ["bed", "wardrobe", "cupboard", "night table", "desk", "plant"],
    "Reception": ["sofa", "low table", "shelf", "table", "armchair", "plant", "dashed", "island"],
    "Kitchen": ["counter", "fridge", "table", "counter", "island", "dashed"],
    "Bathroom": ["toilet", "basin", "bath", "shower", "washer"],
    "Corridor": ["cupboard", "shelf", "wardrobe", "stairs"],
    "Entrance": ["cupboard", "wardrobe", "shelf", "stairs"],
    "Closet": ["cupboard", "wardrobe", "wardrobe", "shelf", "washer"],
    "Staircase": ["stairs", "stairs"],
    "Balcony": ["seat", "low table", "plant"],
    "Terrace": ["table", "plant", "seat", "plant"],
    "Outdoor": ["plant", "plant", "plant", "table"],
    "Unknown": ["desk", "shelf", "washer", "sofa"],
}
