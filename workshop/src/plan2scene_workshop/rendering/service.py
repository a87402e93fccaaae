"""Furniture of kitchens, bathrooms and corridors; plants and cartons."""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.rendering.geometry import box, cylinder, lathe, placement, superquadric
from plan2scene_workshop.rendering.palette import STONES, Palette, linear, pick
from plan2scene_workshop.rendering.pieces import (
    GLOSS_BLACK,
    GLOSS_WHITE,
    METAL,
    WHITE,
    Look,
    Piece,
    cabinet,
    cushion,
    hard,
    scatter,
    soft,
    table,
)


def plant(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a potted plant with leaves."""
    tall = rng.uniform(0.5, 1.7)
    piece = Piece(0.5, 0.5, tall)
    pot = rng.uniform(0.2, 0.36)
    profile = [(0, 0), (0.11, 0), (0.16, pot), (0.13, pot), (0, pot - 0.03)]
    piece.add(
        ("gloss" if rng.random() < 0.5 else "paint", pick(rng, palette.furniture)),
        lathe((0, 0, 0.25), profile, 16),
    )
    green = pick(rng, palette.plants)
    for _ in range(int(rng.integers(14, 34))):
        leaf = superquadric(
            (0, 0, 0), (rng.uniform(0.03, 0.07), 0.006, rng.uniform(0.08, 0.18)), steps=(4, 8)
        )
        angle, tilt = rng.uniform(0, 2 * np.pi), rng.uniform(-0.9, 0.3)
        lean = np.eye(4)
        lean[1:3, 1:3] = [[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]]
        lean[2, 3] = 0.1
        y = rng.uniform(pot, tall)
        piece.add(("paint", green), leaf.moved(placement(0, 0.25, angle, y) @ lean))
    piece.add(
        ("paint", (0.1, 0.06, 0.03)), cylinder((0, pot - 0.05, 0.25), 0.015, tall - pot - 0.05, 6)
    )
    return piece


def carton(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a pile of one to four cartons."""
    piece = Piece(rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.5), 0.0)
    level = 0.0
    for _ in range(int(rng.integers(1, 5))):
        tall = rng.uniform(0.15, 0.4)
        half = piece.width / 2 * rng.uniform(0.7, 1)
        colour = (
            linear(0.08, 0.45, rng.uniform(0.5, 0.75))
            if rng.random() < 0.6
            else pick(rng, palette.accents)
        )
        piece.add(("fabric", colour), box((-half, level, 0.02), (half, level + tall, piece.depth)))
        level += tall
    piece.height = level
    return piece


def fridge(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a fridge."""
    piece = Piece(0.6, 0.65, rng.uniform(1.5, 2.0))
    look: Look = METAL if rng.random() < 0.4 else GLOSS_WHITE
    split = rng.uniform(0.4, 0.7)
    piece.add(
        look,
        box((-0.3, 0.03, 0), (0.3, split, 0.65)),
        box((-0.3, split + 0.01, 0), (0.3, piece.height, 0.65)),
    )
    piece.add(METAL, box((0.22, split + 0.06, 0.65), (0.24, split + 0.5, 0.68)))
    return piece


def washer(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a washing machine."""
    piece = Piece(0.6, 0.6, 0.85)
    piece.add(GLOSS_WHITE, box((-0.3, 0.01, 0), (0.3, 0.85, 0.58)))
    lie = np.array([[1, 0, 0, 0], [0, 0, -1, 0.42], [0, 1, 0, 0.58], [0, 0, 0, 1.0]])
    piece.add(METAL, cylinder((0, 0, 0), 0.19, 0.02, 24).moved(lie))
    piece.add(GLOSS_BLACK, cylinder((0, 0, 0), 0.15, 0.03, 24).moved(lie))
    return piece


def kitchen_run(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a kitchen counter with hob, sink, oven, and cupboards on the wall above."""
    wide, height = rng.uniform(1.4, 3.2), 0.9
    look = hard(rng, palette)
    piece = cabinet(rng, palette, (wide, 0.6, height - 0.04), look)
    piece.width, piece.height, half = wide, 2.15, wide / 2
    top: Look = (
        STONES[0] if rng.random() < 0.4 else hard(rng, palette)[0],
        pick(rng, palette.furniture),
    )
    piece.add(top, box((-half, height - 0.04, 0), (half, height, 0.63)))
    hob = rng.uniform(-half + 0.35, half - 0.35)
    piece.add(GLOSS_BLACK, box((hob - 0.29, height, 0.06), (hob + 0.29, height + 0.008, 0.57)))
    piece.add(GLOSS_BLACK, box((hob - 0.28, 0.2, 0.6), (hob + 0.28, 0.75, 0.61)))
    sink = hob + 0.75 if hob < 0 else hob - 0.75
    piece.add(METAL, box((sink - 0.25, height, 0.1), (sink + 0.25, height + 0.004, 0.5)))
    piece.add(METAL, cylinder((sink, height, 0.08), 0.015, 0.28, 8))
    if rng.random() < 0.75:
        above = cabinet(rng, palette, (wide, 0.34, rng.uniform(0.5, 0.75)), look)
        piece.put(above, placement(0, 0, 0, 1.42))
    else:
        piece.height = 1.25
    scatter(piece, rng, palette, height + 0.008, int(rng.integers(1, 6)))
    return piece


def toilet(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a toilet."""
    piece = Piece(0.4, 0.68, 0.8)
    piece.add(GLOSS_WHITE, cushion((0, 0.58, 0.09), (0.38, 0.42, 0.18), 0.2))
    piece.add(GLOSS_WHITE, superquadric((0, 0.22, 0.42), (0.15, 0.22, 0.22), roundness=(0.5, 0.8)))
    piece.add(GLOSS_WHITE, superquadric((0, 0.41, 0.43), (0.19, 0.035, 0.25), roundness=(0.4, 0.8)))
    return piece


def basin(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a basin on a cabinet with a mirror above."""
    wide = rng.uniform(0.5, 1.2)
    piece = cabinet(rng, palette, (wide, 0.46, 0.8))
    piece.add(GLOSS_WHITE, cushion((0, 0.86, 0.24), (min(wide, 0.6), 0.13, 0.44), 0.3))
    piece.add(
        METAL,
        cylinder((0, 0.92, 0.06), 0.014, 0.16, 8),
        box((-0.01, 1.06, 0.06), (0.01, 1.08, 0.2)),
    )
    high = rng.uniform(0.6, 0.9)
    piece.add(("mirror", WHITE), box((-wide * 0.45, 1.15, 0), (wide * 0.45, 1.15 + high, 0.02)))
    piece.height = 1.15 + high
    return piece


def bathtub(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a bathtub with an open inside."""
    piece = Piece(rng.uniform(1.5, 1.75), rng.uniform(0.7, 0.8), rng.uniform(0.5, 0.6))
    half, deep, top = piece.width / 2, piece.depth, piece.height
    rim = 0.07
    piece.add(
        GLOSS_WHITE,
        box((-half, 0, 0), (half, 0.15, deep)),
        box((-half, 0.15, 0), (half, top, rim)),
        box((-half, 0.15, deep - rim), (half, top, deep)),
        box((-half, 0.15, rim), (-half + 0.12, top, deep - rim)),
        box((half - 0.12, 0.15, rim), (half, top, deep - rim)),
    )
    piece.add(METAL, box((half - 0.2, top + 0.1, 0.0), (half - 0.16, top + 0.13, 0.16)))
    return piece


def coat_rack(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return coats on hooks above a bench."""
    piece = Piece(rng.uniform(0.6, 1.2), 0.35, 1.8)
    half = piece.width / 2
    piece.add(hard(rng, palette), box((-half, 1.68, 0), (half, 1.78, 0.03)))
    piece.put(table(rng, palette, (piece.width, 0.33, 0.45)), np.eye(4))
    for k in range(int(rng.integers(2, 5))):
        x = -half + 0.12 + k * 0.2
        if x < half - 0.1:
            long = rng.uniform(0.6, 1.0)
            piece.add(
                soft(rng, palette), cushion((x, 1.7 - long / 2, 0.12), (0.22, long, 0.18), 0.5)
            )
    return piece
