"""Training houses of the propagation network: plans, styles and crops, without any rendering.

A photo's crop of a surface is imitated by a metric window of its clean tile, as soft as crops of
photos are, under what the light corrections leave of the light of its room (one gain and tint for
a room, as one photo would have): that is what the embeddings of photographed surfaces vary by.
"""

from __future__ import annotations

import logging
from pathlib import Path

import cv2
import numpy as np

from plan2scene.house import ROOM_TYPES, SUBSTANCES, SURFACES, House, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.propagation.graph import house_graph
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.texture.degradation import CROP_PX, window

#: Sides of the metric windows that crops are cut at (the crop stage's usual sizes).
WINDOW_METRES = (0.5, 0.75, 1.0)
#: Standard deviations of what white balance and exposure leave of the light (measured on rendered
#: photos of the validation split: median dE2000 3.7, of it 1.6 in colour).
EXPOSURE, TINT = 0.055, 0.012
#: Share of a crop's pixels along a side that the photo had (the crop table's sharpness).
SHARPNESS = (0.4, 1.0)
_LOG = logging.getLogger("plan2scene")


def lit(crop: np.ndarray, rng: np.random.Generator, tint: np.ndarray) -> np.ndarray:
    """Return a crop under a room's light: per-channel gain `tint` and a smooth falloff."""
    slope = rng.normal(0.0, 0.06, 2)
    ramp = np.linspace(-1.0, 1.0, CROP_PX)
    field = 1.0 + slope[0] * ramp[:, None] + slope[1] * ramp[None]
    return np.clip(crop * field[..., None] * tint, 0, 255).astype(np.uint8)


def softened(crop: np.ndarray, sharpness: float) -> np.ndarray:
    """Return a (128, 128, 3) uint8 crop enlarged from `sharpness` of its pixels along a side."""
    side = max(round(CROP_PX * sharpness), 8)
    small = cv2.resize(crop, (side, side), interpolation=cv2.INTER_AREA)
    return cv2.resize(small, (CROP_PX, CROP_PX), interpolation=cv2.INTER_CUBIC)


def _house_crops(house: House, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return crops (n, 3, 128, 128, 3) uint8 and substances (n, 3) int of a house's surfaces."""
    materials = assign_materials(house, derive_seed(seed, house.id, "style"))
    crops = np.zeros((len(house.rooms), len(SURFACES), CROP_PX, CROP_PX, 3), dtype=np.uint8)
    substances = np.zeros(crops.shape[:2], dtype=np.int64)
    for i, room in enumerate(house.rooms):
        rng = generator(seed, house.id, room.id, "light")
        tint = rng.normal(1.0, EXPOSURE) * (1.0 + rng.normal(0.0, TINT, 3))
        for j, surface in enumerate(SURFACES):
            material = materials[SurfaceKey(room.id, surface)]
            share = rng.choice(WINDOW_METRES) / material.size_m
            view = window(material.albedo, rng.random(2), share, 0.0)
            soft = softened(view, float(rng.uniform(*SHARPNESS)))
            crops[i, j] = lit(soft, rng, tint)
            substances[i, j] = SUBSTANCES.index(material.substance)
    return crops, substances


def write_training_houses(output: str | Path, *, count: int, seed: int) -> None:
    """Write `count` synthetic houses as one ``.npz``.

    Arrays, rooms of all houses one after the other: ``house`` (n,) int, ``types`` (n, 12)
    float32, ``edges`` (2, m) int64 over global room rows, ``crops`` (n, 3, 128, 128, 3) uint8
    (surfaces in the order of ``SURFACES``), ``substances`` (n, 3) int64.
    """
    owners, types, edges, crops, substances = [], [], [], [], []
    rooms = 0
    for k in range(count):
        house = generate_house(f"train_{k:05d}", derive_seed(seed, "propagation", k))
        graph = house_graph(house, {})
        house_crops, house_substances = _house_crops(house, seed)
        owners.append(np.full(len(house.rooms), k))
        types.append(graph.types)
        edges.append(graph.edges + rooms)
        crops.append(house_crops)
        substances.append(house_substances)
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
            substances=np.concatenate(substances),
        )
