"""Textures that models are trained on: tiles in memory, and random crops of them."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.io import atomic_path
from plan2scene.materials import random_material
from plan2scene.seeds import derive_seed
from plan2scene_workshop.rendering.index import textures_of_split
from plan2scene_workshop.texture.degradation import CROP_PX

_LOGGER = logging.getLogger("plan2scene")
TILE_PX = 256


@dataclass(frozen=True, eq=False)
class TextureSet:
    """Tileable textures."""

    tiles: np.ndarray  #: (n, 256, 256, 3) uint8 sRGB albedo, repeating in both directions
    substances: np.ndarray  #: (n,) int64, index into ``house.SUBSTANCES``
    scanned: np.ndarray  #: (n,) bool, true for textures of a folder, false for procedural ones

    def __len__(self) -> int:
        return len(self.tiles)

    def of(self, chosen: np.ndarray) -> TextureSet:
        """Return the textures that a mask (n,) bool or indices (k,) choose."""
        return TextureSet(self.tiles[chosen], self.substances[chosen], self.scanned[chosen])


@dataclass(frozen=True)
class MaterialSettings:
    """Textures that the texture models and the features network are trained and measured on."""

    procedural: int = 1600  #: number of training materials, the same number of each substance
    held_out: int = 320  #: number of other materials, to measure with
    folder: str | None = None  #: folder of additional real textures, with splits train and val


def procedural_textures(count: int, seed: int) -> TextureSet:
    """Return `count` procedural materials, the same number of each substance in turn."""
    substances = np.arange(count, dtype=np.int64) % len(SUBSTANCES)
    tiles = np.empty((count, TILE_PX, TILE_PX, 3), dtype=np.uint8)
    for index, substance in enumerate(substances):
        name = SUBSTANCES[substance]
        tiles[index] = random_material(name, derive_seed(seed, "texture training", index)).albedo
        if (index + 1) % 200 == 0:
            _LOGGER.info("%d of %d procedural materials", index + 1, count)
    return TextureSet(tiles, substances, np.zeros(count, dtype=bool))


def scanned_textures(folder: str | Path, split: str) -> TextureSet:
    """Return the textures of a folder (one subfolder per substance) as a set."""
    materials = textures_of_split(folder, split, size_px=TILE_PX)
    return TextureSet(
        np.stack([material.albedo for material in materials]),
        np.array([SUBSTANCES.index(m.substance) for m in materials], dtype=np.int64),
        np.ones(len(materials), dtype=bool),
    )


def join_sets(*sets: TextureSet) -> TextureSet:
    """Return the textures of several sets as one."""
    return TextureSet(**{k: np.concatenate([vars(s)[k] for s in sets]) for k in vars(sets[0])})


def write_materials(path: str | Path, settings: MaterialSettings, seed: int) -> None:
    """Write the textures of :func:`read_materials`."""
    learnt = [procedural_textures(settings.procedural, seed)]
    held_out = [procedural_textures(settings.held_out, derive_seed(seed, "held-out materials"))]
    if settings.folder is not None:
        learnt.append(scanned_textures(settings.folder, "train"))
        held_out.append(scanned_textures(settings.folder, "val"))
    whole = join_sets(*learnt, *held_out)
    learning = np.arange(len(whole)) < sum(map(len, learnt))
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        np.savez(file, learning=learning, **vars(whole))


def read_materials(path: str | Path) -> tuple[TextureSet, dict[str, TextureSet]]:
    """Return the training textures, and the held-out ones: ``procedural``, perhaps ``real``."""
    with np.load(path, allow_pickle=False) as stored:
        learning = stored["learning"]
        whole = TextureSet(stored["tiles"], stored["substances"], stored["scanned"])
    kinds = {"procedural": ~learning & ~whole.scanned, "real": ~learning & whole.scanned}
    return whole.of(learning), {k: whole.of(mask) for k, mask in kinds.items() if mask.any()}


def seen_textures(textures: TextureSet) -> list[str]:
    """Return the model card's lines about the training textures."""
    real = int(textures.scanned.sum())
    return [
        f"{len(textures) - real} procedural materials.",
        f"{real or 'No'} real tileable textures{' (the train split of a folder)' * bool(real)}.",
        "No photo.",
    ]


def sampling_weights(textures: TextureSet, scanned_share: float) -> np.ndarray:
    """Return the probability that each texture is drawn, (n,) summing to 1.

    Within scanned and within procedural textures, every substance is drawn equally often. Scanned
    textures, if there are any, take `scanned_share` of all draws.
    """
    weights = np.zeros(len(textures))
    shares = {True: scanned_share, False: 1.0 - scanned_share}
    for scanned, share in shares.items():
        group = textures.scanned == scanned
        present = np.unique(textures.substances[group])
        for substance in present:
            members = group & (textures.substances == substance)
            weights[members] = share / len(present) / members.sum()
    return weights / weights.sum()


def random_crop(tile: np.ndarray, rng: np.random.Generator, *, closest_px: int) -> np.ndarray:
    """Return a random 128x128 crop of a tile: toroidal shift, scale, flips, a quarter turn or none.

    Parameters
    ----------
    tile : (256, 256, 3) uint8
    closest_px : int
        Smallest side of the window in tile pixels; the largest is the whole tile.
    """
    side = int(rng.integers(closest_px, TILE_PX + 1))
    shift = rng.integers(0, TILE_PX, 2)
    window = np.roll(tile, tuple(shift), axis=(0, 1))[:side, :side]
    method = cv2.INTER_AREA if side > CROP_PX else cv2.INTER_LINEAR
    crop = cv2.resize(window, (CROP_PX, CROP_PX), interpolation=method)
    crop = crop[:: 1 - 2 * int(rng.integers(2)), :: 1 - 2 * int(rng.integers(2))]
    return np.ascontiguousarray(np.rot90(crop, int(rng.integers(2))))


def draw_crops(
    textures: TextureSet,
    weights: np.ndarray,
    count: int,
    rng: np.random.Generator,
    *,
    closest_px: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return random crops (n, 128, 128, 3) uint8 and their substances (n,) int64.

    `closest_px` is the smallest window of procedural tiles. For scanned ones, which were upsampled,
    the smallest window is larger.
    """
    chosen = rng.choice(len(textures), size=count, p=weights)
    sides = np.where(textures.scanned[chosen], (TILE_PX + closest_px) // 2, closest_px)
    pairs = zip(textures.tiles[chosen], sides, strict=True)
    crops = np.stack([random_crop(tile, rng, closest_px=int(side)) for tile, side in pairs])
    return crops, textures.substances[chosen]
