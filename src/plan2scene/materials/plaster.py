"""Plastered surfaces: paint, rough plaster, concrete, wallpaper."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from plan2scene.materials import palettes, periodic_noise
from plan2scene.materials.material import Look


def make(rng: Generator, kind: str, size: int, base: np.ndarray | None) -> Look:
    """Return (albedo float (size, size, 3), metres per tile, roughness) of a kind of plaster."""
    if base is not None:
        tone = base
    elif kind == "concrete":
        tone = palettes.vary(rng, np.full(3, rng.uniform(0.42, 0.78), np.float32), 2, 1.2)
    else:
        accent = rng.random() < (0.35 if kind == "wallpaper" else 0.15)
        tone = palettes.pick(
            rng, palettes.ACCENTS if accent else palettes.PAINTS, lightness=2.5, chroma=1.2
        )
    if kind == "paint":
        return _paint(rng, size, tone)
    if kind == "plaster":
        return _plaster(rng, size, tone)
    if kind == "concrete":
        return _concrete(rng, size, tone)
    return _wallpaper(rng, size, tone)


def _paint(rng: Generator, size: int, tone: np.ndarray) -> Look:
    """Return emulsion paint: nearly flat, with the stipple of the roller."""
    size_m = float(rng.uniform(0.4, 1.2))
    grain = float(rng.uniform(20, 70))
    roller = periodic_noise.spectral_noise(rng, size, 0.6, low=grain * 0.5, high=grain * 1.8)
    uneven = periodic_noise.spectral_noise(rng, size, 2.5, high=6)
    amount: np.ndarray = roller * np.float32(rng.uniform(0.002, 0.016))
    amount = amount + uneven * np.float32(rng.uniform(0.0, 0.008))
    return palettes.shade(tone, amount), size_m, float(rng.uniform(0.55, 0.95))


def _plaster(rng: Generator, size: int, tone: np.ndarray) -> Look:
    """Return rendered walls: trowel clouds, woodchip, sand or brush texture."""
    size_m = float(rng.uniform(0.4, 1.5))
    style = str(rng.choice(["trowel", "sand", "woodchip", "brush"], p=[0.4, 0.25, 0.2, 0.15]))
    if style == "trowel":
        bend = np.float32(rng.uniform(4, 14) * size / 256)
        field = periodic_noise.spectral_noise(rng, size, float(rng.uniform(1.6, 2.4)), low=2)
        dx, dy = (periodic_noise.spectral_noise(rng, size, 2.4, low=2) * bend for _ in range(2))
        field = periodic_noise.warp(field, dx, dy)
    elif style == "sand":
        field = periodic_noise.spectral_noise(rng, size, float(rng.uniform(0.2, 0.9)), low=10)
    elif style == "woodchip":
        coarse = periodic_noise.spectral_noise(
            rng, size, 0.6, low=12, high=float(rng.uniform(30, 60))
        )
        field = np.clip(coarse - 0.7, -0.3, 1.5)
    else:
        field = periodic_noise.spectral_noise(
            rng, size, 1.0, low=6, stretch=(1, float(rng.uniform(5, 14)))
        )
    amount: np.ndarray = field * np.float32(rng.uniform(0.01, 0.06))
    amount = amount + periodic_noise.spectral_noise(rng, size, 2.6, high=8) * np.float32(
        rng.uniform(0, 0.02)
    )
    return palettes.shade(tone, amount), size_m, float(rng.uniform(0.75, 1.0))


def _concrete(rng: Generator, size: int, tone: np.ndarray) -> Look:
    """Return smooth concrete or micro-cement: clouds, pores, hairline marks."""
    size_m = float(rng.uniform(0.8, 2.0))
    cloud = periodic_noise.spectral_noise(rng, size, float(rng.uniform(1.6, 2.6)), low=1.5)
    fine = periodic_noise.spectral_noise(rng, size, 0.8, low=15)
    pores = np.clip(periodic_noise.spectral_noise(rng, size, 0.6, low=25) - 2.2, 0, 1)
    amount = cloud * np.float32(rng.uniform(0.02, 0.08)) + fine * np.float32(
        rng.uniform(0.005, 0.025)
    )
    image = palettes.shade(tone, amount - pores * np.float32(rng.uniform(0.0, 0.4)))
    return image, size_m, float(rng.uniform(0.4, 0.9))


def _wallpaper(rng: Generator, size: int, tone: np.ndarray) -> Look:
    """Return paper with stripes, damask, sprigs, a trellis or a weave."""
    size_m = float(rng.uniform(0.4, 1.1))
    second = palettes.vary(rng, tone, float(rng.choice([4.0, 8.0, 16.0])), 3)
    style = str(rng.choice(["stripes", "damask", "sprigs", "trellis", "weave"]))
    if style == "stripes":
        cover = _stripes(rng, size)
    elif style == "trellis":
        count = int(rng.integers(3, 9))
        axis = (np.arange(size, dtype=np.float32) + 0.5) / size
        p = np.abs(np.mod((axis + axis[:, None]) * count, 1) - 0.5)
        q = np.abs(np.mod((axis - axis[:, None]) * count, 1) - 0.5)
        width = float(rng.uniform(0.04, 0.12))
        cover = np.clip((width - np.minimum(p, q)) * size / count / 1.4 + 0.5, 0, 1)
    elif style == "weave":
        threads = periodic_noise.spectral_noise(rng, size, 0.8, low=12, stretch=(14, 1))
        threads = threads + periodic_noise.spectral_noise(rng, size, 0.8, low=12, stretch=(1, 14))
        cover = np.clip(threads * 0.25 + 0.5, 0, 1)
    else:
        cover = _motifs(rng, size, mirrored=style == "damask")
    image = palettes.mix(tone, second, cover.astype(np.float32))
    amount = periodic_noise.spectral_noise(rng, size, 0.5, low=30) * np.float32(
        rng.uniform(0.002, 0.012)
    )
    return palettes.shade(image, amount), size_m, float(rng.uniform(0.5, 0.9))


def _stripes(rng: Generator, size: int) -> np.ndarray:
    """Return coverage of upright stripes, one or two widths."""
    count = int(rng.integers(3, 13))
    x = np.mod((np.arange(size, dtype=np.float32) + 0.5) / size * count, 1)
    width = float(rng.uniform(0.15, 0.5))
    cover = np.clip((width / 2 - np.abs(x - 0.5)) * size / count + 0.5, 0, 1)
    if rng.random() < 0.4:
        thin = np.clip((0.03 - np.minimum(x, 1 - x)) * size / count + 0.5, 0, 1)
        cover = np.maximum(cover, thin)
    return np.broadcast_to(cover, (size, size))


def _motifs(rng: Generator, size: int, *, mirrored: bool) -> np.ndarray:
    """Return coverage of an ornament repeated in a half drop (damask is mirror-symmetric)."""
    count = int(rng.choice([2, 4, 6], p=[0.4, 0.4, 0.2]))
    n = size // count * 2
    detail = float(rng.uniform(4, 8))
    field = periodic_noise.spectral_noise(rng, n, 0.8, low=detail * 0.4, high=detail)
    if mirrored:
        field = field + field[:, ::-1]
    axis = np.abs((np.arange(n) + 0.5) / n - 0.5) * 2
    reach = float(rng.uniform(0.8, 1.1)) if mirrored else float(rng.uniform(0.5, 0.8))
    falloff = np.hypot(axis / 0.85, axis[:, None]) / reach
    field = field / (field.std() + 1e-6) + 1.0 - 2.2 * falloff**2
    cover = np.clip((field - 0.3) * n / (detail * 6) + 0.5, 0, 1).astype(np.float32)
    ys, xs = np.mgrid[0:size, 0:size].astype(np.float32)
    scale = np.float32(n * count / 2 / size)
    x, y = xs * scale, ys * scale
    drop = np.mod(np.floor(x / n), 2) * n / 2 if (count // 2) % 2 == 0 else 0
    return periodic_noise.sample(cover, x, y + drop)
