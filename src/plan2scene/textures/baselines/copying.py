"""Tiles of the methods that decode nothing: crop, retrieve, medoid_colour and projection."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from plan2scene.house import House, SurfaceKey
from plan2scene.seeds import generator
from plan2scene.textures.baselines.nearest import (
    Choice,
    Crop,
    PoolCrop,
    choose_crop,
    flat_image,
    largest_crop,
    medoid_crop,
    surface_extent,
    usual_substance,
)
from plan2scene.textures.baselines.retrieval import TextureLibrary
from plan2scene.textures.tiles import Tile

if TYPE_CHECKING:
    import pandas as pd


def copied_tiles(
    method: str,
    plan: House,
    surfaces: pd.DataFrame,
    crops: list[Crop],
    others: list[PoolCrop],
    library: TextureLibrary,
    seed: int,
) -> dict[SurfaceKey, Tile]:
    """Return the tiles of the methods that decode nothing."""
    make: Callable[[Choice, float], Tile]
    if method != "retrieve":
        make = _crop_tile
    else:
        nearest: dict[str, int] = {}  # rooms often fall back on one crop

        def make(choice: Choice, metres: float) -> Tile:
            name = choice.crop.crop_id
            if name not in nearest:
                nearest[name] = library.nearest(choice.crop.image())
            return _library_tile(library, nearest[name], f"nearest to {choice.source}")

    tiles = {}
    for row in surfaces.itertuples():
        key = SurfaceKey(row.room_id, row.surface)
        own_crop = largest_crop if method == "projection" else medoid_crop
        choice = choose_crop(plan, key, crops, seed, own_crop, others)
        if choice is None:
            tile = _usual_tile(plan, key, library, seed)
        else:
            tile = make(choice, float(row.metres))
        if method == "medoid_colour":
            flat, source = flat_image(tile.image), f"median colour of {tile.source}"
            tile = replace(tile, image=flat, source=source, tiles_by_construction=True)
        elif method == "projection":
            size_m, origin_m = surface_extent(plan, key)
            source = f"{tile.source}, stretched"
            tile = replace(tile, size_m=size_m, origin_m=origin_m, source=source)
        tiles[key] = tile
    return tiles


def _crop_tile(choice: Choice, metres: float) -> Tile:
    """Return a crop as a tile, at its own scale, else at `metres`."""
    own = choice.crop.metres
    return Tile(choice.crop.image(), own if math.isfinite(own) else metres, choice.source)


def _library_tile(library: TextureLibrary, index: int, why: str) -> Tile:
    """Return a tile of the library."""
    return Tile(
        library.tiles[index], float(library.size_m[index]), f"{library.names[index]}, {why}"
    )


def _usual_tile(plan: House, key: SurfaceKey, library: TextureLibrary, seed: int) -> Tile:
    """Return a random library tile of the usual substance, for a house that no photo shows."""
    substance = usual_substance(plan, key)
    pool = library.of_substance(substance) or list(range(len(library)))
    rng = generator(seed, plan.id, key.room_id, key.surface, "library")
    index = pool[int(rng.integers(len(pool)))]
    return _library_tile(library, index, "no crop in the house")
