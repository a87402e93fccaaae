"""Colours of homes: palettes (sRGB) and how they vary."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

Palette = Sequence[tuple[str, float]]  #: (hex colour, weight)

WOODS: Palette = (
    ("#c8a472", 3.0),  # oak, oiled
    ("#b98f5e", 3.0),  # oak, older
    ("#d8bd94", 2.0),  # ash, pale oak
    ("#dcc9ab", 1.0),  # whitewashed oak
    ("#a9774a", 2.0),  # warm beech, teak
    ("#8a5a38", 2.0),  # chestnut
    ("#6b4630", 2.2),  # walnut
    ("#4b3325", 1.3),  # wenge, dark stain
    ("#9a6240", 1.4),  # cherry, mahogany
    ("#a59a8b", 1.2),  # grey oak
    ("#857b70", 1.0),  # smoked grey
    ("#5d5650", 0.8),  # charcoal oak
    ("#d9b077", 1.2),  # pine, honey
    ("#c07f4a", 0.8),  # orange varnish
)
STONES: Palette = (
    ("#e6e2da", 3.0),
    ("#f0efec", 3.0),
    ("#d8cdbb", 2.0),
    ("#c9b79c", 1.5),
    ("#b7b3ad", 2.0),
    ("#8f8d8a", 1.5),
    ("#6b6a6a", 1.4),
    ("#45464a", 1.0),
    ("#242528", 0.5),
    ("#7a5f45", 0.5),
    ("#a98f75", 0.8),
    ("#b0714f", 0.6),  # terracotta
    ("#c3ccc9", 0.6),
    ("#9fb0b5", 0.4),
)
GLAZES: Palette = (
    ("#f5f5f2", 5.0),
    ("#ece7dc", 2.0),
    ("#dfe5e4", 1.0),
    ("#c9d6d6", 0.8),
    ("#9db8ba", 0.6),
    ("#6f94a0", 0.4),
    ("#3f6170", 0.3),
    ("#a9bba2", 0.5),
    ("#6d8a72", 0.3),
    ("#d9c7b8", 0.7),
    ("#c99f86", 0.3),
    ("#3a3b3f", 0.5),
    ("#8c8f92", 0.8),
)
CARPETS: Palette = (
    ("#cdc2b1", 3.0),
    ("#b5a896", 3.0),
    ("#dbd5c9", 2.0),
    ("#9b8f80", 2.0),
    ("#8d8b88", 2.0),
    ("#b3b2af", 1.5),
    ("#6c6660", 1.5),
    ("#4d4a4a", 0.8),
    ("#8a6a4f", 0.8),
    ("#6f7f8d", 0.8),
    ("#44566b", 0.6),
    ("#2f3e58", 0.4),
    ("#6a73a3", 0.25),
    ("#4f7f86", 0.3),
    ("#7d2f38", 0.3),
    ("#7f8a6c", 0.4),
    ("#8c4d44", 0.4),
    ("#6d3a3d", 0.3),
)
PAINTS: Palette = (
    ("#f4f2ec", 6.0),
    ("#f8f7f4", 5.0),
    ("#eee8dc", 4.0),
    ("#e8dfcd", 2.5),
    ("#e3e1dd", 2.5),
    ("#d2cfc9", 2.0),
    ("#b9b6b1", 1.0),
    ("#e9dfc0", 1.2),
    ("#ddd3c3", 1.5),
    ("#d9e0dc", 0.8),
    ("#c4d0c6", 0.7),
    ("#c3d1d8", 0.8),
    ("#e6d3cb", 0.6),
)
ACCENTS: Palette = (
    ("#8aa0ab", 1.2),
    ("#4f6a7c", 1.0),
    ("#2f4656", 0.8),
    ("#8f9d86", 1.2),
    ("#5d705f", 1.0),
    ("#b98b74", 0.8),
    ("#a4604b", 0.5),
    ("#c9ab6a", 0.5),
    ("#8d7a8b", 0.4),
    ("#6a6661", 1.0),
    ("#46464a", 0.6),
    ("#c5b3a0", 1.2),
    ("#a9a49c", 1.0),
)
GROUTS: Palette = (
    ("#d9d6d0", 3.0),
    ("#bdb8b0", 2.5),
    ("#8f8b86", 2.0),
    ("#efeeea", 2.0),
    ("#5b5957", 1.0),
    ("#a39683", 1.0),
)


def parse(colour: str) -> np.ndarray:
    """Return '#rrggbb' as (3,) float32 sRGB in [0, 1]."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=np.float32) / 255


def vary(
    rng: np.random.Generator, rgb: np.ndarray, lightness: float = 3.0, chroma: float = 2.0
) -> np.ndarray:
    """Return an sRGB colour moved by normal steps in CIELAB (standard deviations)."""
    lab = cv2.cvtColor(rgb.reshape(1, 1, 3).astype(np.float32), cv2.COLOR_RGB2LAB)[0, 0]
    lab = lab + rng.normal(0, (lightness, chroma, chroma)).astype(np.float32)
    lab[0] = np.clip(lab[0], 8, 98)
    moved = cv2.cvtColor(lab.reshape(1, 1, 3).astype(np.float32), cv2.COLOR_LAB2RGB)[0, 0]
    return np.clip(moved, 0.02, 0.98).astype(np.float32)


def pick(
    rng: np.random.Generator,
    palette: Palette,
    *,
    lightness: float = 4.0,
    chroma: float = 2.0,
) -> np.ndarray:
    """Return a colour of a palette by weight, varied: (3,) float32 sRGB in [0, 1]."""
    weights = np.array([weight for _, weight in palette])
    index = int(rng.choice(len(palette), p=weights / weights.sum()))
    return vary(rng, parse(palette[index][0]), lightness, chroma)


def pick_uint8(rng: np.random.Generator, palette: Palette) -> tuple[int, int, int]:
    """Return a varied colour of a palette as (r, g, b), 0-255 sRGB."""
    r, g, b = np.round(pick(rng, palette, lightness=2.5, chroma=1.2) * 255).astype(int).tolist()
    return r, g, b


def mix(a: np.ndarray, b: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return a (1 - t) + b t; `t` (h, w), colours (3,) or (h, w, 3)."""
    return a + (b - a) * t[..., None]


def shade(image: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Return an sRGB image (h, w, 3) or colour (3,) made lighter or darker by exp(amount)."""
    return image * np.exp(amount)[..., None]


def to_uint8(image: np.ndarray) -> np.ndarray:
    """Return float sRGB in [0, 1] as (h, w, 3) uint8."""
    return np.clip(image * 255.0 + 0.5, 0, 255).astype(np.uint8)
