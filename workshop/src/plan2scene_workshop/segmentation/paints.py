"""What surfaces and things of drawn rooms are painted with."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.materials import load_texture_folder, random_material
from plan2scene.seeds import generator
from plan2scene_workshop.segmentation import patterns
from plan2scene_workshop.segmentation.bodies import (
    Array,
    Paint,
    plain,
    tiled,
)

Rng = np.random.Generator
#: Tiles of each kind that paints are drawn from.
TILES = 40
#: Gloss that tiles of a substance may reach.
_GLOSS = {"wood": 0.25, "plaster": 0.0, "carpet": 0.0, "tile": 0.4}
_PICTURES: Mapping[str, Callable[[Rng], Array]] = {
    "pattern": patterns.pattern,
    "poster": patterns.poster,
    "books": patterns.books,
    "folds": patterns.folds,
    "slats": patterns.slats,
}


def any_colour(rng: Rng) -> Array:
    """Return (3,) linear: grey of any lightness, at times a strong colour."""
    grey = rng.beta(0.8, 1.2)
    colour = grey * np.exp(rng.normal(0, rng.choice([0.05, 0.2, 0.6]), 3))
    return np.clip(colour, 0.008, 0.97)


@dataclass(frozen=True, eq=False)
class Paints:
    """Tiles by substance or kind of picture, and how surfaces draw from them."""

    tiles: Mapping[str, Sequence[Paint]]

    def of(self, kind: str, rng: Rng, size_m: float | None = None) -> Paint:
        """Return a random tile of a kind, of another size (0 stretched over a face) if given."""
        tiles = self.tiles[kind]
        paint = tiles[int(rng.integers(len(tiles)))]
        return paint if size_m is None else Paint(paint.levels, size_m, paint.gloss)

    def floor(self, rng: Rng) -> Paint:
        """Return what a floor may have: wood, carpet of any colour, tile, plain lino."""
        kind = str(rng.choice(["wood", "carpet", "tile", "plain"], p=[0.36, 0.3, 0.16, 0.18]))
        if kind == "plain":
            return plain(any_colour(rng), float(rng.choice([0.0, 0.1, 0.4])))
        paint = self.of(kind, rng)
        if rng.random() < (0.6 if kind == "carpet" else 0.25):
            paint = tinted(paint, any_colour(rng), float(rng.uniform(0.3, 1)))
        return paint

    def wall(self, rng: Rng) -> Paint:
        """Return what a wall may have: light paint, strong colours, paper, brick, boards, tile."""
        p = [0.55, 0.11, 0.13, 0.08, 0.07, 0.04, 0.02]
        kinds = ["light", "plaster", "strong", "pattern", "tile", "wood", "poster"]
        kind = str(rng.choice(kinds, p=p))
        if kind == "light":
            colour = rng.uniform(0.35, 0.95) * np.exp(rng.normal(0, 0.1, 3))
            return plain(np.clip(colour, 0.02, 0.98), 0.1 * float(rng.random()))
        if kind == "strong":
            return plain(any_colour(rng), 0.1 * float(rng.random()))
        if kind in ("pattern", "poster"):  # wallpaper; now and then a mural
            paint = self.of(kind, rng, float(rng.uniform(0.2, 1.2) if kind == "pattern" else 2.4))
            light = rng.uniform(0.3, 0.9) * np.exp(rng.normal(0, 0.1, 3))
            return tinted(paint, np.clip(light, 0.05, 0.95), float(rng.uniform(0.2, 1)))
        return self.of(kind, rng)

    def thing(self, rng: Rng) -> Paint:
        """Return what furniture may have."""
        kinds = ["plain", "wood", "carpet", "pattern", "tile", "poster"]
        kind = str(rng.choice(kinds, p=[0.52, 0.26, 0.09, 0.08, 0.03, 0.02]))
        if kind == "plain":
            return plain(any_colour(rng), float(rng.random()) ** 3)
        return self.of(kind, rng, float(rng.uniform(0.1, 1)) if kind == "pattern" else None)

    def cloth(self, rng: Rng) -> Paint:
        """Return what beds, sofas and cushions are covered with."""
        kind = str(rng.choice(["plain", "carpet", "pattern", "poster"], p=[0.4, 0.15, 0.4, 0.05]))
        if kind == "plain":
            return plain(any_colour(rng))
        return self.of(kind, rng, float(np.exp(rng.uniform(-2, 0.4))))

    def hard(self, rng: Rng) -> Paint:
        """Return what tables and cupboards are made of."""
        if rng.random() < 0.45:
            return plain(any_colour(rng), float(rng.random()) ** 2)
        if rng.random() < 0.12:
            return self.of("tile", rng)
        return self.of("wood", rng)


def tinted(paint: Paint, colour: Array, share: float) -> Paint:
    """Return a paint of another mean colour (linear); `share` 1 keeps no hue of its own."""
    mean = paint.levels[-1].reshape(3)
    levels = []
    for level in paint.levels:
        relative = level / np.maximum(mean, 0.01)
        grey = relative.mean(axis=2, keepdims=True)
        levels.append(
            np.clip((share * grey + (1 - share) * relative) * colour, 0.003, 1).astype(np.float32)
        )
    return Paint(tuple(levels), paint.size_m, paint.gloss)


def random_paints(seed: int, textures: str | Path | None = None) -> Paints:
    """Return the tiles that all rooms draw from.

    Parameters
    ----------
    textures : folder, optional
        Real tiles beside the procedural ones: a folder per substance with an ``index.csv`` (see
        `load_texture_folder`), of which the split train is used.
    """
    tiles: dict[str, list[Paint]] = {}
    scans = [] if textures is None else load_texture_folder(textures, "train", size_px=128)
    for substance, gloss in _GLOSS.items():
        rng = generator(seed, "scene paints", substance)
        made = [
            random_material(substance, int(rng.integers(2**62)), size_px=128) for _ in range(TILES)
        ]
        made += [scan for scan in scans if scan.substance == substance]
        tiles[substance] = [tiled(m.albedo, m.size_m, gloss * float(rng.random())) for m in made]
    for kind, make in _PICTURES.items():
        rng = generator(seed, "scene paints", kind)
        tiles[kind] = [tiled(make(rng), 0.0, 0.15 * float(rng.random())) for _ in range(TILES)]
    tiles["grid"] = [_grid(generator(seed, "scene paints", "grid", k)) for k in range(8)]
    return Paints(tiles)


def _grid(rng: Rng) -> Paint:
    """Return the tile of a suspended ceiling: panels with speckles between rails."""
    side = 64
    tile = np.full((side, side, 3), rng.uniform(190, 240), np.float32)
    speckle = rng.random((side, side, 1)) < rng.uniform(0, 0.15)
    tile -= speckle * rng.uniform(10, 60)
    tile = cv2.GaussianBlur(tile, (0, 0), 0.6)
    tile[:2] = tile[:, :2] = rng.uniform(90, 250)
    return tiled(np.clip(tile, 0, 255).astype(np.uint8), float(rng.choice([0.6, 0.62, 1.2])))
