"""Means over training surfaces: what a released propagation checkpoint comes without."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.io import read_parquet
from plan2scene.propagation.prior import TypeMeans, mean_by_type


def training_means(houses: Mapping[str, tuple[str | Path, str | Path]]) -> TypeMeans:
    """Return the mean embeddings by room and surface type over the observed surfaces of houses.

    Parameters
    ----------
    houses : mapping
        House to its ``scene.json`` and ``surfaces.parquet`` (docs/conventions.md).

    Raises
    ------
    InputError
        Where no house has an observed surface.
    """
    types, surfaces, embeddings, naive = [], [], [], []
    for house, (scene, table) in houses.items():
        plan = read_scene_json(scene, house)
        frame, _ = read_parquet(table)
        for row in frame.itertuples():
            flags = [name in plan.room(row.room_id).types for name in ROOM_TYPES]
            types.append(flags)
            surfaces.append(SURFACES.index(row.surface))
            embeddings.append(np.asarray(row.embedding, dtype=np.float32))
            naive.append(np.asarray(row.naive_embedding, dtype=np.float32))
    if not types:
        expected = "a training surface that a photo shows (official.means_splits)"
        raise InputError(expected, f"none in {len(houses)} houses")
    index = (np.array(types), np.array(surfaces))
    return TypeMeans(
        mean_by_type(*index, np.stack(embeddings)), mean_by_type(*index, np.stack(naive))
    )
