"""Exemplar textures of a whole house.

An observed surface gets a tile of its own crops. Surfaces that share a material of the house get
one pattern of all its crops, each in its own colour. A house repeats its materials, so an
unobserved surface, or one whose crops all differ from the colour of its pixels, takes another
surface's exemplar in its own colour: the one that its prediction copies, else the nearest embedding
among those of the same kind of surface and substance. Paint has any colour, but a floor of another
colour is of another material: if an unobserved surface finds none, a procedural tile of the
predicted substance is made. A floor that is predicted to be tiled takes an exemplar of a floor
whose photos show no joints only if its prediction copies that floor. An embedding is decoded if the
surface's crops are all too poor, or all of another colour in a house without an exemplar of the
kind. Each tile's source says how it was made.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from plan2scene.colour import as_uint8, delta_e_2000, median_colour, rgb_to_lab
from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.materials import random_material
from plan2scene.paint.light import recoloured
from plan2scene.parallel import each
from plan2scene.seeds import derive_seed
from plan2scene.textures.crops import Crop
from plan2scene.textures.exemplar.make import Exemplar, ExemplarCrop, enlarged, make_exemplar
from plan2scene.textures.exemplar.settings import EXEMPLAR
from plan2scene.textures.inputs import KnownSurface, TextureInputs
from plan2scene.textures.seams import with_calm_border
from plan2scene.textures.tiles import NoTile, Tile

#: Substance that has no spots of its own.
PLAIN = "plaster"


def exemplar_tiles(inputs: TextureInputs) -> dict[SurfaceKey, Tile | NoTile]:
    """Return an exemplar of each surface, or the reason why there is none.

    Where no crop of a surface has a known scale, the tile has the surface's `size_m`.
    """
    surfaces = {surface.key: surface for surface in inputs.surfaces}
    tiles: dict[SurfaceKey, Tile | NoTile] = {}
    groups: dict[SurfaceKey, list[Crop]] = {}
    for crop in inputs.crops:
        if crop.key in surfaces:
            groups.setdefault(crop.key, []).append(crop)
    shared = _shared_crops(surfaces, groups)

    def of_one_material(keys: list[SurfaceKey]) -> list[tuple[SurfaceKey, Tile | NoTile]]:
        plain = all(surfaces[key].substance == PLAIN for key in keys)
        tiles_of_material: list[tuple[SurfaceKey, Tile | NoTile]] = []
        for key in keys:
            surface, group = surfaces[key], groups[key]
            if not surface.material and _of_another_thing(group, surface.colour):
                continue
            others = shared.get(surface.material, ())
            made = exemplar_of(inputs, group, surface.tone, others, plain=plain)
            tiles_of_material.append(
                (key, made or NoTile(f"none of {len(group)} crops is sharp enough"))
            )
        return tiles_of_material

    materials: dict[str, list[SurfaceKey]] = {}  # a shared pattern is made once
    for key in groups:
        materials.setdefault(surfaces[key].material or f"alone/{key.filename}", []).append(key)
    longest_first = sorted(materials.values(), key=lambda m: -sum(len(groups[key]) for key in m))
    for made in each(of_one_material, longest_first, inputs.settings.threads):
        tiles.update(made)
    exemplars = {key: tile for key in groups if isinstance(tile := tiles.get(key), Tile)}
    jointless = _jointless(inputs)
    for key, surface in surfaces.items():
        if key not in tiles:
            tiles[key] = _nearest(inputs, surface, surfaces, exemplars, jointless)
    return {
        key: replace(tile, size_m=surfaces[key].size_m)
        if isinstance(tile, Tile) and not math.isfinite(tile.size_m)
        else tile
        for key, tile in tiles.items()
    }


def _shared_crops(
    surfaces: Mapping[SurfaceKey, KnownSurface], groups: Mapping[SurfaceKey, list[Crop]]
) -> dict[str, list[Crop]]:
    """Return the crops of each shared material; a crop that shows several rooms counts once."""
    shared: dict[str, dict[str, Crop]] = {}
    for key, group in groups.items():
        if surfaces[key].material:
            crop_by_id = shared.setdefault(surfaces[key].material, {})
            crop_by_id.update({crop.crop_id: crop for crop in group})
    return {name: list(crops.values()) for name, crops in shared.items()}


def _of_another_thing(crops: Sequence[Crop], colour: np.ndarray | None) -> bool:
    """Return whether all crops differ much from the colour (3,) of the surface's pixels."""
    if colour is None:
        return False
    tone = np.clip(colour, 0.0, 1.0)
    return all(colour_difference(crop.image(), tone) > EXEMPLAR.alike_de for crop in crops)


def exemplar_of(
    inputs: TextureInputs,
    crops: Sequence[Crop],
    tone: np.ndarray | None,
    shared: Sequence[Crop] = (),
    *,
    plain: bool = False,
) -> Tile | None:
    """Return the exemplar of a surface's crops, recoloured to `tone` (3,); None if all are poor.

    A surface that shares a material takes the pattern of all crops of the material, which is made
    once. `tone` is sRGB in [0, 1]; without it the exemplar keeps the crops' own colour.
    `plain` as in :func:`~plan2scene.textures.exemplar.make.make_exemplar`.
    """
    made = None
    if len(shared) > len(crops) and tone is not None:
        made = _made(inputs, shared, None, plain=plain)
    made = made or _made(inputs, crops, tone, plain=plain)
    if made is None:
        return None
    exemplar, names = made
    image = exemplar.image if tone is None else recoloured(exemplar.image, tone)
    source = f"exemplar of {len(names)} crops"
    return Tile(image, exemplar.size_m, source, True, crops=names, pattern=exemplar.pattern)


def _made(
    inputs: TextureInputs, crops: Sequence[Crop], tone: np.ndarray | None, *, plain: bool
) -> tuple[Exemplar, tuple[str, ...]] | None:
    """Return the exemplar of crops and the names of those used; None if all are poor. Cached."""
    size_px = inputs.settings.size_px
    names = tuple(crop.crop_id for crop in crops)
    key = (names, size_px, None if tone is None else tuple(tone), plain)
    cache = inputs.data.exemplars
    if key not in cache:
        exemplar_crops = [_known(crop) for crop in crops]
        cache[key] = make_exemplar(exemplar_crops, size_px=size_px, tone=tone, plain=plain)
    exemplar: Exemplar | None = cache[key]
    return None if exemplar is None else (exemplar, tuple(names[k] for k in exemplar.crops))


def _known(crop: Crop) -> ExemplarCrop:
    """Return a crop of ``crops.parquet`` as an exemplar crop."""
    plane = crop.crop_id.rpartition("_crop")[0] if np.isfinite(crop.window).all() else ""
    middle = (float(np.mean(crop.window[::2])), float(np.mean(crop.window[1::2])))
    facts = crop.size_m, crop.sharpness, crop.detail
    return ExemplarCrop(crop.image(), *facts, plane, middle)


def _nearest(
    inputs: TextureInputs,
    surface: KnownSurface,
    surfaces: Mapping[SurfaceKey, KnownSurface],
    own: Mapping[SurfaceKey, Tile],
    jointless: Collection[SurfaceKey],
) -> Tile | NoTile:
    """Return the nearest exemplar of the house for a surface without its own, or why there is none.

    One whose embedding the prediction copies comes first, then those of the predicted substance; an
    unobserved surface takes no others. A floor without joints takes that of another such floor.
    """
    kind = surface.key.surface
    code = _code(surface)
    tone = np.clip(code[-3:], 0.0, 1.0) if surface.tone is None else surface.tone
    away = {
        key: colour_difference(tile.image, tone) for key, tile in own.items() if key.surface == kind
    }
    any_colour = surface.observed or surface.substance == PLAIN
    most = math.inf if any_colour else EXEMPLAR.alike_de
    pool = [key for key in away if away[key] <= most]
    if not pool:
        if surface.observed:
            return NoTile(f"no exemplar of a {kind} in the house")
        return _usual_tile(inputs, surface, tone)
    copied = [key for key in pool if np.array_equal(_code(surfaces[key])[:-3], code[:-3])]
    if surface.key in jointless:
        fitting = [key for key in pool if key in jointless]
    else:
        left_out = jointless if surface.substance == "tile" else ()
        of_one = [key for key in pool if surfaces[key].substance == surface.substance]
        fitting = [key for key in of_one if key not in left_out]
    candidates = copied or fitting
    if not candidates and not surface.observed:
        return _usual_tile(inputs, surface, tone)
    pool = candidates or pool
    distances = [np.abs(_code(surfaces[key]) - code).mean() for key in pool]
    nearest = pool[int(np.argmin(distances))]
    source = f"exemplar of {nearest.room_id}, {away[nearest]:.1f} dE2000 to the predicted colour"
    return replace(own[nearest], image=recoloured(own[nearest].image, tone), source=source)


def _jointless(inputs: TextureInputs) -> set[SurfaceKey]:
    """Return the floors whose photos show no joints where tiles would show them."""
    file = inputs.data.files.patterns
    if file is None:
        return set()
    table, _ = read_parquet(file)
    plain = table[(table["kind"] == "plain") & (table["confidence"] > 0.5)]
    return {SurfaceKey(row.room_id, row.surface) for row in plain.itertuples()}


def _code(surface: KnownSurface) -> np.ndarray:
    """Return the embedding (11,) float64 of a surface."""
    return np.asarray(surface.embedding, dtype=np.float64)


def colour_difference(image: np.ndarray, tone: np.ndarray) -> float:
    """Return the CIEDE2000 difference of a uint8 image's median colour to sRGB `tone` (3,)."""
    return float(delta_e_2000(rgb_to_lab(median_colour(image)), rgb_to_lab(tone)))


#: Kind of a procedural tile by substance (``materials.KINDS``), on floors and elsewhere.
FLOOR_KINDS = {"wood": "planks", "plaster": "concrete", "carpet": "cut", "tile": "grid"}
OTHER_KINDS = {**FLOOR_KINDS, "plaster": "paint"}
#: Seeds whose materials of these kinds, at :data:`_SIZE_PX`, were looked at and are ordinary.
_SEEDS = {"wood": (6, 9, 14), "plaster": (0, 1, 2), "carpet": (0, 1, 2), "tile": (9, 25, 33)}
_SIZE_PX = 256


def _usual_tile(inputs: TextureInputs, surface: KnownSurface, tone: np.ndarray) -> Tile:
    """Return a procedural tile of a surface's substance in the colour `tone` (3,), sRGB in [0, 1].

    All surfaces of one kind and substance in a house get one pattern.
    """
    kind, substance = surface.key.kind, surface.substance
    house, seeds = inputs.data.files.house_id, _SEEDS[substance]
    derived_seed = derive_seed(inputs.settings.seed, "usual tile", house, kind, substance)
    red, green, blue = (int(level) for level in np.round(np.clip(tone, 0.0, 1.0) * 255))
    material = random_material(
        substance,
        seeds[derived_seed % len(seeds)],
        kind=(FLOOR_KINDS if kind == "floor" else OTHER_KINDS)[substance],
        size_px=_SIZE_PX,
        colour_rgb=(red, green, blue),
    )
    image = with_calm_border(as_uint8(enlarged(material.albedo / 255.0, inputs.settings.size_px)))
    source = f"made up: no exemplar of a {kind} of {substance} in the house"
    regular = substance == "tile"
    return Tile(recoloured(image, tone), material.size_m, source, True, regular=regular)
