"""The tileable library and the Retrieve baseline: the texture nearest to a crop (paper, 6.1).

The paper takes the least L1 distance of pixels. Textures are not aligned with crops, so that
compares little more than brightness. Here colour and coarseness decide: tiles are clearly nearer.
The library is generated from procedural materials or read from a user's folder of tileable
images; either way it is one Parquet file with columns ``name, substance, size_m, png``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import METRIC_SIZE, image_from_bytes, metric_image, png_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.metrics.color_freq_tile import color_histogram, frequency_profile
from plan2scene.seeds import derive_seed

_FREQ_WEIGHT = 100.0  # a FREQ of 1 counts as this many dE2000
_COLOR_WEIGHT = 5.0  # a COLOR of 1 counts as this many dE2000


@dataclass(frozen=True, eq=False)
class TextureLibrary:
    """Tileable textures to retrieve from."""

    names: tuple[str, ...]
    substances: tuple[str, ...]  #: of ``house.SUBSTANCES``
    tiles: np.ndarray  #: (n, s, s, 3) uint8 sRGB, repeating in both directions
    size_m: np.ndarray  #: (n,) float64, metres that each tile covers

    def __len__(self) -> int:
        return len(self.names)

    def nearest(self, crop: np.ndarray) -> int:
        """Return the index of the tile most like `crop`, (h, w, 3) uint8; the first of equals.

        Least sum, at 128 px, of the CIEDE2000 difference of the median colours, the difference
        of the frequency profiles and that of the colour histograms.
        """
        labs, profiles, histograms = self._looks
        lab, profile, histogram = _looks(metric_image(crop))
        distances = (
            delta_e_2000(labs, lab[None])
            + _FREQ_WEIGHT * np.abs(profiles - profile).mean(axis=1)
            + _COLOR_WEIGHT * np.abs(histograms - histogram).sum(axis=1) / 2
        )
        return int(np.argmin(distances))

    @cached_property
    def _looks(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the tiles' median colours, frequency profiles and colour histograms."""
        labs, profiles, histograms = zip(
            *(_looks(metric_image(tile)) for tile in self.tiles), strict=True
        )
        return np.stack(labs), np.stack(profiles), np.stack(histograms)

    def of_substance(self, substance: str) -> list[int]:
        """Return the indices of tiles of a substance."""
        return [i for i, name in enumerate(self.substances) if name == substance]


def _looks(image: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return median CIELAB colour (3,), frequency profile (64,), shares of colour bins (90,)."""
    return (
        rgb_to_lab(median_colour(image)),
        frequency_profile(image),
        color_histogram(image) / METRIC_SIZE**2,
    )


def generated_library(per_substance: int, seed: int, size_px: int) -> TextureLibrary:
    """Return a library of procedural materials, `per_substance` of each substance."""
    from plan2scene.materials import random_material

    materials = [
        random_material(name, derive_seed(seed, "texture library", name, index), size_px=size_px)
        for name in SUBSTANCES
        for index in range(per_substance)
    ]
    return _from_materials(materials)


def _from_materials(materials: Sequence) -> TextureLibrary:
    return TextureLibrary(
        names=tuple(material.name for material in materials),
        substances=tuple(material.substance for material in materials),
        tiles=np.stack([material.albedo for material in materials]),
        size_m=np.array([material.size_m for material in materials]),
    )


def write_library(
    output: str | Path, *, folder: str | None, per_substance: int, seed: int, size_px: int
) -> None:
    """Write the library file: from a user's `folder`, or generated if that is None.

    The folder has subfolders wood, plaster, carpet, tile of images.
    """
    import pandas as pd

    from plan2scene.materials import load_texture_folder

    if folder is None:
        library = generated_library(per_substance, seed, size_px)
    else:
        library = _from_materials(load_texture_folder(folder, size_px=size_px))
    frame = pd.DataFrame(
        {
            "name": library.names,
            "substance": library.substances,
            "size_m": library.size_m,
            "png": [png_bytes(tile) for tile in library.tiles],
        }
    )
    write_parquet(output, frame, {"source": "generated" if folder is None else "folder"})


def read_library(path: str | Path) -> TextureLibrary:
    """Return the library of :func:`write_library`."""
    frame, _ = read_parquet(path)
    if frame.empty:
        raise InputError("a texture in the library", "none", file=path)
    return TextureLibrary(
        names=tuple(frame["name"]),
        substances=tuple(frame["substance"]),
        tiles=np.stack([image_from_bytes(png) for png in frame["png"]]),
        size_m=frame["size_m"].to_numpy(dtype=np.float64),
    )
