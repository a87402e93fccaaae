"""A material: an albedo tile with its size in the real world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

#: Albedo (n, n, 3) float sRGB in [0, 1], metres that it covers, roughness.
Look: TypeAlias = tuple[np.ndarray, float, float]


@dataclass(frozen=True, eq=False)
class Material:
    """What a surface is made of."""

    name: str  #: unique within a data set: ``wood-planks-1a2b``
    substance: str  #: one of ``house.SUBSTANCES``
    kind: str  #: ``planks``, ``grid``, ``loop``, ``paint`` ...
    albedo: np.ndarray  #: (n, n, 3) uint8 sRGB, repeats in both directions, no shading
    size_m: float  #: metres that the tile's side covers
    roughness: float  #: 0 mirror to 1 diffuse
