"""Tiles of a house's surfaces, and the folder that they are written to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import atomic_directory, write_json
from plan2scene.textures.seams import make_seamless, with_calm_border

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class Tile:
    """A surface's texture: (s, s, 3) uint8 sRGB, metres it covers, what it was made of.

    `origin_m` is where a tile begins in the mesh's texture coordinates, metres.
    """

    image: np.ndarray
    size_m: float
    source: str
    tiles_by_construction: bool = False
    origin_m: tuple[float, float] = (0.0, 0.0)


def write_tiles(
    out_dir: str | Path,
    method: str,
    surfaces: pd.DataFrame,
    tiles: Mapping[SurfaceKey, Tile],
    seam_correction: bool,
) -> None:
    """Write ``{room_id}_{surface}.png`` and ``textures.json``, seams corrected where asked for."""
    entries = {}
    with atomic_directory(out_dir) as folder:
        for row in surfaces.itertuples():
            key = SurfaceKey(row.room_id, row.surface)
            tile = tiles[key]
            image, corrected = tile.image, False
            if seam_correction and not tile.tiles_by_construction:
                image, changed = make_seamless(image)
                corrected = bool(changed.any())
                image = with_calm_border(image) if corrected else image
            write_png(folder / f"{key.filename}.png", image)
            entries[f"{key.room_id}/{key.surface}"] = {
                "size_m": tile.size_m,
                "observed": bool(row.observed),
                "substance": row.substance,
                "seam_corrected": corrected,
                "source": tile.source,
            }
            if any(tile.origin_m):
                entries[f"{key.room_id}/{key.surface}"]["origin_m"] = list(tile.origin_m)
        write_json(folder / "textures.json", {"method": method, "surfaces": entries})
