"""Colours of homes: palettes (sRGB) and how they vary."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

Palette = Sequence[tuple[str, float]]  #: (hex colour, weight)


def _read_palettes() -> dict[str, Palette]:
    """Return the palettes of palettes.csv by name, in the file's order."""
    palettes: dict[str, list[tuple[str, float]]] = {}
    text = Path(__file__).with_name("palettes.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(text.splitlines()):
        palettes.setdefault(row["palette"], []).append((row["colour"], float(row["weight"])))
    return {name: tuple(colours) for name, colours in palettes.items()}


_PALETTES = _read_palettes()
WOODS = _PALETTES["woods"]
STONES = _PALETTES["stones"]
GLAZES = _PALETTES["glazes"]
CARPETS = _PALETTES["carpets"]
PAINTS = _PALETTES["paints"]
ACCENTS = _PALETTES["accents"]
GROUTS = _PALETTES["grouts"]


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
    rng: np.random.Generator, palette: Palette, *, lightness: float = 4.0, chroma: float = 2.0
) -> np.ndarray:
    """Return a colour of a palette by weight, varied: (3,) float32 sRGB in [0, 1]."""
    weights = np.array([weight for _, weight in palette])
    index = int(rng.choice(len(palette), p=weights / weights.sum()))
    return vary(rng, parse(palette[index][0]), lightness, chroma)


def mix(a: np.ndarray, b: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return a (1 - t) + b t; `t` (h, w), colours (3,) or (h, w, 3)."""
    return a + (b - a) * t[..., None]


def shade(image: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Return an sRGB image (h, w, 3) or colour (3,) made lighter or darker by exp(amount)."""
    return image * np.exp(amount)[..., None]


def to_uint8(image: np.ndarray) -> np.ndarray:
    """Return float sRGB in [0, 1] as (h, w, 3) uint8."""
    return np.clip(image * 255.0 + 0.5, 0, 255).astype(np.uint8)
