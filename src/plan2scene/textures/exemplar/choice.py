"""Crops to learn a surface from, and which of them show it, and show it sharply."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.colour import clipped_share, delta_e_2000, median_colour, rgb_to_lab

#: CIEDE2000 beyond which crops are of different things; light gives less.
ALIKE_DE = 20.0
_LEAST_SHARP = 0.2  # photo pixels per crop pixel under which a crop shows no texture
_MOST_SPOILED = 0.5  # share of burned-out or masked pixels from which a crop is useless
_FEW_OCTAVES = 1.0  # crops blurred by more than this against the better ones are left out
_ENOUGH = 3  # where so many are sharper


@dataclass(frozen=True, eq=False)
class ExemplarCrop:
    """A crop to learn a surface from.

    Attributes
    ----------
    image : (128, 128, 3) uint8
        sRGB.
    size_m : float
        Side of the square that it covers; NaN when unknown.
    sharpness : float
        Photo pixels per crop pixel; NaN when unknown.
    detail : bytes
        JPEG at the photo's own resolution; empty where the crop holds as much.
    plane : str
        Name of the photo's plane that it was cut from; empty when unknown.
    centre : (float, float)
        Its middle on that plane, metres (right, down).
    """

    image: np.ndarray
    size_m: float
    sharpness: float
    detail: bytes = b""
    plane: str = ""
    centre: tuple[float, float] = (0.0, 0.0)


def usable(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops that show a texture: neither burned out nor enlarged beyond use."""
    return [
        crop
        for crop in crops
        if not crop.sharpness < _LEAST_SHARP and clipped_share(crop.image) < _MOST_SPOILED
    ]


def alike(crops: Sequence[ExemplarCrop], tone: np.ndarray | None = None) -> list[ExemplarCrop]:
    """Return the crops whose colour is near that of the one nearest to `tone`.

    Where masks err, or the walls of a room are of two paints, crops of one surface show different
    things; patches of a rug in a floor are worse than fewer crops. Without a tone (3,), sRGB in
    [0, 1], the crop most like all others decides.
    """
    labs = np.stack([rgb_to_lab(median_colour(crop.image)) for crop in crops])
    apart = delta_e_2000(labs[:, None], labs[None])
    far = apart.sum(axis=1) if tone is None else delta_e_2000(labs, rgb_to_lab(tone)[None])
    middle = int(far.argmin())
    return [crop for crop, far in zip(crops, apart[middle], strict=True) if far <= ALIKE_DE]


def blur_octaves(crops: Sequence[ExemplarCrop]) -> np.ndarray:
    """Return by how many octaves crops have fewer photo pixels a metre than the best, (n,)."""
    detail = np.array([crop.sharpness / crop.size_m for crop in crops], dtype=np.float64)
    detail = np.where(np.isfinite(detail) & (detail > 0), detail, np.nan)
    if np.isnan(detail).all():
        return np.zeros(len(crops))
    return np.nan_to_num(np.log2(np.nanmax(detail) / detail))


def sharper(crops: Sequence[ExemplarCrop]) -> list[ExemplarCrop]:
    """Return the crops without those far blurrier than the `_ENOUGH` best: near ones show more."""
    behind = blur_octaves(crops)
    if len(crops) <= _ENOUGH:
        return list(crops)
    limit = float(np.sort(behind)[_ENOUGH - 1]) + _FEW_OCTAVES
    return [crop for crop, octaves in zip(crops, behind, strict=True) if octaves <= limit]
