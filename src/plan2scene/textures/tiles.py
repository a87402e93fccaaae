"""Tiles of a house's surfaces, and the folder that they are written to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import atomic_directory, write_json
from plan2scene.textures.seams import make_seamless, with_calm_border

if TYPE_CHECKING:
    from plan2scene.textures.exemplar.make import Pattern
    from plan2scene.textures.inputs import KnownSurface
    from plan2scene.textures.maps import SurfaceMap


@dataclass(frozen=True, eq=False)
class Tile:
    """A surface's texture: (s, s, 3) uint8 sRGB, metres it covers, what it was made of.

    `origin_m` is where a tile begins in the mesh's texture coordinates, metres; `crops` are the
    ids of the crops that it was quilted from, `pattern` what they show. A `regular` tile repeats on
    maps: quilted, its joints would break.
    """

    image: np.ndarray
    size_m: float
    source: str
    tiles_by_construction: bool = False
    origin_m: tuple[float, float] = (0.0, 0.0)
    seam_corrected: bool = False
    crops: tuple[str, ...] = ()
    pattern: Pattern | None = None
    regular: bool = False

    def without_seams(self) -> Tile:
        """Return the tile with its seams repaired; itself where it tiles already."""
        if self.tiles_by_construction:
            return self
        image, changed = make_seamless(self.image)
        if not changed.any():
            return self
        return replace(self, image=with_calm_border(image), seam_corrected=True)


@dataclass(frozen=True)
class NoTile:
    """Why a method has no tile of a surface."""

    reason: str


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
