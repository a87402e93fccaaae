"""Furniture of living rooms and bedrooms."""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.rendering.geometry import box, cylinder, lathe, placement, superquadric
from plan2scene_workshop.rendering.palette import Palette, linear, pick
from plan2scene_workshop.rendering.pieces import (
    GLOSS_BLACK,
    METAL,
    Piece,
    cabinet,
    chair,
    cushion,
    hard,
    scatter,
    soft,
    table,
    table_lamp,
)


def sofa(rng: np.random.Generator, palette: Palette, seats: int = 0) -> Piece:
    """Return a sofa of two to four seats, or an armchair for one."""
    seats = seats or int(rng.integers(2, 5))
    arm = rng.uniform(0.1, 0.24)
    seat = rng.uniform(0.55, 0.72)
    piece = Piece(seats * seat + 2 * arm, rng.uniform(0.8, 1.0), rng.uniform(0.7, 0.95))
    look, half, front = soft(rng, palette), seats * seat / 2, piece.depth
    level, round_ = rng.uniform(0.36, 0.46), rng.uniform(0.15, 0.5)
    piece.add(look, box((-half - arm, 0.08, 0.02), (half + arm, level - 0.12, front - 0.02)))
    tall = piece.height
    piece.add(look, cushion((0, tall / 2 + 0.05, 0.1), (piece.width, tall - 0.1, 0.2), 0.2))
    arm_top = rng.uniform(0.52, 0.66)
    for side in (-1, 1):
        middle = side * (half + arm / 2)
        piece.add(
            look,
            cushion((middle, arm_top / 2 + 0.04, front / 2), (arm, arm_top - 0.08, front), 0.2),
        )
    for k in range(seats):
        x = -half + (k + 0.5) * seat
        piece.add(
            look, cushion((x, level - 0.06, front / 2 + 0.1), (seat, 0.17, front - 0.22), round_)
        )
        piece.add(look, cushion((x, level + 0.2, 0.26), (seat * 0.97, 0.42, 0.2), round_))
        if rng.random() < 0.5:
            extra = soft(rng, palette)
            turn = placement(x + rng.uniform(-0.1, 0.1), 0.42, rng.uniform(-0.4, 0.4), level + 0.17)
            piece.add(extra, cushion((0, 0, 0), (0.42, 0.38, 0.13), 0.5).moved(turn))
    return piece


def armchair(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return an armchair."""
    return sofa(rng, palette, 1)


def bed(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a bed with headboard, mattress, blanket and pillows."""
    wide = float(rng.choice([0.9, 1.2, 1.4, 1.6, 1.8]))
    piece = Piece(wide + 0.08, rng.uniform(2.02, 2.15), rng.uniform(0.8, 1.25))
    frame = hard(rng, palette) if rng.random() < 0.6 else soft(rng, palette)
    half, long, level = wide / 2, piece.depth, rng.uniform(0.42, 0.58)
    piece.add(frame, box((-half - 0.04, 0, 0), (half + 0.04, piece.height, 0.06)))
    piece.add(frame, box((-half - 0.04, 0.1, 0.06), (half + 0.04, level - 0.15, long)))
    sheet = ("fabric", linear(rng.random(), rng.uniform(0, 0.1), rng.uniform(0.8, 0.95)))
    piece.add(sheet, cushion((0, level - 0.1, long / 2 + 0.03), (wide, 0.24, long - 0.06), 0.15))
    cover, reach = soft(rng, palette), rng.uniform(0.9, 1.5)
    size = (wide + 0.06, 0.3, reach)
    piece.add(cover, cushion((0, level - 0.1, long - reach / 2 + 0.02), size, 0.15))
    count = 1 if wide < 1.3 else 2
    for k in range(count):
        x = (k - (count - 1) / 2) * wide / 2
        piece.add(sheet, cushion((x, level + 0.1, 0.32), (0.62, 0.16, 0.4), 0.55))
        if rng.random() < 0.5:
            piece.add(soft(rng, palette), cushion((x, level + 0.16, 0.5), (0.4, 0.3, 0.14), 0.5))
    return piece


def _size(rng: np.random.Generator, *ranges: tuple[float, float]) -> tuple[float, float, float]:
    """Return a width, a depth and a height from their ranges."""
    width, depth, height = (rng.uniform(*limits) for limits in ranges)
    return width, depth, height


def wardrobe(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a wardrobe."""
    return cabinet(rng, palette, _size(rng, (0.8, 2.2), (0.55, 0.62), (1.85, 2.25)))


def dresser(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a low chest of drawers with things on it."""
    piece = cabinet(rng, palette, _size(rng, (0.6, 1.5), (0.35, 0.5), (0.6, 1.0)))
    scatter(piece, rng, palette, piece.height, int(rng.integers(1, 5)))
    return piece


def night_table(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a bedside table with a lamp."""
    piece = cabinet(rng, palette, (rng.uniform(0.38, 0.52), 0.4, rng.uniform(0.42, 0.6)))
    table_lamp(piece, rng, palette, piece.height)
    return piece


def bookshelf(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return open shelves with books and boxes."""
    piece = Piece(*_size(rng, (0.5, 1.5), (0.26, 0.36), (0.9, 2.15)))
    look, half, depth = hard(rng, palette), piece.width / 2, piece.depth
    rows = max(2, round(piece.height / rng.uniform(0.32, 0.42)))
    for x in (-half, half - 0.025):
        piece.add(look, box((x, 0, 0), (x + 0.025, piece.height, depth)))
    if rng.random() < 0.7:
        piece.add(look, box((-half, 0, 0), (half, piece.height, 0.012)))
    for j in range(rows + 1):
        y = 0.04 + (piece.height - 0.065) * j / rows
        piece.add(look, box((-half, y, 0), (half, y + 0.025, depth)))
        if j < rows and rng.random() < 0.85:
            _books(piece, rng, palette, y + 0.025, (piece.height - 0.065) / rows - 0.04)
    return piece


def _books(piece: Piece, rng: np.random.Generator, palette: Palette, y: float, room: float) -> None:
    x, end = -piece.width / 2 + 0.04, piece.width / 2 - 0.04
    fill = rng.uniform(0.3, 1.0)
    while x < end * fill:
        wide = rng.uniform(0.02, 0.05) if rng.random() < 0.88 else rng.uniform(0.12, 0.25)
        if x + wide > end:
            return
        tall = room * rng.uniform(0.6, 0.98)
        deep = piece.depth * rng.uniform(0.6, 0.9)
        colour = pick(rng, palette.accents) if rng.random() < 0.6 else pick(rng, palette.furniture)
        piece.add(("paint", colour), box((x, y, 0.02), (x + wide - 0.002, y + tall, deep)))
        x += wide


def television(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a low unit with a television."""
    piece = cabinet(rng, palette, _size(rng, (1.1, 2.0), (0.36, 0.48), (0.35, 0.55)))
    wide, y = rng.uniform(0.8, 1.3), piece.height
    piece.add(
        GLOSS_BLACK, box((-wide / 2, y + 0.06, 0.12), (wide / 2, y + 0.06 + wide * 0.56, 0.16))
    )
    piece.add(
        GLOSS_BLACK,
        box((-0.2, y, 0.06), (0.2, y + 0.015, 0.26)),
        box((-0.04, y, 0.1), (0.04, y + 0.1, 0.13)),
    )
    piece.height = y + 0.06 + wide * 0.56
    return piece


def coffee_table(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a coffee table with things on it."""
    piece = table(rng, palette, _size(rng, (0.6, 1.2), (0.45, 0.7), (0.32, 0.48)))
    scatter(piece, rng, palette, piece.height, int(rng.integers(0, 4)))
    return piece


def desk(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a desk with a screen and a chair."""
    piece = table(rng, palette, (rng.uniform(0.9, 1.5), rng.uniform(0.55, 0.7), 0.74))
    piece.add(
        GLOSS_BLACK,
        box((-0.28, 0.86, 0.15), (0.28, 1.2, 0.17)),
        box((-0.05, 0.74, 0.13), (0.05, 0.9, 0.15)),
    )
    seat = chair(rng, palette)
    piece.put(seat, placement(0, piece.depth + 0.35, np.pi + rng.uniform(-0.4, 0.4)))
    piece.depth += 0.4
    piece.height = 1.2
    return piece


def dining_set(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a table with two to six chairs around it, the same model each."""
    wide, deep = rng.uniform(0.8, 1.7), rng.uniform(0.75, 0.95)
    whole = Piece(wide + 0.1, deep + 0.9, 0.98)
    whole.put(table(rng, palette, (wide, deep, 0.75)), placement(0, 0.45, 0))
    model = chair(rng, palette)
    per_side = max(1, int(wide / 0.6))
    for k in range(per_side):
        x = (k - (per_side - 1) / 2) * wide / per_side
        for z, angle in ((0.02, 0.0), (deep + 0.88, np.pi)):
            if rng.random() < 0.85:
                turn = angle + rng.uniform(-0.15, 0.15)
                whole.put(model, placement(x, z + (0.08 if angle == 0 else -0.08), turn))
    if rng.random() < 0.5:
        bowl = superquadric((0, 0.8, 0.45 + deep / 2), (0.14, 0.06, 0.14))
        whole.add(("gloss", pick(rng, palette.accents)), bowl)
    return whole


def ottoman(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a round or square pouf."""
    side, tall = rng.uniform(0.4, 0.75), rng.uniform(0.32, 0.48)
    piece = Piece(side, side, tall)
    solid = superquadric(
        (0, tall / 2, side / 2),
        (side / 2, tall / 2, side / 2),
        roundness=(0.3, rng.choice([0.3, 1.0])),
    )
    piece.add(soft(rng, palette), solid)
    return piece


def floor_lamp(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a standing lamp (not shining)."""
    tall = rng.uniform(1.4, 1.75)
    piece = Piece(0.4, 0.4, tall)
    piece.add(METAL, cylinder((0, 0, 0.2), 0.14, 0.02), cylinder((0, 0, 0.2), 0.012, tall - 0.2, 8))
    piece.add(
        ("fabric", pick(rng, palette.fabrics)), lathe((0, tall, 0.2), [(0.19, -0.3), (0.13, 0)], 18)
    )
    return piece
