"""Walls in bands: two materials, parted at a height (``patterns.parquet``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.colour import as_uint8, linear_to_srgb, median_colour, srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.textures.exemplar.house_tiles import PLAIN, exemplar_of
from plan2scene.textures.inputs import TextureInputs
from plan2scene.textures.tiles import Tile

_FLAT_PX = 64  #: Side of the tile of a band that no crop shows alone, pixels


@dataclass(frozen=True, eq=False)
class Bands:
    """The tiles of a wall above and below `split_m` over the floor."""

    split_m: float
    upper: Tile
    lower: Tile


def read_bands(
    path: str | Path, inputs: TextureInputs, tiles: Mapping[SurfaceKey, Tile]
) -> dict[SurfaceKey, Bands]:
    """Return the walls in bands of ``patterns.parquet``, each band of crops that show it alone.

    The band that looks like the wall's tile has its colour, the other one as much another colour as
    the photos show.
    """
    table, _ = read_parquet(path)
    crops = {(crop.key, crop.crop_id): crop for crop in inputs.crops}
    plain = {surface.key for surface in inputs.surfaces if surface.substance == PLAIN}
    found = {}
    for row in table[table["kind"] == "bands"].itertuples():
        key = SurfaceKey(row.room_id, row.surface)
        if key not in tiles:
            continue
        shown = srgb_to_linear(median_colour(tiles[key].image))
        seen = {"above": np.array(row.upper, float), "below": np.array(row.lower, float)}
        away = {name: np.abs(np.log((c + 0.01) / (shown + 0.01))).sum() for name, c in seen.items()}
        like = min(away, key=lambda name: away[name])
        made = []
        for name, colour in seen.items():
            tone = linear_to_srgb(np.clip(shown * colour / np.maximum(seen[like], 1e-3), 0.0, 1.0))
            names = str(getattr(row, name)).split("|")
            group = [crops[key, crop] for crop in names if (key, crop) in crops]
            tile = exemplar_of(inputs, group, tone, plain=key in plain) if group else None
            made.append(tile or _flat(tone))
        found[key] = Bands(float(row.split_m), made[0], made[1])
    return found


def _flat(tone: np.ndarray) -> Tile:
    """Return a tile of one sRGB colour (3,)."""
    image = np.broadcast_to(as_uint8(tone), (_FLAT_PX, _FLAT_PX, 3)).copy()
    return Tile(image, 1.0, "a band that no crop shows alone", tiles_by_construction=True)
