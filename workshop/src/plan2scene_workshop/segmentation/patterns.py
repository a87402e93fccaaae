"""Procedural picture tiles: patterned cloth and wallpaper."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from plan2scene.materials import random_material
from plan2scene.seeds import generator

Array = np.ndarray
Rng = np.random.Generator
#: Side of the tiles in pixels.
SIDE = 128


def palette(rng: Rng, count: int) -> Array:
    """Return (count, 3) sRGB colours 0-255 that go together: near one another or far apart."""
    base = rng.uniform(20, 245) * np.exp(rng.normal(0, 0.15, 3))
    spread = float(rng.choice([12, 40, 90]))
    near = base + rng.normal(0, spread, (count, 1)) + rng.normal(0, spread * 0.5, (count, 3))
    return np.clip(near, 5, 250)


def pattern(rng: Rng) -> Array:
    """Return a (SIDE, SIDE, 3) uint8 tile of stripes, checks, spots, flowers or patches."""
    kind = str(rng.choice(["stripes", "checks", "spots", "flowers", "patches", "zigzag", "mottle"]))
    colours = palette(rng, 5)
    y, x = np.mgrid[:SIDE, :SIDE]
    n = int(rng.choice([1, 2, 4, 8]))
    if kind in ("stripes", "zigzag"):
        bend = np.abs((x * 4 * n // 2) % 64 - 32) // 2 if kind == "zigzag" else 0
        index = (((y + bend) * 4 * n) // SIDE) % int(rng.integers(2, 5))
    elif kind == "checks":
        index = ((x * 2 * n) // SIDE) % 2 + ((y * 2 * n) // SIDE) % 2
    else:
        index = _scattered(kind, n, rng)
    tile = colours[index % 5]
    tile = tile + rng.normal(0, rng.uniform(0, 10), (SIDE, SIDE, 1))
    if rng.random() < 0.5:
        tile = tile.swapaxes(0, 1)
    return np.clip(tile, 0, 255).astype(np.uint8)


def _scattered(kind: str, n: int, rng: Rng) -> Array:
    """Return (SIDE, SIDE) colour indices of spots, flowers, patches or mottle on a ground."""
    canvas = np.zeros((SIDE, SIDE), np.uint8)
    if kind == "mottle":
        coarse = rng.normal(0, 1, (SIDE // (4 * n), SIDE // (4 * n))).astype(np.float32)
        field = cv2.resize(coarse, (SIDE, SIDE), interpolation=cv2.INTER_CUBIC)
        return np.asarray(np.digitize(field, [-0.8, 0, 0.8]))
    for _ in range(6 * n):
        centre = tuple(int(v) for v in rng.integers(0, SIDE, 2))
        r = int(rng.integers(5, 30) / np.sqrt(n)) + 1
        shade = int(rng.integers(1, 5))
        if kind == "patches":
            far = (centre[0] + 2 * r, centre[1] + int(r * rng.uniform(0.5, 3)))
            cv2.rectangle(canvas, centre, far, shade, -1)
        elif kind == "spots":
            cv2.circle(canvas, centre, r, shade, -1)
        else:
            for angle in np.linspace(0, 2 * np.pi, int(rng.integers(4, 8)), endpoint=False):
                at = (centre[0] + int(r * np.cos(angle)), centre[1] + int(r * np.sin(angle)))
                cv2.ellipse(canvas, at, (r, max(1, r // 2)), np.degrees(angle), 0, 360, shade, -1)
            cv2.circle(canvas, centre, max(1, r // 2), (shade + 1) % 5, -1)
    return canvas


@lru_cache(maxsize=1)
def surface_tiles() -> tuple[Array, ...]:
    """Return tiles (n, n, 3) uint8 sRGB that augmentation lays over surfaces: always the same."""
    rng = generator(0, "augmentation tiles")
    tiles = [
        random_material(substance, int(rng.integers(2**62)), size_px=SIDE).albedo
        for substance in ("wood", "carpet", "carpet", "tile", "plaster")
        for _ in range(12)
    ]
    return (*tiles, *(pattern(rng) for _ in range(24)))
