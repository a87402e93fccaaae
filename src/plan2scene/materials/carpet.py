"""Carpet: loop pile, cut pile, flecked and patterned."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from plan2scene.materials import palettes, periodic_noise
from plan2scene.materials.material import Look


def make(rng: Generator, kind: str, size: int, base: np.ndarray | None) -> Look:
    """Return (albedo float (size, size, 3), metres per tile, roughness) of a kind of carpet."""
    tone = palettes.pick(rng, palettes.CARPETS, chroma=1.5) if base is None else base
    size_m = float(rng.uniform(0.3, 1.0))
    tones = np.broadcast_to(tone, (size, size, 3))
    if kind == "patterned":
        tones = _pattern(rng, size, tone)
    elif kind == "fleck":
        tones = _flecks(rng, size, tone)
    pile = _loops(rng, size, size_m) if kind == "loop" else _cut(rng, size)
    if kind in ("patterned", "fleck") and rng.random() < 0.5:
        pile = _loops(rng, size, size_m)
    image = palettes.shade(tones, pile * np.float32(rng.uniform(0.04, 0.14)))
    brushed = periodic_noise.spectral_noise(rng, size, 2.2, low=1.5, high=14)
    image = palettes.shade(image, brushed * np.float32(rng.uniform(0.0, 0.045)))
    return image, size_m, float(rng.uniform(0.88, 1.0))


def _cut(rng: Generator, size: int) -> np.ndarray:
    """Return the tufts of a cut pile: band-limited noise with dark gaps."""
    centre = float(rng.uniform(25, 90))
    tufts = periodic_noise.spectral_noise(rng, size, 0.4, low=centre * 0.5, high=centre * 1.6)
    tufts = np.where(tufts < 0, tufts * np.float32(rng.uniform(1.0, 1.6)), tufts)
    fine = periodic_noise.spectral_noise(rng, size, 0.0, low=60)
    return tufts * 0.8 + fine * np.float32(rng.uniform(0.2, 0.6))


def _loops(rng: Generator, size: int, size_m: float) -> np.ndarray:
    """Return rows of loops: bumps on a jittered lattice, about 4-11 mm apart."""
    pitch = float(rng.uniform(0.004, 0.011))
    count = int(np.clip(round(size_m / pitch), 20, size // 4))
    columns = max(8, round(count * float(rng.uniform(0.5, 1.0))))
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    jitter = np.float32(rng.uniform(0.3, 1.2))
    dx = periodic_noise.spectral_noise(rng, size, 1.0, low=count * 0.3, high=count) * jitter
    dy = periodic_noise.spectral_noise(rng, size, 1.0, low=count * 0.3, high=count) * jitter * 0.5
    x = axis[None, :] * columns * 2 * np.pi + dx
    y = axis[:, None] * count * 2 * np.pi + dy
    row = np.floor(axis[:, None] * count)
    loops = np.cos(x + np.pi * row * (1 if count % 2 == 0 else 0)) * 0.5 + np.cos(y) * 0.8
    loops = loops + periodic_noise.spectral_noise(rng, size, 0.2, low=30) * np.float32(
        rng.uniform(0.3, 0.9)
    )
    return np.ascontiguousarray(loops.T if rng.random() < 0.5 else loops).astype(np.float32)


def _flecks(rng: Generator, size: int, tone: np.ndarray) -> np.ndarray:
    """Return yarns of a few related colours in random dots (berber, tweed)."""
    image = np.broadcast_to(tone, (size, size, 3))
    for _ in range(int(rng.integers(1, 4))):
        scale = float(rng.uniform(20, 80))
        field = periodic_noise.spectral_noise(rng, size, 0.3, low=scale * 0.5, high=scale * 1.5)
        other = palettes.vary(rng, tone, float(rng.uniform(6, 16)), float(rng.uniform(1, 5)))
        limit = np.float32(rng.uniform(0.8, 2.0))
        image = palettes.mix(image, other, np.clip((field - limit) * 3 + 0.5, 0, 1))
    return image


def _pattern(rng: Generator, size: int, tone: np.ndarray) -> np.ndarray:
    """Return a woven pattern in two or three colours."""
    step = float(rng.choice([5.0, 10.0, 18.0], p=[0.4, 0.4, 0.2]))
    second = palettes.vary(rng, tone, step, 3)
    if rng.random() < 0.25:
        second = palettes.pick(rng, palettes.CARPETS)
    axis = (np.arange(size, dtype=np.float32) + 0.5) / size
    wobble = periodic_noise.spectral_noise(rng, size, 1.2, low=20) * np.float32(0.06)
    count = int(rng.choice([3, 4, 6, 8, 12]))
    x, y = axis[None, :] * count + wobble, axis[:, None] * count + wobble.T
    style = str(rng.choice(["stripes", "checks", "diamonds", "dots", "trellis", "pinstripe"]))
    fx, fy = np.mod(x, 1), np.mod(y, 1)
    if style == "stripes":
        field = np.abs(fx - 0.5) - float(rng.uniform(0.12, 0.38))
    elif style == "pinstripe":
        field = 0.44 - np.abs(fx - 0.5)
    elif style == "checks":
        field = (np.abs(fx - 0.5) - 0.25) * (np.abs(fy - 0.5) - 0.25) * 6
    elif style == "diamonds":
        field = np.abs(fx - 0.5) + np.abs(fy - 0.5) - float(rng.uniform(0.2, 0.5))
    elif style == "dots":
        field = np.hypot(fx - 0.5, fy - 0.5) - float(rng.uniform(0.12, 0.35))
    else:
        field = np.abs(np.abs(fx - 0.5) + np.abs(fy - 0.5) - 0.5) - float(rng.uniform(0.04, 0.12))
    sharp = size / count / 2.0
    field = np.broadcast_to(field, (size, size)).astype(np.float32)
    cover = np.clip(0.5 - field * np.float32(sharp), 0, 1)
    image = palettes.mix(tone, second, cover)
    if rng.random() < 0.35:
        third = palettes.vary(rng, second, 10, 4)
        image = palettes.mix(image, third, np.clip(0.5 - (np.abs(field) - 0.04) * sharp, 0, 1))
    return image
