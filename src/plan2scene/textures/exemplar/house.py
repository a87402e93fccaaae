"""Exemplar textures of a whole house.

Observed surfaces get a tile of their own crops. An unobserved one gets the exemplar of the house
that is nearest to what is predicted for it (same kind of surface, the predicted substance if any
has it, nearest embedding), since a house repeats its materials. Its colour is moved towards the
predicted one, the less the surer propagation is that the house shows the material. Where it is far
from the predicted colour, the predicted embedding is decoded.
Each tile's source says which way it went.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.colour import (
    as_uint8,
    delta_e_2000,
    linear_to_srgb,
    median_colour,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.textures.exemplar.make import Exemplar, ExemplarCrop, make_exemplar

if TYPE_CHECKING:
    import pandas as pd

#: Largest difference (CIEDE2000) of an exemplar's colour to the predicted one.
MAX_AWAY = 25.0


@dataclass(frozen=True, eq=False)
class HouseExemplar:
    """A surface's tile (s, s, 3) uint8 sRGB, its side in metres (NaN unknown), its source."""

    image: np.ndarray
    size_m: float
    source: str


def house_exemplars(
    propagated: pd.DataFrame,
    crops: pd.DataFrame,
    hidden_photos: Collection[str],
    size_px: int,
) -> tuple[dict[SurfaceKey, HouseExemplar], dict[SurfaceKey, str]]:
    """Return the surfaces that exemplars serve, and the others with the reason why not.

    Parameters
    ----------
    propagated, crops : DataFrame
        ``propagated.parquet`` and ``crops.parquet`` (docs/conventions.md).
    hidden_photos : collection of str
        Photos whose crops are not to be seen.
    """
    rows = {SurfaceKey(row.room_id, row.surface): row for row in propagated.itertuples()}
    own: dict[SurfaceKey, Exemplar] = {}
    poor: dict[SurfaceKey, str] = {}
    for key, group in _crops_by_surface(crops, hidden_photos).items():
        if key not in rows:
            continue
        # The colour that the surface was given goes for all methods, so for the choice of crops.
        tone = np.clip(np.asarray(rows[key].embedding, dtype=np.float64)[-3:], 0.0, 1.0)
        made = make_exemplar(group, size_px=size_px, tone=tone)
        if made is None:
            poor[key] = f"none of {len(group)} crops is sharp enough"
        else:
            own[key] = made
    tiles = {
        key: HouseExemplar(made.image, made.size_m, f"exemplar of {made.crops} crops")
        for key, made in own.items()
    }
    for key, row in rows.items():
        if key not in tiles and key not in poor:
            found = _nearest(key, row, rows, own)
            if isinstance(found, str):
                poor[key] = found
            else:
                tiles[key] = found
    return tiles, poor


def _crops_by_surface(
    crops: pd.DataFrame, hidden_photos: Collection[str]
) -> dict[SurfaceKey, list[ExemplarCrop]]:
    """Return the visible crops of each surface, in the file's order."""
    found: dict[SurfaceKey, list[ExemplarCrop]] = {}
    for row in crops[~crops["photo"].isin(set(hidden_photos))].itertuples():
        crop = ExemplarCrop(image_from_bytes(row.png), float(row.metres), float(row.sharpness))
        found.setdefault(SurfaceKey(row.room_id, row.surface), []).append(crop)
    return found


def _nearest(
    key: SurfaceKey,
    row: Any,
    rows: Mapping[SurfaceKey, Any],
    own: Mapping[SurfaceKey, Exemplar],
) -> HouseExemplar | str:
    """Return the exemplar nearest to an unobserved surface, or why there is none."""
    wanted = np.asarray(row.embedding, dtype=np.float64)
    pool = [other for other in own if other.surface == key.surface]
    if not pool:
        return f"no exemplar of a {key.surface} in the house"
    pool = [other for other in pool if rows[other].substance == row.substance] or pool
    distances = [np.abs(np.asarray(rows[other].embedding) - wanted).mean() for other in pool]
    nearest = pool[int(np.argmin(distances))]
    made = own[nearest]
    tone = np.clip(wanted[-3:], 0.0, 1.0)
    away = colour_difference(made.image, tone)
    if away > MAX_AWAY:
        return f"the nearest exemplar, of {nearest.room_id}, is {away:.0f} dE2000 away"
    source = f"exemplar of {nearest.room_id}, {away:.1f} dE2000 from the predicted colour"
    # The surer the prediction is that the house shows this material, the more its colour counts.
    confidence = float(row.confidence)
    if not math.isfinite(confidence):
        return HouseExemplar(made.image, made.size_m, source)
    image = recoloured(made.image, tone, 1.0 - confidence)
    source += f", {1.0 - confidence:.0%} of the way to it"
    return HouseExemplar(image, made.size_m, source)


def recoloured(image: np.ndarray, tone: np.ndarray, share: float) -> np.ndarray:
    """Return an image whose median colour is moved towards a tone.

    Each channel's linear values are scaled: what another pigment of the same grain reflects.

    Parameters
    ----------
    image : (h, w, 3) uint8 sRGB
    tone : (3,) float, sRGB in [0, 1]
    share : float
        Of the way, in log linear light: 0 leaves the image, 1 gives it the tone.
    """
    median = np.maximum(srgb_to_linear(median_colour(image)), 1e-3)
    factor = (np.maximum(srgb_to_linear(tone), 1e-3) / median) ** share
    return as_uint8(linear_to_srgb(np.minimum(srgb_to_linear(image) * factor, 1.0)))


def colour_difference(image: np.ndarray, tone: np.ndarray) -> float:
    """Return the CIEDE2000 difference of a uint8 image's median colour to sRGB `tone` (3,)."""
    return float(delta_e_2000(rgb_to_lab(median_colour(image)), rgb_to_lab(tone)))
