"""A material: an albedo tile with its size in the real world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

#: Albedo (n, n, 3) float sRGB in [0, 1], metres that it covers, roughness.
Look: TypeAlias = tuple[np.ndarray, float, float]


@dataclass(frozen=True, eq=False)
class Material:
    """What a surface is made of.

    Attributes
    ----------
    name : str
        Unique within a data set: ``wood-planks-1a2b``.
    substance : str
        One of ``house.SUBSTANCES``.
    kind : str
        ``planks``, ``grid``, ``loop``, ``paint`` ...
    albedo : (n, n, 3) uint8
        sRGB, repeats in both directions, no shading.
    size_m : float
        Side in metres that the tile covers.
    roughness : float
        0 mirror to 1 diffuse.
    """

    name: str
    substance: str
    kind: str
    albedo: np.ndarray
    size_m: float
    roughness: float
