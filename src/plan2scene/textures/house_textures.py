"""The texture stage: a tile for every surface of a house, by one method or all of a table.

Seam correction is a switch per method. The metrics read the tiles that are written here, and the
paper compares Crop and Retrieve as they are (a corrected crop's TILE would not be Crop's), so
both are left alone by default. A decoder with periodic noise tiles by construction and is never
corrected. Crops stay at their 128 px whatever `size_px` is, because they hold no more detail.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import atomic_directory, write_json
from plan2scene.textures.decoding import further_images
from plan2scene.textures.inputs import (
    HouseData,
    HouseFiles,
    KnownSurface,
    TextureInputs,
    TextureSettings,
    Visible,
)
from plan2scene.textures.maps import SurfaceMap
from plan2scene.textures.methods import TextureMethod, method_named
from plan2scene.textures.tiles import NoTile, Tile

#: Patterns of the files of maps, which the table does not compare.
_MAPS = shutil.ignore_patterns("*.jpg", "maps.json")


def make_textures(
    name: str, inputs: TextureInputs, out_dir: str | Path, *, maps: bool = False
) -> None:
    """Write ``{room_id}_{surface}.png`` and ``textures.json`` by method `name` to `out_dir`.

    With `maps` also a map of every surface of the house, ``{room_id}_{surface}.jpg``.
    """
    tiles: Mapping[SurfaceKey, Tile] = house_tiles(name, inputs)
    house, surfaces = inputs.house, inputs.surfaces
    whole = None
    if maps:
        from plan2scene.textures.laying import read_patterns
        from plan2scene.textures.maps import (
            house_maps,
            patterns_of_floors,
            tile_of_pattern,
        )

        file = inputs.data.files.patterns
        patterns = {} if file is None else read_patterns(file)
        like = {key: SurfaceKey(p.like, key.surface) for key, p in patterns.items() if p.like}
        runs_on = {
            key: replace(tiles[other], source=f"runs on from {other.room_id}")
            for key, other in like.items()
            if key in tiles and other in tiles
        }
        tiles = {**tiles, **runs_on}
        materials = {surface.key: surface.material for surface in surfaces}
        seed = inputs.settings.seed
        patterns = patterns_of_floors(house, tiles, patterns)
        sizes = {surface.key: surface.size_m for surface in surfaces}  # a crop's, as metrics need
        laid = {
            key: tile_of_pattern(tiles[key], p, sizes[key], seed)
            for key, p in patterns.items()
            if p.units
        }
        tiles = {**tiles, **laid}
        whole = house_maps(house, tiles, materials, patterns, seed=seed)
    write_tiles(out_dir, name, surfaces, tiles, whole)


def write_tiles(
    out_dir: str | Path,
    method: str,
    surfaces: Iterable[KnownSurface],
    tiles: Mapping[SurfaceKey, Tile],
    maps: Mapping[SurfaceKey, SurfaceMap] | None = None,
) -> None:
    """Write ``{room_id}_{surface}.png`` and ``textures.json`` (docs/conventions.md).

    With `maps` also ``{room_id}_{surface}.jpg`` and ``maps.json``.
    """
    entries = {}
    with atomic_directory(out_dir) as folder:
        for surface in surfaces:
            key, tile = surface.key, tiles[surface.key]
            write_png(folder / f"{key.filename}.png", tile.image)
            entry: dict[str, Any] = {
                "size_m": tile.size_m,
                "observed": surface.observed,
                "substance": surface.substance,
                "seam_corrected": tile.seam_corrected,
                "source": tile.source,
            }
            if surface.material:
                entry["material"] = surface.material
            if tile.crops:
                entry["crops"] = list(tile.crops)
            if any(tile.origin_m):
                entry["origin_m"] = list(tile.origin_m)
            entries[f"{key.room_id}/{key.surface}"] = entry
        write_json(folder / "textures.json", {"method": method, "surfaces": entries})
        if maps is not None:
            for key, whole in maps.items():
                (folder / f"{key.filename}.jpg").write_bytes(whole.jpeg)
            facts = {"/".join(key): whole.facts() for key, whole in maps.items()}
            write_json(folder / "maps.json", {"surfaces": facts})


def house_tiles(name: str, inputs: TextureInputs) -> dict[SurfaceKey, Tile]:
    """Return the tiles of all surfaces, seams corrected where the settings say so."""
    method = method_named(name)
    if method.weights is not None and method.weights not in inputs.models:
        house_id = inputs.data.files.house_id
        raise InputError(f"a texture model for method {name}", "none", house=house_id)
    tiles = _made(method, inputs)
    if inputs.settings.seam_correction.get(name, method.seam_correction):
        return {key: tile.without_seams() for key, tile in tiles.items()}
    return tiles


def _made(method: TextureMethod, inputs: TextureInputs) -> dict[SurfaceKey, Tile]:
    """Return a method's tiles; where it has none, its fallback's, with the reason in the source."""
    method_tiles = method.make(inputs)
    fallback_tiles: dict[SurfaceKey, Tile] = {}
    if method.fallback and any(isinstance(tile, NoTile) for tile in method_tiles.values()):
        fallback_tiles = _made(method_named(method.fallback), inputs)
    tiles = {}
    for surface in inputs.surfaces:
        tile = method_tiles[surface.key]
        if isinstance(tile, NoTile):
            other = fallback_tiles[surface.key]
            tile = replace(other, source=f"decoded from {other.source}: {tile.reason}")
        tiles[surface.key] = tile
    return tiles


def table_textures(
    files: HouseFiles,
    drops: Mapping[str, Visible],
    methods: Sequence[str],
    out_dir: str | Path,
    *,
    models: Mapping[str, Path],
    settings: TextureSettings,
    images: int = 1,
    ready: Mapping[tuple[str, str], str | Path] | None = None,
) -> None:
    """Write ``{drop}/{method}/`` to `out_dir`, each as the texture stage makes it.

    `drops` tells what is visible at each share of hidden photos. Methods that draw noise make
    `images` images of each surface with crops, for FID and KID: the tile, and others that are
    ``more/{k}/{room_id}_{surface}.png``, k from 1. `ready` holds folders of the texture stage by
    drop and method; their tiles are copied.
    """
    data = HouseData(files)
    with atomic_directory(out_dir) as folder:
        for drop, visible in drops.items():
            inputs = data.at(visible, models, settings)
            for method in methods:
                ready_folder, target = (ready or {}).get((drop, method)), folder / drop / method
                if ready_folder:
                    shutil.copytree(ready_folder, target, ignore=_MAPS)
                else:
                    write_tiles(target, method, inputs.surfaces, house_tiles(method, inputs))
                if method_named(method).noise and images > 1:
                    _write_more(target / "more", method, inputs, images - 1)


def _write_more(folder: Path, method: str, inputs: TextureInputs, count: int) -> None:
    """Write `count` further images of each surface with crops."""
    crops = inputs.data.crops
    cropped_surfaces = set(zip(crops["room_id"], crops["surface"], strict=True))
    keys = [surface.key for surface in inputs.surfaces if tuple(surface.key) in cropped_surfaces]
    texture_method = method_named(method)
    correct = inputs.settings.seam_correction.get(method, texture_method.seam_correction)
    codes = str(texture_method.model), str(texture_method.embedding)
    images = iter(further_images(inputs, *codes, keys, count, seamless=correct))
    for key in keys:
        for number in range(1, count + 1):
            write_png(folder / str(number) / f"{key.filename}.png", next(images))
