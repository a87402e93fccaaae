"""Beds under a patterned cover; from near, their tops look like floors."""

from __future__ import annotations

import colorsys
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from plan2scene_workshop.rendering.geometry import box, placement
from plan2scene_workshop.rendering.palette import Palette, linear
from plan2scene_workshop.rendering.pieces import Look, Piece, cushion, hard, soft


def patchwork(rng: np.random.Generator, size: int = 192) -> NDArray[np.uint8]:
    """Return the tile of a quilt, (size, size, 3) uint8 sRGB, with patches, some with motifs.

    It repeats in both directions.
    """
    count = int(rng.integers(3, 8))
    hue, spread = rng.random(), rng.choice([0.06, 0.15, 0.5])
    image = np.zeros((size, size, 3))
    edges = np.linspace(0, size, count + 1).astype(int)
    for top, bottom in pairwise(edges):
        for left, right in pairwise(edges):
            ground = _colour(rng, hue, spread)
            patch = np.tile(ground, (bottom - top, right - left, 1))
            kind = rng.random()
            if kind < 0.35:
                blobs = rng.normal(0, 1, patch.shape[:2])
                blobs = cv2.GaussianBlur(blobs, (0, 0), float(rng.uniform(1.0, 3.5)))
                patch[blobs > 0.5 * blobs.std()] = _colour(rng, hue, spread)
            elif kind < 0.5:
                patch[:: int(rng.integers(2, 7))] = _colour(rng, hue, spread)
            image[top:bottom, left:right] = patch
            image[top, left:right] = image[top:bottom, left] = 0.7 * ground
    image += rng.normal(0, 4, (size, size, 1))
    return np.clip(image, 4, 250).astype(np.uint8)


def _colour(rng: np.random.Generator, hue: float, spread: float) -> NDArray[np.float64]:
    value, saturation = rng.uniform(0.3, 0.97), rng.uniform(0.0, 0.8)
    return 255 * np.array(colorsys.hsv_to_rgb((hue + rng.normal(0, spread)) % 1, saturation, value))


def covered_bed(rng: np.random.Generator, palette: Palette, cover: Look) -> Piece:
    """Return a bed or a mattress under a cover that hangs down its sides."""
    wide = float(rng.choice([0.9, 1.2, 1.4, 1.6, 1.8, 2.0]))
    level = float(rng.uniform(0.35, 0.72))
    board = rng.random() < 0.6
    piece = Piece(wide + 0.1, float(rng.uniform(1.95, 2.15)), level)
    long, half = piece.depth, wide / 2
    if board:
        piece.height = float(rng.uniform(0.75, 1.35))
        piece.add(hard(rng, palette), box((-half, 0, 0), (half, piece.height, 0.07)))
    hang = float(rng.choice([0.02, rng.uniform(0.02, level * 0.7)]))
    frame = hard(rng, palette) if rng.random() < 0.5 else soft(rng, palette)
    piece.add(frame, box((-half + 0.05, 0.0, 0.07), (half - 0.05, level - 0.1, long - 0.06)))
    middle, size = (0.0, (level + hang) / 2, long / 2 + 0.03), (wide + 0.08, level - hang, long)
    piece.add(cover, cushion(middle, size, float(rng.uniform(0.05, 0.2))))
    sheet: Look = ("fabric", linear(rng.random(), rng.uniform(0, 0.15), rng.uniform(0.75, 0.95)))
    for k in range(1 if wide < 1.3 else 2):
        x = (k - (0 if wide < 1.3 else 0.5)) * wide / 2
        look = cover if rng.random() < 0.5 else sheet
        piece.add(look, cushion((x, level + 0.06, 0.35), (0.62, 0.2, 0.42), 0.55))
    for _ in range(int(rng.integers(0, 4))):  # cushions and clothes on the bed
        low, deep = float(rng.uniform(0.03, 0.18)), float(rng.uniform(0.2, 0.7))
        turn = placement(
            rng.uniform(-0.35, 0.35) * wide, rng.uniform(0.4, 0.9) * long, rng.normal(0, 1), level
        )
        thing = cushion((0, low / 2, 0), (rng.uniform(0.2, 0.6), low, deep), rng.uniform(0.2, 0.8))
        piece.add(soft(rng, palette), thing.moved(turn))
    return piece
