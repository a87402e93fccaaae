"""The texture stage: a tile for every surface of a house, by one of the paper's methods.

``crop``        the reference crop (:mod:`plan2scene.textures.baselines.copying`)
``retrieve``    the library's tile nearest to that crop
``medoid_colour``, ``projection``  its colour alone, the photo region stretched (same module)
``naivesynth``  the unmodified texture model, decoded from the mean of the crops' embeddings
``synth``       the paper's model, decoded from the selected or propagated embedding
``synth-large`` as ``synth``, then an observed surface's tile is given the colours and the spectrum
                of its selected crop (:mod:`plan2scene.textures.constrained`)
``exemplar``    tiles of the surfaces' own crops (:mod:`plan2scene.textures.exemplar`); where that
                cannot be, as ``synth``

Seam correction is a switch per method. The metrics read the very tiles written here, and the
paper compares Crop and Retrieve as they are (a corrected crop's TILE would not be Crop's), so
both are left alone by default; a decoder with periodic noise tiles by construction and is never
touched. Crops stay at their 128 px whatever `size_px` is: more pixels would add nothing.
Torch is imported only where something is decoded.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.seeds import derive_seed
from plan2scene.textures.baselines.copying import copied_tiles
from plan2scene.textures.baselines.crop_pool import read_pool
from plan2scene.textures.baselines.nearest import Crop
from plan2scene.textures.baselines.retrieval import read_library
from plan2scene.textures.constrained import even_crop, match_statistics
from plan2scene.textures.exemplar.house import HouseExemplar, house_exemplars
from plan2scene.textures.methods import DECODERS, METHODS
from plan2scene.textures.tiles import Tile, write_tiles

if TYPE_CHECKING:
    import pandas as pd


def make_textures(
    method: str,
    propagated: str | Path,
    crops: str | Path,
    scene_json: str | Path,
    out_dir: str | Path,
    *,
    house: str,
    hidden_photos: Collection[str],
    library: str | Path,
    model: str | Path | None,
    seed: int,
    size_px: int,
    seam_correction: bool,
    crop_pool: str | Path | None = None,
) -> None:
    """Write ``{room_id}_{surface}.png`` and ``textures.json`` (docs/conventions.md) to `out_dir`.

    Parameters
    ----------
    method : str
        One of :data:`plan2scene.textures.methods.METHODS`.
    propagated, crops, scene_json, library : path
        Files of the stages before (docs/conventions.md; the library of
        :func:`plan2scene.textures.baselines.retrieval.write_library`).
    hidden_photos : collection of str
        Photos whose crops are not to be seen at this drop fraction.
    model : path, optional
        Weights of the texture model; needed by the methods that decode.
    size_px : int
        Side of decoded tiles in pixels.
    seam_correction : bool
        Repair what does not tile by construction.
    crop_pool : path, optional
        Crops of other houses (:mod:`plan2scene.textures.baselines.crop_pool`), for methods that
        copy them.
    """
    if method not in METHODS:
        raise InputError(f"a method of {', '.join(METHODS)}", method, house=house)
    plan = read_scene_json(scene_json, house)
    surfaces, _ = read_parquet(propagated)
    crop_table = read_parquet(crops)[0]
    if method in DECODERS:
        if model is None:
            raise InputError(f"a texture model for method {method}", "none", house=house)
        decode = partial(
            _decoded, propagated, surfaces, model, house=house, seed=seed, size_px=size_px
        )
        if method == "exemplar":
            made, reasons = house_exemplars(surfaces, crop_table, hidden_photos, size_px)
            decoded = decode("synth") if reasons else {}
            tiles = _with_exemplars(surfaces, made, decoded, reasons)
        elif method == "synth-large":
            visible = visible_crops(crop_table, hidden_photos)
            tiles = _with_statistics(surfaces, decode("synth"), visible, house, seed)
        else:
            tiles = decode(method)
    else:
        visible = visible_crops(crop_table, hidden_photos)
        others = read_pool(crop_pool, but=house) if crop_pool else []
        tiles = copied_tiles(method, plan, surfaces, visible, others, read_library(library), seed)
    write_tiles(out_dir, method, surfaces, tiles, seam_correction)


def visible_crops(frame: pd.DataFrame, hidden_photos: Collection[str]) -> list[Crop]:
    """Return the crops of ``crops.parquet`` whose photo is not hidden, in the file's order."""
    hidden = set(hidden_photos)
    return [Crop.of(row) for row in frame.itertuples() if row.photo not in hidden]


def _decoded(
    propagated: str | Path,
    surfaces: pd.DataFrame,
    model: str | Path,
    method: str,
    *,
    house: str,
    seed: int,
    size_px: int,
) -> dict[SurfaceKey, Tile]:
    """Return the decoded tiles of methods naivesynth and synth."""
    from plan2scene.textures.model.synthesis import synthesise_surfaces
    from plan2scene.weights import read_model_arrays

    images = synthesise_surfaces(
        propagated, model, method=method, house=house, seed=seed, size_px=size_px
    )
    periodic = bool(read_model_arrays(model, ())[1]["periodic"])
    tiles = {}
    for row in surfaces.itertuples():
        key = SurfaceKey(row.room_id, row.surface)
        tiles[key] = Tile(images[key], float(row.metres), str(row.source), periodic)
    return tiles


def _with_statistics(
    surfaces: pd.DataFrame,
    tiles: Mapping[SurfaceKey, Tile],
    crops: list[Crop],
    house: str,
    seed: int,
) -> dict[SurfaceKey, Tile]:
    """Return decoded tiles with the statistics of the crop that each was decoded from."""
    images = {crop.crop_id: crop.image() for crop in crops}
    by_surface: dict[SurfaceKey, list[str]] = {}
    for crop in crops:
        by_surface.setdefault(crop.key, []).append(crop.crop_id)
    result = dict(tiles)
    for row in surfaces.itertuples():
        key = SurfaceKey(row.room_id, row.surface)
        if row.source not in images:
            continue
        others = [images[name] for name in by_surface.get(key, []) if name != row.source]
        tile, tone = tiles[key], np.asarray(row.embedding)[-3:]
        even = even_crop(images[row.source], others, tone, len(tile.image))
        derived = derive_seed(seed, house, key.room_id, key.surface, "statistics")
        matched = match_statistics(tile.image, even, derived)
        result[key] = replace(tile, image=matched, source=f"{tile.source}, its statistics")
    return result


def _with_exemplars(
    surfaces: pd.DataFrame,
    made: Mapping[SurfaceKey, HouseExemplar],
    decoded: Mapping[SurfaceKey, Tile],
    reasons: Mapping[SurfaceKey, str],
) -> dict[SurfaceKey, Tile]:
    """Return the exemplars, and decoded tiles where there are none with the reason why."""
    tiles = {}
    for row in surfaces.itertuples():
        key = SurfaceKey(row.room_id, row.surface)
        if key in made:
            size = made[key].size_m
            size_m = size if math.isfinite(size) else float(row.metres)
            tiles[key] = Tile(made[key].image, size_m, made[key].source, True)
        else:
            tile = decoded[key]
            source = f"decoded from {tile.source}: {reasons[key]}"
            tiles[key] = replace(tile, source=source)
    return tiles
