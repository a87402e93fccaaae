"""Wood: planks, strip and basket parquet, herringbone, plain boards."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from plan2scene.materials import bonds, palettes, periodic_noise
from plan2scene.materials.bonds import Layout
from plan2scene.materials.material import Look


def make(rng: Generator, kind: str, size: int, base: np.ndarray | None) -> Look:
    """Return (albedo float (size, size, 3), metres per tile, roughness) of a kind of wood."""
    tone = palettes.pick(rng, palettes.WOODS) if base is None else base
    plan = _layout(rng, kind, size)
    grain = _grain(rng, size, plan.size_m, vein=float(rng.uniform(0.006, 0.025)))
    if kind == "plain":
        value: np.ndarray = grain.T if rng.random() < 0.5 else grain
    else:
        value = plan.lookup(rng, grain)
    contrast = float(rng.uniform(0.02, 0.1))
    amount: np.ndarray = value * np.float32(contrast)
    if kind != "plain":
        amount = amount + plan.draw(rng, float(rng.uniform(0.015, 0.10)))
    amount = amount + periodic_noise.spectral_noise(rng, size, 3.0, high=6) * np.float32(
        rng.uniform(0.0, 0.035)
    )
    # Dark wood is also more saturated: mix in the image multiplied by the tone.
    darkness = -amount * np.float32(rng.uniform(0.6, 1.3))
    image = palettes.shade(tone, amount)
    image = palettes.mix(image, image * (tone / tone.max()), np.clip(darkness, -0.3, 0.8))
    if kind != "plain":
        warm = plan.draw(rng, float(rng.uniform(0.0, 0.02)))
        image = image * (1 + warm[..., None] * np.array([1.0, 0.2, -1.2], np.float32))
        gap = float(rng.choice([0.0008, 0.0015, 0.0025, 0.005], p=[0.35, 0.35, 0.2, 0.1]))
        dark = tone * np.float32(rng.uniform(0.15, 0.55))
        image = palettes.mix(image, dark, plan.joint(gap) * np.float32(rng.uniform(0.5, 1.0)))
    if rng.random() < 0.3:
        worn = np.clip(periodic_noise.spectral_noise(rng, size, 2.5, high=20) - 0.6, 0, 1)
        image = palettes.mix(image, image * 0.75 + 0.18, worn * np.float32(rng.uniform(0.1, 0.5)))
    return image, plan.size_m, float(rng.uniform(0.22, 0.65))


def _layout(rng: Generator, kind: str, size: int) -> Layout:
    """Return how the boards lie, in sizes that shops sell."""
    if kind in ("planks", "plain"):
        width = float(rng.uniform(0.07, 0.2))
        rows = int(rng.integers(4, 9)) if width > 0.1 else int(rng.integers(6, 13))
        columns = 1 if rows * width < 1.3 or rng.random() < 0.5 else 2
        offsets: np.ndarray = rng.uniform(0, 1, rows)
        if rng.random() < 0.3 and (rows % 3 == 0 or rows % 2 == 0):  # a regular bond
            offsets = np.arange(rows) / (3 if rows % 3 == 0 else 2) + 0.37
        upright = bool(rng.random() < 0.5)
        return bonds.bond(size, columns, rows, rows * width, offsets, upright=upright)
    if kind == "strip":
        width = float(rng.uniform(0.045, 0.075))
        rows, columns = int(rng.integers(8, 15)), int(rng.integers(1, 4))
        upright = bool(rng.random() < 0.5)
        offsets = rng.uniform(0, 1, rows)
        return bonds.bond(size, columns, rows, rows * width, offsets, upright=upright)
    if kind == "basket":
        blocks, strips = int(rng.choice([2, 4, 6], p=[0.35, 0.45, 0.2])), int(rng.integers(4, 8))
        width = float(rng.uniform(0.02, 0.07)) if blocks < 6 else float(rng.uniform(0.02, 0.04))
        return bonds.basket(size, blocks, strips, blocks * strips * width)
    ratio = int(rng.integers(4, 8))
    width = float(rng.uniform(0.05, 0.1))
    diagonal = bool(rng.random() < 0.7)
    side = ratio * np.sqrt(2.0) if diagonal else 2.0 * ratio
    return bonds.herringbone(size, ratio, float(side * width), diagonal=diagonal)


def _grain(rng: Generator, size: int, size_m: float, vein: float) -> np.ndarray:
    """Return periodic wood grain along x: (size, size) float32, mean about 0, deviation about 1.

    Growth rings are the level lines of a smooth elongated field. Around its extrema they look like
    the arches (cathedrals) of flat-sawn boards, elsewhere like straight grain.
    """
    across = size_m / 0.12  # features of a board's width
    field = periodic_noise.spectral_noise(
        rng, size, 3.2, low=across * 0.5, high=across * 3, stretch=(9, 1)
    )
    rings = float(rng.uniform(0.06, 0.14)) / vein
    phase = field * np.float32(rings) + periodic_noise.spectral_noise(
        rng, size, 2.0, low=4, stretch=(6, 1)
    ) * np.float32(0.5)
    wave = np.sin(phase)
    wave = np.sign(wave) * np.abs(wave) ** np.float32(rng.uniform(0.6, 1.6))
    if rng.random() < 0.3:
        wave = wave * np.clip(
            periodic_noise.spectral_noise(rng, size, 3.0, stretch=(4, 1)) + 0.5, 0, 1
        )
    stretch = float(rng.uniform(10, 30))
    fibre = periodic_noise.spectral_noise(rng, size, 1.0, low=6, stretch=(stretch, 1))
    pores = np.clip(
        periodic_noise.spectral_noise(rng, size, 0.0, low=30, stretch=(14, 1)) - 1.1, 0, 3
    )
    value = wave * np.float32(rng.uniform(0.1, 0.8)) + fibre * np.float32(rng.uniform(0.5, 1.0))
    value -= pores * np.float32(rng.uniform(0.0, 1.2))
    if rng.random() < 0.2:
        knots, _ = periodic_noise.scatter(
            rng, size, int(rng.integers(2, 7)), (1.5, 4.0), corners=(8, 12), elongation=1.3
        )
        value -= periodic_noise.blur(knots, 1.2) * np.float32(rng.uniform(2.0, 5.0))
    return value.astype(np.float32)
