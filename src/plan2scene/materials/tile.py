"""Tile and stone: grids, mosaics, brick bonds, hexagons, marble, terrazzo."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from plan2scene.materials import bonds, palettes, periodic_noise
from plan2scene.materials.bonds import Layout
from plan2scene.materials.material import Look


def make(rng: Generator, kind: str, size: int, base: np.ndarray | None) -> Look:
    """Return (albedo float (size, size, 3), metres per tile, roughness) of a kind of tile."""
    if kind == "terrazzo":
        return _terrazzo(rng, size, base)
    plan = _layout(rng, kind, size)
    glazed = kind in ("mosaic", "brick") or rng.random() < (0.5 if kind == "hexagon" else 0.15)
    palette = palettes.GLAZES if glazed and kind != "marble" else palettes.STONES
    tone = palettes.pick(rng, palette, chroma=1.2) if base is None else base
    image = _units(rng, kind, plan, tone, palette)
    if kind == "marble":
        image = _veins(rng, plan, image, tone)
    elif glazed:
        image = _glaze(rng, plan, image)
    else:
        image = _stone(rng, plan, image)
    image = _grout(rng, kind, plan, image, tone)
    roughness = rng.uniform(0.05, 0.3) if glazed or kind == "marble" else rng.uniform(0.15, 0.65)
    return image, plan.size_m, float(roughness)


def _layout(rng: Generator, kind: str, size: int) -> Layout:
    """Return how the tiles lie, in sizes that shops sell."""
    if kind == "mosaic":
        unit, count = float(rng.uniform(0.018, 0.05)), int(rng.integers(8, 17))
        if rng.random() < 0.3:
            rounds = bool(rng.random() < 0.5)
            return bonds.hexagons(size, count, unit * count, rounds=rounds)
        offsets = np.zeros(count) if count % 2 or rng.random() < 0.6 else np.arange(count) * 0.5
        return bonds.bond(size, count, count, unit * count, offsets)
    if kind == "brick":
        ratio, columns = int(rng.integers(2, 5)), int(rng.integers(1, 5))
        rows = ratio * columns * (2 if (ratio * columns) % 2 else 1)
        columns = rows // ratio
        offsets = np.arange(rows) * 0.5 if rng.random() < 0.85 else np.zeros(rows)
        unit = float(rng.uniform(0.05, 0.1) if rows > 4 else rng.uniform(0.07, 0.2))
        upright = bool(rng.random() < 0.15)
        return bonds.bond(size, columns, rows, rows * unit, offsets, upright=upright)
    if kind == "hexagon":
        columns = int(rng.choice([4, 7, 8]))
        return bonds.hexagons(size, columns, columns * float(rng.uniform(0.05, 0.2)))
    if kind == "diagonal":
        count, unit = int(rng.integers(1, 4)), float(rng.uniform(0.15, 0.4))
        return bonds.diagonal_grid(size, count, count * unit * float(np.sqrt(2.0)))
    if kind == "checker":
        count, unit = 2 * int(rng.integers(1, 4)), float(rng.uniform(0.1, 0.4))
        if rng.random() < 0.3:
            count = 2
            return bonds.diagonal_grid(size, count, count * unit * float(np.sqrt(2.0)))
        return bonds.bond(size, count, count, count * unit, np.zeros(count))
    unit = float(rng.choice([0.1, 0.15, 0.2, 0.3, 0.33, 0.4, 0.45, 0.6], p=_GRID_SHARES))
    unit *= float(rng.uniform(0.95, 1.05))
    count = int(rng.integers(2, 7)) if unit < 0.25 else int(rng.integers(2, 5))
    if kind == "marble" and rng.random() < 0.3:
        count = 1
    if rng.random() < 0.25 and count % 2 == 0:  # tiles of 1 : 2, sometimes in a bond
        bonded = np.arange(count * 2) * (0.5 if rng.random() < 0.6 else 0.0)
        upright = bool(rng.random() < 0.5)
        return bonds.bond(size, count, count * 2, count * unit, bonded, upright=upright)
    offsets = np.zeros(count)
    return bonds.bond(size, count, count, count * unit, offsets)


_GRID_SHARES = (0.12, 0.14, 0.14, 0.2, 0.12, 0.08, 0.08, 0.12)


def _units(
    rng: Generator, kind: str, plan: Layout, tone: np.ndarray, palette: palettes.Palette
) -> np.ndarray:
    """Return each unit's own colour: (n, n, 3) float32."""
    spread = float(rng.choice([0.0, 0.015, 0.04, 0.1], p=[0.25, 0.4, 0.25, 0.1]))
    if kind == "checker":
        other = palettes.pick(rng, palette)
        count = plan.size_m / (2 * float(np.abs(plan.v).max()))
        n = plan.key.shape[0]
        pixel = (np.arange(n) + 0.5) / n * count
        if abs(count - round(count)) > 0.1:  # diagonal
            turns = round(count / np.sqrt(2.0))
            x, y = pixel / count, pixel[:, None] / count
            odd = np.mod(np.floor(turns * (x + y)) + np.floor(turns * (x - y)), 2)
        else:
            odd = np.mod(np.floor(pixel) + np.floor(pixel)[:, None], 2)
        image = palettes.mix(tone, other, odd.astype(np.float32))
    elif kind == "mosaic" and rng.random() < 0.65:
        other_count = int(rng.integers(2, 5))
        lightness, chroma = float(rng.uniform(2, 12)), float(rng.uniform(1, 5))
        tones = [tone] + [palettes.vary(rng, tone, lightness, chroma) for _ in range(other_count)]
        if rng.random() < 0.3:
            tones[-1] = palettes.pick(rng, palette)
        image = np.stack(tones)[plan.choose(rng, rng.uniform(0.3, 1.0, len(tones)))]
    else:
        image = np.broadcast_to(tone, (*plan.key.shape, 3))
    return palettes.shade(image, plan.draw(rng, spread))


def _glaze(rng: Generator, plan: Layout, image: np.ndarray) -> np.ndarray:
    """Return glazed units: almost even, slightly darker or lighter towards the rim."""
    size = image.shape[0]
    mottle = plan.lookup(rng, periodic_noise.spectral_noise(rng, size, 2.0, high=40))
    amount = mottle * np.float32(rng.choice([0.003, 0.01, 0.03], p=[0.5, 0.35, 0.15]))
    rim = np.exp(-plan.edge / np.float32(rng.uniform(0.001, 0.004)))
    return palettes.shade(image, amount + rim * np.float32(rng.normal(0, 0.03)))


def _stone(rng: Generator, plan: Layout, image: np.ndarray) -> np.ndarray:
    """Return stoneware or natural stone: clouds, bedding, speckle."""
    size = image.shape[0]
    stretch = float(rng.choice([1.0, 3.0, 8.0], p=[0.6, 0.2, 0.2]))
    beta = float(rng.uniform(1.2, 2.6))
    cloud = plan.lookup(
        rng, periodic_noise.spectral_noise(rng, size, beta, low=2, stretch=(stretch, 1))
    )
    speck = periodic_noise.spectral_noise(rng, size, 0.2, low=20)
    amount = cloud * np.float32(rng.uniform(0.01, 0.075)) + speck * np.float32(
        rng.uniform(0.0, 0.04)
    )
    image = palettes.shade(image, amount)
    if rng.random() < 0.3:  # pits of travertine, dark minerals of granite
        pits = np.clip(
            plan.lookup(rng, periodic_noise.spectral_noise(rng, size, 1.0, low=12)) - 1.3, 0, 1
        )
        image = palettes.shade(image, -pits * np.float32(rng.uniform(0.1, 0.5)))
    tint = plan.lookup(rng, periodic_noise.spectral_noise(rng, size, 2.2, low=2))[..., None]
    return image * (1 + tint * np.array([0.012, 0.0, -0.018], np.float32) * rng.uniform(0, 1.2))


def _veins(rng: Generator, plan: Layout, image: np.ndarray, tone: np.ndarray) -> np.ndarray:
    """Return marble: warped level lines of noise as veins, over clouds."""
    size = image.shape[0]
    bend = float(rng.uniform(4, 18)) * size / 256
    dx = periodic_noise.spectral_noise(rng, size, 2.4, low=2) * np.float32(bend)
    dy = periodic_noise.spectral_noise(rng, size, 2.4, low=2) * np.float32(bend)
    stretch = (float(rng.uniform(1, 4)), 1.0)
    field = periodic_noise.spectral_noise(rng, size, 4.0, low=1.5, high=8, stretch=stretch)
    field = periodic_noise.warp(field, dx, dy)
    width = np.float32(rng.uniform(0.03, 0.18))
    strength = np.clip(periodic_noise.spectral_noise(rng, size, 3.0, low=1.5) * 0.7 + 0.5, 0, 1)
    veins = np.exp(-np.abs(field) / width) * strength
    fine = periodic_noise.warp(
        periodic_noise.spectral_noise(rng, size, 4.0, low=4, high=14), dx * 0.6, dy * 0.6
    )
    branches = np.exp(-np.abs(fine) / (width * 0.7)) * strength[::-1, ::-1]
    veins = np.maximum(veins, branches * np.float32(rng.uniform(0.2, 0.6)))
    cloud = periodic_noise.warp(periodic_noise.spectral_noise(rng, size, 2.6, low=1.5), dx, dy)
    if rng.random() < 0.75:
        veins, cloud = plan.lookup(rng, veins), plan.lookup(rng, cloud)
    light = tone.mean() > 0.45
    vein = tone * rng.uniform(0.3, 0.7) if light else tone + (1 - tone) * rng.uniform(0.3, 0.7)
    vein = palettes.vary(rng, np.clip(vein, 0, 1).astype(np.float32), 3, 4)
    image = palettes.shade(image, cloud * np.float32(rng.uniform(0.01, 0.06)))
    return palettes.mix(image, vein, np.clip(veins * np.float32(rng.uniform(0.5, 1.0)), 0, 1))


def _grout(
    rng: Generator, kind: str, plan: Layout, image: np.ndarray, tone: np.ndarray
) -> np.ndarray:
    """Return the units with joints between them."""
    narrow = kind == "marble" or rng.random() < 0.3
    width = float(rng.uniform(0.0008, 0.002) if narrow else rng.uniform(0.002, 0.006))
    fill = palettes.pick(rng, palettes.GROUTS)
    if rng.random() < 0.4:
        fill = tone * np.float32(rng.uniform(0.7, 1.05))
    size = image.shape[0]
    dirt = periodic_noise.spectral_noise(rng, size, 1.6, low=2) * np.float32(rng.uniform(0.02, 0.1))
    joints = plan.joint(width) * np.float32(rng.uniform(0.75, 1.0))
    return palettes.mix(image, palettes.shade(fill, dirt), joints)


def _terrazzo(rng: Generator, size: int, base: np.ndarray | None) -> Look:
    """Return chips of stone in cement."""
    size_m = float(rng.uniform(0.25, 0.8))
    pixel = size_m / size
    cement = palettes.pick(rng, palettes.STONES, chroma=1.0) if base is None else base
    image = palettes.shade(
        cement,
        periodic_noise.spectral_noise(rng, size, 0.8, low=4) * np.float32(rng.uniform(0.005, 0.03)),
    )
    largest = float(rng.uniform(0.006, 0.022)) / pixel
    count = int(np.clip(0.9 * size * size / (largest * largest) * rng.uniform(0.4, 1.2), 60, 420))
    coverage, index = periodic_noise.scatter(rng, size, count, (max(0.7, largest * 0.12), largest))
    tones = [
        palettes.pick(rng, palettes.STONES, lightness=8) for _ in range(int(rng.integers(2, 6)))
    ]
    if rng.random() < 0.35:
        tones = [palettes.vary(rng, cement, 12, 2) for _ in tones]
    chips = np.stack(tones)[rng.integers(0, len(tones), count)]
    chips = chips * rng.normal(1, 0.05, (count, 1)).astype(np.float32)
    image = palettes.mix(image, chips[np.maximum(index, 0)], coverage * (index >= 0))
    return image, size_m, float(rng.uniform(0.08, 0.35))
