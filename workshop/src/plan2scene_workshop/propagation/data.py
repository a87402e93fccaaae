"""Training houses of the propagation network: plans, styles and crops, without any rendering.

A metric window of a surface's clean tile imitates the crop of a photo. In some homes it is as soft
as a crop of a good photo, in the others it is degraded like one of a bad photo. Half of the homes
are plain. Crops do not contain the light of the room: it is applied to the embeddings when they
are used (:mod:`plan2scene_workshop.propagation.light`).
"""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.house import ROOM_TYPES, SURFACES, House, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.propagation.graph import house_graph
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.style import PLAIN, VARIED, Style, assign_materials
from plan2scene_workshop.texture.degradation import CROP_PX, ROOM_PHOTO, photograph, window

#: Sides of the windows of the crops in metres (the usual sizes of the crop stage).
WINDOW_METRES = (0.5, 0.75, 1.0)
#: Share of homes that are plain, and share of homes whose crops imitate bad photos.
PLAIN_SHARE, BAD_SHARE = 0.5, 0.5
#: Degradation of bad photos, without a change of a whole crop's light and colour (see above).
BAD = replace(ROOM_PHOTO, white_balance=0.0, exposure=0.0)
#: Range of the photo's resolution relative to the crop's (`sharpness` in the crop table).
SHARPNESS = (0.4, 1.0)
_LOG = logging.getLogger("plan2scene")


def uneven(crop: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a (128, 128, 3) uint8 crop under a linear gradient of light."""
    slope = rng.normal(0.0, 0.06, 2)
    ramp = np.linspace(-1.0, 1.0, CROP_PX)
    field = 1.0 + slope[0] * ramp[:, None] + slope[1] * ramp[None]
    return np.clip(crop * field[..., None], 0, 255).astype(np.uint8)


def softened(crop: np.ndarray, sharpness: float) -> np.ndarray:
    """Return a (128, 128, 3) uint8 crop, reduced by the factor `sharpness` and enlarged again."""
    side = max(round(CROP_PX * sharpness), 8)
    small = cv2.resize(crop, (side, side), interpolation=cv2.INTER_AREA)
    return cv2.resize(small, (CROP_PX, CROP_PX), interpolation=cv2.INTER_CUBIC)


def _house_crops(house: House, seed: int, style: Style) -> np.ndarray:
    """Return crops (n, 3, 128, 128, 3) uint8 of a house's surfaces."""
    materials = assign_materials(house, derive_seed(seed, house.id, "style"), style=style)
    crops = np.zeros((len(house.rooms), len(SURFACES), CROP_PX, CROP_PX, 3), dtype=np.uint8)
    bad = generator(seed, house.id, "camera").random() < BAD_SHARE
    for i, room in enumerate(house.rooms):
        rng = generator(seed, house.id, room.id, "crops")
        for j, surface in enumerate(SURFACES):
            material = materials[SurfaceKey(room.id, surface)]
            share = rng.choice(WINDOW_METRES) / material.size_m
            view = window(material.albedo, rng.random(2), share, 0.0)
            soft = softened(view, float(rng.uniform(*SHARPNESS)))
            crops[i, j] = photograph(soft, rng, BAD) if bad else uneven(soft, rng)
    return crops


def write_training_houses(output: str | Path, *, count: int, seed: int) -> None:
    """Write `count` synthetic houses as one ``.npz``.

    The arrays hold the n rooms of all houses one after the other: ``house`` (n,) int, ``types``
    (n, 12) float32, ``edges`` (2, m) int64 between rows of rooms, ``crops`` (n, 3, 128, 128, 3)
    uint8 (surfaces in the order of ``SURFACES``), ``plain`` (n,) bool.
    """
    owners, types, edges, crops, plain = [], [], [], [], []
    rooms = 0
    for k in range(count):
        house = generate_house(f"train_{k:05d}", derive_seed(seed, "propagation", k))
        graph = house_graph(house, {})
        is_plain = bool(generator(seed, house.id, "style").random() < PLAIN_SHARE)
        owners.append(np.full(len(house.rooms), k))
        types.append(graph.types)
        edges.append(graph.edges + rooms)
        crops.append(_house_crops(house, seed, PLAIN if is_plain else VARIED))
        plain.append(np.full(len(house.rooms), is_plain))
        rooms += len(house.rooms)
        if (k + 1) % 50 == 0:
            _LOG.info("%d of %d houses, %d rooms", k + 1, count, rooms)
    with atomic_path(output) as temporary, temporary.open("wb") as file:
        np.savez(
            file,
            house=np.concatenate(owners),
            types=np.concatenate(types).reshape(-1, len(ROOM_TYPES)),
            edges=np.concatenate(edges, axis=1),
            crops=np.concatenate(crops),
            plain=np.concatenate(plain),
        )
