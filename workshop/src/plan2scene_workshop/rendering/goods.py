"""Furniture that fills a whole photo: worktops, long tables, racks of goods, walls of cupboards.

From near, tops look like floors and full shelves like walls, so training rooms have many of both.
"""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.rendering.geometry import Colour, Solid, box, lathe, placement
from plan2scene_workshop.rendering.palette import Palette, linear, pick
from plan2scene_workshop.rendering.pieces import (
    GLOSS_BLACK,
    GLOSS_WHITE,
    METAL,
    Look,
    Piece,
    hard,
    legs,
    soft,
)

#: Probability of each kind of thing on a top, in the order of :func:`_thing`.
_THINGS = (0.24, 0.24, 0.2, 0.14, 0.06, 0.12)
PAPER: Colour = (0.8, 0.8, 0.78)
_Range = tuple[float, float]


def strew(
    piece: Piece, rng: np.random.Generator, palette: Palette, y: float, x: _Range, z: _Range
) -> None:
    """Put papers, books, bottles, cups, plates, screens and cloths on a top at height `y`."""
    area = (x[1] - x[0]) * (z[1] - z[0])
    for _ in range(int(rng.uniform(0, 16) * area + rng.random())):
        look, solids = _thing(rng, palette)
        turn = placement(rng.uniform(*x), rng.uniform(*z), rng.uniform(0, 2 * np.pi), y)
        piece.add(look, *(solid.moved(turn) for solid in solids))


def _thing(rng: np.random.Generator, palette: Palette) -> tuple[Look, list[Solid]]:
    """Return the look and the solids of one thing, standing at the origin."""
    colour = pick(rng, palette.accents if rng.random() < 0.6 else palette.furniture)
    kind, tall = int(rng.choice(6, p=_THINGS)), float(rng.uniform(0.06, 0.32))
    if kind == 0:  # sheets of paper
        a, b = rng.uniform(0.07, 0.16, 2)
        return ("paint", PAPER), [box((-a, 0.0005, -b), (a, rng.uniform(0.001, 0.01), b))]
    if kind == 1:  # books and boxes
        a, b = rng.uniform(0.05, 0.18, 2)
        return ("paint", colour), [box((-a, 0, -b), (a, tall * rng.uniform(0.1, 1.2), b))]
    if kind == 2:  # bottles, vases, tins
        r = rng.uniform(0.02, 0.07)
        profile = [(0, 0), (r, 0), (r, tall * 0.6), (r * rng.uniform(0.3, 1), tall), (0, tall)]
        return ("gloss", colour), [lathe((0, 0, 0), profile, 12)]
    if kind == 3:  # plates and bowls
        r = rng.uniform(0.06, 0.18)
        white = GLOSS_WHITE if rng.random() < 0.5 else ("gloss", colour)
        return white, [lathe((0, 0, 0), [(0, 0.002), (r * 0.6, 0.002), (r, r * 0.3)], 14)]
    if kind == 4:  # a screen or a laptop
        a = rng.uniform(0.12, 0.26)
        screen = box((-a, 0.04, 0), (a, 0.04 + 1.2 * a, 0.02))
        return GLOSS_BLACK, [screen, box((-a, 0, 0), (a, 0.02, a * 1.2))]
    a, b = rng.uniform(0.1, 0.3, 2)  # cloths and mats
    return soft(rng, palette), [box((-a, 0.0005, -b), (a, rng.uniform(0.002, 0.03), b))]


def long_table(rng: np.random.Generator, palette: Palette, top: Look) -> Piece:
    """Return a large table or desk full of things."""
    piece = Piece(rng.uniform(1.2, 3.2), rng.uniform(0.7, 1.3), rng.uniform(0.68, 0.8))
    half, level, thick = piece.width / 2, piece.height, rng.uniform(0.02, 0.06)
    piece.add(top, box((-half, level - thick, 0), (half, level, piece.depth)))
    leg = METAL if rng.random() < 0.4 else hard(rng, palette)
    legs(piece, leg, level - thick, rng.uniform(0, 0.1), rng.uniform(0.03, 0.08))
    if rng.random() < 0.35:
        piece.add(leg, box((-half, 0, 0.02), (half, level - thick, 0.04)))
    if rng.random() < 0.25:
        cloth = soft(rng, palette)
        piece.add(
            cloth, box((-half * 0.99, level, 0.01), (half * 0.99, level + 0.003, piece.depth))
        )
    strew(piece, rng, palette, level + 0.003, (-half, half), (0.0, piece.depth))
    return piece


def counter(rng: np.random.Generator, palette: Palette, top: Look) -> Piece:
    """Return a kitchen counter, island or shop desk, its worktop full of things."""
    piece = Piece(rng.uniform(1.2, 3.6), rng.uniform(0.55, 1.1), rng.uniform(0.82, 1.1))
    half, level, deep = piece.width / 2, piece.height, piece.depth
    look = fronts_look(rng, palette)
    piece.add(look, box((-half, 0, 0), (half, level - 0.04, deep - 0.04)))
    _fronts(piece, rng, look, (-half, half), (0.08, level - 0.06), deep - 0.04)
    piece.add(top, box((-half - 0.01, level - 0.04, 0), (half + 0.01, level, deep)))
    if rng.random() < 0.5:
        x = rng.uniform(-half + 0.3, half - 0.3)
        basin = METAL if rng.random() < 0.6 else GLOSS_WHITE
        piece.add(basin, box((x - 0.26, level, 0.1), (x + 0.26, level + 0.004, min(0.5, deep))))
    strew(piece, rng, palette, level + 0.004, (-half, half), (0.05, deep - 0.03))
    return piece


def fronts_look(rng: np.random.Generator, palette: Palette) -> Look:
    """Return the look of cupboards: white, wood or lacquer."""
    white = linear(rng.random(), rng.uniform(0, 0.08), rng.uniform(0.75, 0.97))
    if rng.random() < 0.4:
        return ("gloss" if rng.random() < 0.5 else "paint"), white
    return hard(rng, palette)


def cupboard_wall(rng: np.random.Generator, palette: Palette, height: float) -> Piece:
    """Return cupboards, fridge and oven side by side, up to `height`."""
    piece = Piece(rng.uniform(1.2, 3.6), rng.uniform(0.55, 0.68), height)
    half, deep, look = piece.width / 2, piece.depth, fronts_look(rng, palette)
    piece.add(look, box((-half, 0, 0), (half, height, deep)))
    columns = max(2, round(piece.width / rng.uniform(0.45, 0.95)))
    wide, split = piece.width / columns, rng.uniform(1.6, 2.1)
    for k in range(columns):
        x = (-half + k * wide + 0.004, -half + (k + 1) * wide - 0.004)
        kind = rng.random()
        if kind < 0.25:
            _fridge(piece, rng, x, split, deep)
        elif kind < 0.4:
            _oven(piece, rng, x, split, deep)
        else:
            _fronts(piece, rng, look, x, (0.08, split), deep)
        _fronts(piece, rng, look, x, (split + 0.01, height - 0.02), deep)
    return piece


def _fridge(piece: Piece, rng: np.random.Generator, x: _Range, top: float, z: float) -> None:
    look = METAL if rng.random() < 0.6 else GLOSS_WHITE
    split = top * rng.uniform(0.3, 0.7)
    for low, high in ((0.05, split - 0.005), (split + 0.005, top)):
        piece.add(look, box((x[0], low, z), (x[1], high, z + 0.03)))
        handle = x[0] + 0.04
        piece.add(METAL, box((handle, low + 0.1, z + 0.03), (handle + 0.02, high - 0.1, z + 0.07)))


def _oven(piece: Piece, rng: np.random.Generator, x: _Range, top: float, z: float) -> None:
    low = rng.uniform(0.3, 0.9)
    piece.add(METAL, box((x[0], low, z), (x[1], low + 0.62, z + 0.02)))
    piece.add(GLOSS_BLACK, box((x[0] + 0.04, low + 0.05, z), (x[1] - 0.04, low + 0.45, z + 0.024)))
    piece.add(GLOSS_BLACK, box((x[0], low + 0.66, z), (x[1], min(low + 1.0, top), z + 0.02)))


def _fronts(
    piece: Piece, rng: np.random.Generator, look: Look, x: _Range, y: _Range, z: float
) -> None:
    """Add doors or drawers in front of a cupboard at depth `z`, sometimes with a sunk panel."""
    columns = max(1, round((x[1] - x[0]) / rng.uniform(0.35, 0.6)))
    rows = 1 if y[1] - y[0] > 1.2 or rng.random() < 0.6 else int(rng.integers(2, 4))
    dark = (look[1][0] * 0.3, look[1][1] * 0.3, look[1][2] * 0.3)
    panel, metal = rng.random() < 0.5, rng.random() < 0.7
    piece.add(("paint", dark), box((x[0], y[0], z), (x[1], y[1], z + 0.004)))
    wide, tall = (x[1] - x[0]) / columns, (y[1] - y[0]) / rows
    for i in range(columns):
        for j in range(rows):
            a, b = x[0] + i * wide + 0.003, x[0] + (i + 1) * wide - 0.003
            c, d = y[0] + j * tall + 0.003, y[0] + (j + 1) * tall - 0.003
            piece.add(look, box((a, c, z), (b, d, z + 0.02)))
            if panel and b - a > 0.2 and d - c > 0.2:
                rim, sunk = z + 0.0204, z + 0.021
                piece.add(("paint", dark), box((a + 0.06, c + 0.06, z), (b - 0.06, d - 0.06, rim)))
                piece.add(look, box((a + 0.066, c + 0.066, z), (b - 0.066, d - 0.066, sunk)))
            if metal:
                piece.add(METAL, box((b - 0.05, d - 0.2, z), (b - 0.035, d - 0.06, z + 0.045)))


def rack(rng: np.random.Generator, palette: Palette, height: float) -> Piece:
    """Return shelves up to `height`, full of goods or books in rows."""
    piece = Piece(rng.uniform(0.8, 3.2), rng.uniform(0.28, 0.6), height)
    half, deep = piece.width / 2, piece.depth
    look = METAL if rng.random() < 0.3 else hard(rng, palette)
    for x in np.linspace(
        -half, half - 0.03, max(2, round(piece.width / rng.uniform(0.6, 1.2)) + 1)
    ):
        full = rng.random() < 0.7
        near = 0.0 if full else deep - 0.03
        piece.add(look, box((x, 0, near), (x + 0.03, height, deep)))
    if rng.random() < 0.6:
        piece.add(look, box((-half, 0, 0), (half, height, 0.012)))
    rows = max(3, round(height / rng.uniform(0.26, 0.5)))
    gap = (height - 0.08) / rows
    books = rng.random() < 0.45
    for j in range(rows + 1):
        y = 0.05 + j * gap
        piece.add(look, box((-half, y, 0), (half, y + 0.02, deep)))
        if j < rows and rng.random() < 0.92:
            _row(piece, rng, palette, y + 0.02, gap - 0.04, books=books)
    return piece


def _row(
    piece: Piece, rng: np.random.Generator, palette: Palette, y: float, room: float, *, books: bool
) -> None:
    """Fill one shelf with books, or with groups of equal goods."""
    x, end, colours = -piece.width / 2 + 0.03, piece.width / 2 - 0.03, palette.accents
    while x < end - 0.02:
        wide = rng.uniform(0.03, 0.06) if books else rng.uniform(0.06, 0.3)
        tall, deep = room * rng.uniform(0.5, 0.97), piece.depth * rng.uniform(0.6, 0.98)
        colour = pick(rng, colours if rng.random() < 0.7 else palette.furniture)
        look: Look = ("gloss" if rng.random() < 0.3 else "paint", colour)
        round_ = not books and wide < 0.14 and rng.random() < 0.5
        for _ in range(1 if books else int(rng.integers(1, 6))):
            if x + wide > end:
                return
            middle = x + wide / 2
            solid = box((x, y, 0.02), (x + wide - 0.004, y + tall, deep))
            if round_:
                profile = [
                    (wide * 0.48, 0),
                    (wide * 0.48, tall * 0.8),
                    (wide * 0.3, tall),
                    (0, tall),
                ]
                solid = lathe((middle, y, deep - wide / 2), profile, 10)
            piece.add(look, solid)
            x += wide
        x += rng.uniform(0.2, 0.5) * (rng.random() < 0.08)


def board(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a white, black or cork board or a large plain screen, to hang up."""
    width, height, rim = rng.uniform(0.8, 3.0), rng.uniform(0.6, 1.3), rng.uniform(0.01, 0.05)
    piece = Piece(width, height, height)
    kind, half = rng.random(), width / 2
    colour = linear(rng.random(), rng.uniform(0, 0.04), rng.uniform(0.85, 1.0))
    if kind > 0.7:
        colour = linear(rng.uniform(0.05, 0.4), rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.6))
    frame = METAL if rng.random() < 0.6 else hard(rng, palette)
    piece.add(frame, box((-half, 0, 0), (half, height, 0.02)))
    face = ("gloss" if kind < 0.5 else "paint", colour)
    piece.add(face, box((-half + rim, rim, 0), (half - rim, height - rim, 0.022)))
    for _ in range(int(rng.uniform(0, 12)) if rng.random() < 0.6 else 0):
        a, b = rng.uniform(0.02, 0.25), rng.uniform(0.005, 0.15)
        x, y = rng.uniform(-half + a, half - a), rng.uniform(rim + b, height - rim - b)
        note = PAPER if kind > 0.7 else pick(rng, palette.accents)
        piece.add(("paint", note), box((x - a / 2, y - b / 2, 0), (x + a / 2, y + b / 2, 0.0235)))
    return piece


def seat_rows(rng: np.random.Generator, table: Piece | None, seat: Piece) -> Piece:
    """Return rows of equal chairs, with equal tables in front of them if `table` is given."""
    columns, rows = int(rng.integers(2, 5)), int(rng.integers(1, 4))
    wide = max(seat.width + rng.uniform(0.05, 0.3), table.width / 2 if table else 0.0)
    deep = seat.depth + rng.uniform(0.25, 0.6) + (table.depth if table else 0.0)
    whole = Piece(columns * wide, rows * deep, max(seat.height, table.height if table else 0.0))
    for j in range(rows):
        for i in range(columns):
            x, z = (i + 0.5) * wide - whole.width / 2, j * deep
            if rng.random() < 0.92:
                whole.put(seat, placement(x, z + rng.uniform(0, 0.15), rng.normal(0, 0.2)))
            if table and i % 2 == 0 and i + 1 < columns:
                whole.put(table, placement(x + wide / 2, z + seat.depth * 0.8, rng.normal(0, 0.02)))
    return whole


def papers(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return sheets, magazines and cloths lying flat on the floor."""
    piece = Piece(rng.uniform(0.4, 1.2), rng.uniform(0.4, 1.0), 0.03)
    for _ in range(int(rng.integers(2, 10))):
        x = rng.uniform(-0.4, 0.4) * piece.width
        z = rng.uniform(0.1, 0.9) * piece.depth
        half = rng.uniform(0.07, 0.16, 2)
        sheet = box((-half[0], 0.001, -half[1]), (half[0], rng.uniform(0.003, 0.03), half[1]))
        colour = PAPER if rng.random() < 0.5 else pick(rng, palette.accents)
        piece.add(("paint", colour), sheet.moved(placement(x, z, rng.uniform(0, np.pi))))
    return piece
