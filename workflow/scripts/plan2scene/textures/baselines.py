"""Crop baseline: the photo crop that stands for each surface (paper section 5).

An observed surface gets its reference crop, the medoid of its visible crops. For an unobserved
one a random crop is drawn from the first of these pools that is not empty:

1. same surface type in rooms of the house that share a room type with its room,
2. same surface type in the house (the paper looks into the training set before; a data set need
   not have one),
3. any surface of the house.

A house without any visible crop has none: the stage then takes a tile of the library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.house import House, SurfaceKey
from plan2scene.io import image_from_bytes
from plan2scene.photos.crops import medoid_index
from plan2scene.seeds import generator

#: Substance of a surface that nothing is known of, by surface; wet rooms have tiled floors.
_USUAL_SUBSTANCE = {"floor": "wood", "wall": "plaster", "ceiling": "plaster"}
_TILED_ROOMS = frozenset({"Bathroom", "Balcony", "Terrace", "Outdoor"})


@dataclass(frozen=True)
class Crop:
    """A visible crop of a surface: PNG bytes of 128x128 sRGB, and the metres it covers."""

    crop_id: str
    key: SurfaceKey
    png: bytes
    metres: float

    def image(self) -> np.ndarray:
        """Return the pixels, (128, 128, 3) uint8 sRGB."""
        return image_from_bytes(self.png)


@dataclass(frozen=True)
class Choice:
    """The crop chosen for a surface, and how it was found."""

    crop: Crop
    source: str


def choose_crop(plan: House, key: SurfaceKey, crops: Sequence[Crop], seed: int) -> Choice | None:
    """Return the crop that stands for a surface; None for a house without any crop.

    Parameters
    ----------
    plan : House
        Gives the room types.
    crops : sequence of Crop
        All visible crops of the house, in a stable order.
    seed : int
        Global seed; the choice depends on it, the house and the surface alone.
    """
    own = [crop for crop in crops if crop.key == key]
    if own:
        crop = own[medoid_index([crop.image() for crop in own])]
        return Choice(crop, crop.crop_id)
    types = set(plan.room(key.room_id).types)
    same_surface = [crop for crop in crops if crop.key.surface == key.surface]
    pools = (
        (
            "a room of its type",
            [c for c in same_surface if types & set(plan.room(c.key.room_id).types)],
        ),
        (f"another {key.surface} of the house", same_surface),
        ("another surface of the house", list(crops)),
    )
    for name, pool in pools:
        if pool:
            rng = generator(seed, plan.id, key.room_id, key.surface, "crop")
            crop = pool[int(rng.integers(len(pool)))]
            return Choice(crop, f"{name}: {crop.crop_id} of {crop.key.room_id}")
    return None


def usual_substance(plan: House, key: SurfaceKey) -> str:
    """Return the substance that a surface has in most homes."""
    if key.surface == "floor" and _TILED_ROOMS & set(plan.room(key.room_id).types):
        return "tile"
    return _USUAL_SUBSTANCE[key.surface]
