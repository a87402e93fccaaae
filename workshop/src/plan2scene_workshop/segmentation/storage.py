"""Tables, cupboards, shelves and kitchens of drawn rooms, and what lies on them."""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Body,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.seating import chair, legs, office_chair
from plan2scene_workshop.segmentation.spots import Spot
from plan2scene_workshop.segmentation.stencils import disc, foliage

Rng = np.random.Generator


def table(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a table, square or round, with things on it, at times with chairs around."""
    w, d, h = rng.uniform(0.4, 2.2), rng.uniform(0.4, 1.1), rng.uniform(0.35, 0.95)
    top = paints.hard(rng)
    thick = rng.uniform(0.02, 0.06)
    if rng.random() < 0.2:
        d = w = min(w, 1.3)
        size, shape = (w, 0.02, w), disc()
        things = [spot.part((0, h, 0), size, top, stencil=shape)]
        things += legs(spot, 0.6 * w, 0.6 * w, h, paints.hard(rng), rng)
    else:
        things = [spot.part((0, h, 0), (w, thick, d), top)]
        things += legs(spot, w, d, h, top if rng.random() < 0.6 else paints.hard(rng), rng)
    if rng.random() < 0.15:
        things.append(spot.part((0, h + 0.01, 0), (w * 0.9, 0.04, d + 0.1), paints.cloth(rng)))
    if h > 0.65 and rng.random() < 0.5:
        for k in range(int(rng.integers(1, 7))):
            side = 1 - 2 * (k % 2)
            x = rng.uniform(-0.45, 0.45) * w
            turn = float(np.pi * (side > 0) + rng.normal(0, 0.2))
            things += chair(spot.at(x, side * (d / 2 + rng.uniform(0, 0.3)), turn), paints, rng)
    return things + clutter(spot, w, d, h + 0.02, paints, rng)


def desk(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a desk with a screen or laptop, papers, drawers, and an office chair."""
    w, d, h = rng.uniform(0.9, 1.9), rng.uniform(0.55, 0.8), rng.uniform(0.7, 0.78)
    top = paints.hard(rng)
    things = [spot.part((0, h, 0), (w, 0.03, d), top), *legs(spot, w, d, h, paints.hard(rng), rng)]
    if rng.random() < 0.5:
        paint = paints.hard(rng)
        things.append(
            spot.part((rng.choice([-1, 1]) * (w / 2 - 0.25), 0.3, 0), (0.4, 0.55, d), paint)
        )
    for _ in range(int(rng.integers(1, 3))):
        things += screen(spot.at(rng.uniform(-0.3, 0.3) * w, -0.1), h + 0.015, paints, rng)
    if rng.random() < 0.75:
        place = spot.at(rng.uniform(-0.3, 0.3) * w, rng.uniform(0.3, 0.8), rng.normal(np.pi, 0.6))
        things += (office_chair if rng.random() < 0.7 else chair)(place, paints, rng)
    if rng.random() < 0.3:  # a screen between desks
        size = (w, rng.uniform(0.3, 0.6), 0.03)
        things.append(spot.part((0, h + 0.2, -d / 2), size, paints.cloth(rng)))
    return things + clutter(spot, w, d, h + 0.015, paints, rng)


def screen(spot: Spot, h: float, paints: Paints, rng: Rng) -> list[Body]:
    """Return a monitor, or a laptop that stands open, on a top at height h."""
    dark = plain(np.ones(3) * rng.uniform(0.005, 0.08), 0.7)
    shown = dark if rng.random() < 0.5 else paints.of("poster", rng, 0.0)
    glow = float(rng.uniform(0.2, 1.2))
    if rng.random() < 0.6:
        w, high = rng.uniform(0.4, 0.75), rng.uniform(0.28, 0.42)
        return [
            spot.part((0, h + 0.1, 0), (0.05, 0.2, 0.04), dark),
            spot.part((0, h + 0.01, 0), (0.22, 0.015, 0.18), dark),
            spot.part((0, h + 0.14 + high / 2, 0.02), (w, high, 0.03), dark),
            spot.part(
                (0, h + 0.14 + high / 2, 0.035), (w - 0.03, high - 0.03, 0.01), shown, glow=glow
            ),
        ]
    grey = plain(np.ones(3) * rng.uniform(0.02, 0.7), 0.4)
    return [
        spot.part((0, h + 0.01, 0.1), (0.34, 0.02, 0.24), grey),
        spot.part((0, h + 0.12, -0.05), (0.34, 0.23, 0.01), grey, tilt=-0.3),
        spot.part((0, h + 0.12, -0.04), (0.31, 0.2, 0.01), shown, tilt=-0.3, glow=glow),
    ]


def clutter(spot: Spot, w: float, d: float, h: float, paints: Paints, rng: Rng) -> list[Body]:
    """Return small things on a top: papers, books, cups, boxes, a vase."""
    things = []
    for _ in range(int(rng.choice([0, 2, 4, 8, 14], p=[0.2, 0.25, 0.25, 0.2, 0.1]))):
        x, z = rng.uniform(-0.45, 0.45) * w, rng.uniform(-0.45, 0.45) * d
        turn, kind = float(rng.uniform(0, np.pi)), rng.random()
        if kind < 0.3:
            white = plain(np.ones(3) * rng.uniform(0.4, 0.95))
            paper = white if rng.random() < 0.6 else paints.of("poster", rng, 0.0)
            things.append(spot.part((x, h, z), (0.21, 0.008, 0.3), paper, turn=turn))
        elif kind < 0.5:
            size = (rng.uniform(0.13, 0.3), rng.uniform(0.02, 0.15), rng.uniform(0.15, 0.3))
            things.append(spot.part((x, h + size[1] / 2, z), size, paints.thing(rng), turn=turn))
        elif kind < 0.75:
            r, high = rng.uniform(0.06, 0.16), rng.uniform(0.08, 0.3)
            place = (x, h + high / 2, z)
            things.append(spot.part(place, (r, high, r), paints.thing(rng), round=True))
        elif kind < 0.82:
            green = plain(np.array([0.1, 0.25, 0.06]) * np.exp(rng.normal(0, 0.5, 3)))
            size, shape = (0.4, 0.5, 0.008), foliage(rng)
            things.append(spot.part((x, h + 0.3, z), size, green, stencil=shape, turn=turn))
            things.append(spot.part((x, h + 0.07, z), (0.12, 0.14, 0.12), paints.thing(rng)))
        else:
            box = rng.uniform(0.04, 0.35, 3)
            place = (x, h + box[1] / 2, z)
            things.append(spot.part(place, box, paints.thing(rng), turn=turn))
    return things


def cabinet(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a chest, sideboard or wardrobe with doors or drawers, at times a television on it."""
    w, d = rng.uniform(0.4, 2.6), rng.uniform(0.3, 0.65)
    h = float(rng.choice([rng.uniform(0.4, 1.0), rng.uniform(1.4, 2.4)]))
    paint = paints.hard(rng)
    front = paint if rng.random() < 0.6 else paints.hard(rng)
    columns, rows = int(rng.integers(1, 5)), int(rng.integers(1, 5))
    foot = float(rng.choice([0.0, 0.1, 0.2]))
    things = [spot.part((0, (h + foot) / 2, 0), (w, h - foot, d), paint)]
    if foot:
        things += legs(spot, w, d, foot, paint, rng)
    knob = plain(np.ones(3) * rng.uniform(0.02, 0.7), 0.7)
    mirror = 0.85 if h > 1.3 and rng.random() < 0.2 else 0.0
    for i in range(columns):
        for j in range(rows):
            cell = (w / columns, (h - foot) / rows)
            x, y = (i + 0.5) * cell[0] - w / 2, foot + (j + 0.5) * cell[1]
            size = (cell[0] - 0.02, cell[1] - 0.02, 0.025)
            things.append(spot.part((x, y, d / 2), size, front, mirror=mirror * (i == 0)))
            things.append(spot.part((x, y, d / 2 + 0.02), (0.1, 0.02, 0.03), knob))
    if h < 1.0 and rng.random() < 0.3:
        dark = plain(np.ones(3) * 0.01, 0.8)
        size = (rng.uniform(0.6, 1.4), rng.uniform(0.4, 0.8), 0.06)
        things.append(spot.part((0, h + size[1] / 2 + 0.05, 0), size, dark, mirror=0.15))
    return things + clutter(spot, w, d, h, paints, rng)


def shelf(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a shelf: a full front of books, or boards with things between."""
    w, d, h, paint = rng.uniform(0.5, 2.4), 0.3, rng.uniform(0.8, 2.3), paints.hard(rng)
    if rng.random() < 0.55:
        front = paints.of("books", rng, 0.0)
        return [
            spot.part((0, h / 2, 0), (w, h, d), paint),
            spot.part((0, h / 2, d / 2), (w - 0.05, h - 0.05, 0.02), front),
            *clutter(spot, w, d, h, paints, rng),
        ]
    things = [spot.part((s * w / 2, h / 2, 0), (0.03, h, d), paint) for s in (-1, 1)]
    if rng.random() < 0.6:
        things.append(spot.part((0, h / 2, -d / 2), (w, h, 0.01), paints.hard(rng)))
    levels = int(rng.integers(2, 6))
    for j in range(levels + 1):
        y = h * j / levels
        things.append(spot.part((0, y, 0), (w, 0.03, d), paint))
        for _ in range(int(rng.integers(0, 5)) if j < levels else 0):
            size = (rng.uniform(0.05, 0.4) * w, rng.uniform(0.3, 0.9) * h / levels, 0.2)
            place = (rng.uniform(-0.3, 0.3) * w, y + size[1] / 2, 0)
            stuff = paints.of("books", rng, 0.0) if rng.random() < 0.3 else paints.thing(rng)
            things.append(spot.part(place, size, stuff))
    return things


def kitchen(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a run of counters with a top, appliances, a sink and wall cupboards."""
    units, step = int(rng.integers(2, 7)), 0.6
    w = units * step
    front, top = paints.hard(rng), paints.hard(rng)
    white = plain(rng.uniform(0.5, 0.95) * np.ones(3), 0.4)
    steel = plain(rng.uniform(0.2, 0.6) * np.ones(3), 0.9)
    dark = plain(np.ones(3) * 0.015, 0.8)
    things = [
        spot.part((0, 0.49, 0), (w, 0.78, 0.56), front),
        spot.part((0, 0.9, 0.01), (w + 0.02, 0.04, 0.62), top),
    ]
    above = rng.random() < 0.7
    for k in range(units):
        x, kind = (k + 0.5) * step - w / 2, rng.random()
        paint = steel if kind < 0.15 else white if kind < 0.25 else front
        things.append(spot.part((x, 0.5, 0.29), (step - 0.02, 0.74, 0.02), paint))
        things.append(spot.part((x, 0.78, 0.31), (0.2, 0.02, 0.03), steel))
        if kind < 0.15:
            things.append(spot.part((x, 0.45, 0.305), (0.45, 0.4, 0.01), dark))
            things.append(spot.part((x, 0.92, 0), (0.55, 0.01, 0.5), dark, mirror=0.3))
        if above and rng.random() < 0.85:
            things.append(spot.part((x, 1.75, -0.12), (step - 0.01, 0.7, 0.34), front))
    if rng.random() < 0.5:
        x = w / 2 + 0.32
        things.append(
            spot.part((x, 0.95, 0), (0.6, 1.9, 0.62), white if rng.random() < 0.6 else steel)
        )
    return things + clutter(spot, w, 0.55, 0.92, paints, rng)
