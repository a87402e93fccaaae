"""Furniture built from boxes, cylinders and rounded shapes.

A piece stands with its back at z = 0 and its middle at x = 0, y up, z into the room, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from plan2scene_workshop.rendering.geometry import (
    Array,
    Colour,
    Solid,
    box,
    cylinder,
    lathe,
    superquadric,
)
from plan2scene_workshop.rendering.palette import FABRICS, WOODS, Palette, pick

WHITE: Colour = (0.82, 0.82, 0.8)
BLACK: Colour = (0.02, 0.02, 0.022)
Look = tuple[str, Colour]  #: material and colour
METAL: Look = ("metal", WHITE)
GLOSS_WHITE: Look = ("gloss", WHITE)
GLOSS_BLACK: Look = ("gloss", BLACK)


@dataclass
class Piece:
    """A piece of furniture: its footprint and height in metres, and its parts."""

    width: float
    depth: float
    height: float
    parts: list[tuple[str, Solid, Colour]] = field(default_factory=list)

    def add(self, look: Look, *solids: Solid) -> None:
        """Add solids of one material and colour."""
        self.parts += [(look[0], solid, look[1]) for solid in solids]

    def put(self, other: Piece, matrix: Array) -> None:
        """Add the parts of another piece under a transform of this piece's frame."""
        self.parts += [(m, solid.moved(matrix), colour) for m, solid, colour in other.parts]


Maker = Callable[[np.random.Generator, Palette], Piece]


def hard(rng: np.random.Generator, palette: Palette) -> Look:
    """Return a look for joinery: wood, lacquer or gloss."""
    colour = pick(rng, palette.furniture)
    if rng.random() < 0.45:
        return str(rng.choice(WOODS)), colour
    return ("paint" if rng.random() < 0.6 else "gloss"), colour


def soft(rng: np.random.Generator, palette: Palette) -> Look:
    """Return a look for upholstery."""
    colour = pick(rng, palette.fabrics if rng.random() < 0.85 else palette.accents)
    return (str(rng.choice(FABRICS)) if rng.random() < 0.45 else "fabric"), colour


def cushion(centre: Sequence[float], size: Sequence[float], round_: float = 0.35) -> Solid:
    """Return a box with rounded edges of the given full size."""
    radii = [side / 2 for side in size]
    return superquadric(centre, radii, roundness=(round_, round_), steps=(8, 16))


def legs(piece: Piece, look: Look, top: float, inset: float, thick: float) -> None:
    """Add four legs under a top at height `top`."""
    half, depth = piece.width / 2 - inset, piece.depth - inset
    for x in (-half, half - thick):
        for z in (inset, depth - thick):
            piece.add(look, box((x, 0, z), (x + thick, top, z + thick)))


def cabinet(
    rng: np.random.Generator,
    palette: Palette,
    size: tuple[float, float, float],
    look: Look | None = None,
) -> Piece:
    """Return a box with doors or drawers, gaps between them, and handles."""
    width, depth, height = size
    look = look or hard(rng, palette)
    piece = Piece(width, depth, height)
    piece.add(look, box((-width / 2, 0, 0), (width / 2, height, depth - 0.02)))
    columns = max(1, round(width / rng.uniform(0.4, 0.6)))
    rows = 1 if height > 1.2 or rng.random() < 0.5 else int(rng.integers(2, 4))
    front = look if rng.random() < 0.75 else hard(rng, palette)
    metal = rng.random() < 0.7
    for i in range(columns):
        for j in range(rows):
            x0 = -width / 2 + i * width / columns + 0.004
            x1 = -width / 2 + (i + 1) * width / columns - 0.004
            y0 = 0.06 + j * (height - 0.08) / rows + 0.004
            y1 = 0.06 + (j + 1) * (height - 0.08) / rows - 0.004
            piece.add(front, box((x0, y0, depth - 0.02), (x1, y1, depth)))
            if metal and rows > 1:
                y = (y0 + y1) / 2
                piece.add(METAL, box((x0 + 0.12, y, depth), (x1 - 0.12, y + 0.012, depth + 0.025)))
            elif metal:
                x, y = (x1 - 0.05 if i % 2 == 0 else x0 + 0.04), min(height * 0.5, 1.05)
                piece.add(METAL, box((x, y, depth), (x + 0.012, y + 0.14, depth + 0.025)))
    return piece


def table_lamp(piece: Piece, rng: np.random.Generator, palette: Palette, y: float) -> None:
    """Put a table lamp (not shining) on the middle of a piece."""
    z, foot = piece.depth / 2, rng.uniform(0.18, 0.3)
    base = lathe((0, y, z), [(0, 0), (0.07, 0), (0.05, foot * 0.4), (0.015, foot)], 12)
    shade = lathe((0, y + foot, z), [(0.15, -0.04), (0.09, 0.16)], 14)
    piece.add(("gloss", pick(rng, palette.accents)), base)
    piece.add(("fabric", (0.75, 0.7, 0.6)), shade)


def scatter(piece: Piece, rng: np.random.Generator, palette: Palette, y: float, count: int) -> None:
    """Put vases, books, boxes and bowls on a top at height `y`."""
    for k in range(count):
        x = -piece.width / 2 + piece.width * (k + 0.5) / count + rng.uniform(-0.03, 0.03)
        z, colour = piece.depth * rng.uniform(0.4, 0.6), pick(rng, palette.accents)
        kind = int(rng.integers(4))
        h = rng.uniform(0.08, 0.32)
        if kind == 0:
            profile = [(0, 0), (0.05, 0), (0.08, h * 0.5), (0.03, h * 0.85), (0.04, h)]
            piece.add(("gloss", colour), lathe((x, y, z), profile, 14))
        elif kind == 1:
            for level in range(int(rng.integers(1, 4))):
                low = y + 0.03 * level
                piece.add(
                    ("paint", pick(rng, palette.accents)),
                    box((x - 0.1, low, z - 0.07), (x + 0.1, low + 0.028, z + 0.07)),
                )
        elif kind == 2:
            piece.add(("paint", colour), box((x - 0.08, y, z - 0.05), (x + 0.08, y + h, z + 0.05)))
        else:
            piece.add(("gloss", colour), superquadric((x, y + 0.06, z), (0.1, 0.06, 0.1)))


def table(rng: np.random.Generator, palette: Palette, size: tuple[float, float, float]) -> Piece:
    """Return a table of size (width, depth, height) on four legs or one foot."""
    piece = Piece(*size)
    look = hard(rng, palette)
    leg = look if rng.random() < 0.5 else METAL
    top, half = piece.height, piece.width / 2
    if rng.random() < 0.25:
        radius = min(piece.width, piece.depth) / 2
        middle = (0.0, top - 0.03, piece.depth / 2)
        piece.add(look, cylinder(middle, radius, 0.03, 28))
        piece.add(leg, cylinder((0, 0, piece.depth / 2), 0.04, top - 0.03))
        piece.add(leg, cylinder((0, 0, piece.depth / 2), radius * 0.55, 0.025, 20))
        return piece
    thick = rng.uniform(0.02, 0.05)
    piece.add(look, box((-half, top - thick, 0), (half, top, piece.depth)))
    legs(piece, leg, top - thick, rng.uniform(0.0, 0.08), rng.uniform(0.03, 0.07))
    return piece


def chair(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a chair."""
    piece = Piece(rng.uniform(0.4, 0.48), rng.uniform(0.42, 0.5), rng.uniform(0.78, 0.98))
    look = hard(rng, palette)
    seat = look if rng.random() < 0.5 else soft(rng, palette)
    half, depth = piece.width / 2, piece.depth
    legs(piece, look if rng.random() < 0.6 else METAL, 0.43, 0.02, 0.032)
    piece.add(seat, cushion((0, 0.45, depth / 2), (piece.width, 0.06, depth), 0.25))
    back = rng.uniform(0.15, 0.4)
    piece.add(
        seat, cushion((0, piece.height - back / 2, 0.025), (piece.width * 0.95, back, 0.04), 0.25)
    )
    for x in (-half + 0.02, half - 0.052):
        piece.add(look, box((x, 0.43, 0.01), (x + 0.032, piece.height - 0.04, 0.04)))
    return piece
