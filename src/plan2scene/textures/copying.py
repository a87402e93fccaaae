"""Tiles of the methods that decode nothing: crop, retrieve, medoid_colour and projection."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

from plan2scene.house import House, SurfaceKey
from plan2scene.seeds import generator
from plan2scene.textures.crops import (
    Choice,
    Crop,
    choose_crop,
    flat_image,
    largest_crop,
    medoid_crop,
    surface_extent,
    usual_substance,
)
from plan2scene.textures.inputs import TextureInputs
from plan2scene.textures.library import TextureLibrary
from plan2scene.textures.tiles import Tile

_Tiles: TypeAlias = dict[SurfaceKey, Tile]


def crop_tiles(
    inputs: TextureInputs, own_crop: Callable[[Sequence[Crop]], Crop] = medoid_crop
) -> _Tiles:
    """Return the crop that represents each surface, at its own scale where that is known."""

    def make(choice: Choice, size_m: float) -> Tile:
        own = choice.crop.size_m
        return Tile(choice.crop.image(), own if math.isfinite(own) else size_m, choice.source)

    return _tiles(inputs, make, own_crop)


def retrieved_tiles(inputs: TextureInputs) -> _Tiles:
    """Return the library's tile nearest to the crop that represents each surface."""
    nearest: dict[str, int] = {}  # several surfaces often use the same crop

    def make(choice: Choice, size_m: float) -> Tile:
        library, name = inputs.data.library, choice.crop.crop_id
        if name not in nearest:
            nearest[name] = library.nearest(choice.crop.image())
        return _library_tile(library, nearest[name], f"nearest to {choice.source}")

    return _tiles(inputs, make, medoid_crop)


def flat_tiles(inputs: TextureInputs) -> _Tiles:
    """Return the median colour of the crop that represents each surface."""
    return {
        key: replace(
            tile,
            image=flat_image(tile.image),
            source=f"median colour of {tile.source}",
            tiles_by_construction=True,
        )
        for key, tile in crop_tiles(inputs).items()
    }


def projected_tiles(inputs: TextureInputs) -> _Tiles:
    """Return the largest crop of each surface, stretched over it."""
    tiles = {}
    for key, tile in crop_tiles(inputs, largest_crop).items():
        size_m, origin_m = surface_extent(inputs.house, key)
        source = f"{tile.source}, stretched"
        tiles[key] = replace(tile, size_m=size_m, origin_m=origin_m, source=source)
    return tiles


def _tiles(
    inputs: TextureInputs,
    make: Callable[[Choice, float], Tile],
    own_crop: Callable[[Sequence[Crop]], Crop],
) -> _Tiles:
    """Return what `make` makes of each surface's crop; a usual tile if there is no crop at all."""
    house, seed = inputs.house, inputs.settings.seed
    tiles = {}
    for surface in inputs.surfaces:
        choice = choose_crop(house, surface.key, inputs.crops, seed, own_crop, inputs.data.pool)
        if choice is None:
            tiles[surface.key] = _usual_tile(house, surface.key, inputs.data.library, seed)
        else:
            tiles[surface.key] = make(choice, surface.size_m)
    return tiles


def _library_tile(library: TextureLibrary, index: int, why: str) -> Tile:
    """Return a tile of the library."""
    return Tile(
        library.tiles[index], float(library.size_m[index]), f"{library.names[index]}, {why}"
    )


def _usual_tile(house: House, key: SurfaceKey, library: TextureLibrary, seed: int) -> Tile:
    """Return a random library tile of the usual substance, for a house that no photo shows."""
    substance = usual_substance(house, key)
    pool = library.of_substance(substance) or list(range(len(library)))
    rng = generator(seed, house.id, key.room_id, key.surface, "library")
    index = pool[int(rng.integers(len(pool)))]
    return _library_tile(library, index, "no crop in the house")
