"""Tiles of a house's surfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.textures.seams import make_seamless, with_calm_border

if TYPE_CHECKING:
    from plan2scene.textures.exemplar.make import Pattern


@dataclass(frozen=True, eq=False)
class Tile:
    """A surface's texture: (s, s, 3) uint8 sRGB, metres of its side, what it was made of.

    `origin_m` is where a tile begins in the mesh's texture coordinates, metres; `crops` are the ids
    of the crops that it was quilted from, `pattern` the pattern found in them. On maps a `regular`
    tile is repeated, not quilted, because quilting would break its joints.
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
    """The reason why a method has no tile of a surface."""

    reason: str
