"""Plants, lamps, rugs, heaps, people and bathrooms of drawn rooms."""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Body,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.spots import Spot
from plan2scene_workshop.segmentation.stencils import bars, disc, foliage, person, rag

Rng = np.random.Generator


def plant(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a pot with crossed cards of leaves, or with a crown of blobs."""
    pot = rng.uniform(0.15, 0.5)
    things = [
        spot.part((0, pot / 2, 0), (pot, pot, pot), paints.hard(rng), round=rng.random() < 0.4)
    ]
    h, wide = rng.uniform(0.4, 1.8), rng.uniform(0.4, 1.1)
    green = np.array([0.08, 0.2, 0.05]) * np.exp(rng.normal(0, 0.4, 3))
    if rng.random() < 0.75:
        for k in range(int(rng.integers(2, 5))):
            paint = plain(np.clip(green * np.exp(rng.normal(0, 0.3)), 0, 0.9))
            turn = float(k * 1.1 + rng.normal(0, 0.3))
            size = (wide, h, 0.008)
            shape = foliage(rng)
            things.append(spot.part((0, pot + h / 2, 0), size, paint, turn=turn, stencil=shape))
        return things
    for _ in range(int(rng.integers(8, 20))):
        paint = plain(np.clip(green * np.exp(rng.normal(0, 0.4)), 0, 0.9))
        place = (rng.normal(0, wide / 4), rng.uniform(pot, pot + h), rng.normal(0, wide / 4))
        things.append(spot.part(place, rng.uniform(0.05, 0.25, 3), paint, round=True))
    return things


def floor_lamp(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a lamp on a stand."""
    h, paint = rng.uniform(1.2, 1.8), paints.hard(rng)
    shade = plain(np.array([0.9, 0.85, 0.7])) if rng.random() < 0.7 else paints.thing(rng)
    glow, wide = float(rng.choice([0.0, 2.0])), rng.uniform(0.2, 0.5)
    soft = bool(rng.random() < 0.6)
    return [
        spot.part((0, 0.015, 0), (0.3, 0.02, 0.3), paint, stencil=disc()),
        spot.part((0, h / 2, 0), (0.03, h, 0.03), paint),
        spot.part((0, h, 0), (wide, 0.3, wide), shade, round=soft, glow=glow),
    ]


def heap(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return boxes, bags, toys, clothes: bodies of all sizes near and on one another."""
    things, y = [], 0.0
    for _ in range(int(rng.integers(1, 7))):
        size = rng.uniform(0.06, 0.7, 3) * rng.choice([0.5, 1.0])
        away = rng.normal(0, 0.3, 2)
        if rng.random() < 0.5:
            y = 0.0
        place = (away[0], y + size[1] / 2, away[1])
        turn = float(rng.uniform(0, np.pi))
        soft = bool(rng.random() < 0.4)
        things.append(spot.part(place, size, paints.thing(rng), round=soft, turn=turn))
        y += float(size[1]) * 0.9
    for _ in range(int(rng.integers(0, 3))):
        place = (rng.normal(0, 0.4), 0.01, rng.normal(0, 0.4))
        size = (rng.uniform(0.2, 0.8), 0.008, rng.uniform(0.2, 0.8))
        things.append(spot.part(place, size, paints.cloth(rng), stencil=rag(rng)))
    return things


def rug(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a rug: oblong with or without a border, round, or a hide."""
    size = (rng.uniform(0.6, 2.3), 0.012, rng.uniform(0.5, 1.7))
    paint = paints.cloth(rng)
    if rng.random() < 0.25:
        shape = disc() if rng.random() < 0.5 else rag(rng)
        return [spot.part((0, 0.008, 0), size, paint, stencil=shape)]
    if rng.random() < 0.5:
        return [spot.part((0, 0.008, 0), size, paint)]
    edge = (size[0] + rng.uniform(0.05, 0.4), 0.008, size[2] + rng.uniform(0.05, 0.4))
    return [
        spot.part((0, 0.009, 0), size, paint),
        spot.part((0, 0.005, 0), edge, paints.cloth(rng)),
    ]


def somebody(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a person cut out of card, in two colours of clothes."""
    h, shape = rng.uniform(1.2, 1.9), person(rng)
    rows = shape.shape[0]
    cuts = [(0, 16, plain(np.array([0.5, 0.3, 0.2]) * rng.uniform(0.2, 1.3)))]
    cuts += [(16, 48, paints.cloth(rng)), (48, rows, paints.cloth(rng))]
    parts = []
    for start, end, paint in cuts:
        middle = h * (1 - (start + end) / 2 / rows)
        size = (h / 2, h * (end - start) / rows, 0.008)
        parts.append(spot.part((0, middle, 0), size, paint, stencil=shape[start:end]))
    return parts


def bath(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a toilet, a basin, a tub or a shower."""
    white = plain(rng.uniform(0.6, 0.95) * np.ones(3), 0.7)
    steel = plain(rng.uniform(0.3, 0.7) * np.ones(3), 0.9)
    kind = int(rng.integers(4))
    if kind == 0:
        return [
            spot.part((0, 0.2, 0.3), (0.36, 0.4, 0.5), white, round=True),
            spot.part((0, 0.41, 0.3), (0.38, 0.02, 0.46), white, stencil=disc()),
            spot.part((0, 0.55, 0), (0.4, 0.75, 0.2), white),
        ]
    if kind == 1:
        under = rng.random() < 0.5
        base = paints.hard(rng) if under else white
        return [
            spot.part((0, 0.4, 0), ((0.7, 0.8, 0.4) if under else (0.15, 0.8, 0.15)), base),
            spot.part((0, 0.83, 0.03), (0.65, 0.14, 0.48), white),
            spot.part((0, 0.95, -0.15), (0.04, 0.2, 0.04), steel),
            spot.part((0, 1.5, -0.2), (0.6, 0.7, 0.03), steel, mirror=0.9),
        ]
    if kind == 2:
        return [
            spot.part((0, 0.28, 0), (1.7, 0.56, 0.75), white),
            spot.part((0, 0.555, 0), (1.5, 0.02, 0.55), plain(np.ones(3) * 0.5)),
        ]
    rail = bars(rng) if rng.random() < 0.3 else None
    return [
        spot.part((0, 0.05, 0), (0.9, 0.1, 0.9), white),
        spot.part((0.45, 1.0, 0), (0.02, 1.9, 0.9), steel, mirror=0.2, stencil=rail),
        spot.part((0, 1.95, 0.45), (0.9, 0.04, 0.04), steel),
    ]
