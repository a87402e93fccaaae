"""Means over training surfaces, which a released propagation checkpoint does not contain."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, SURFACES, House
from plan2scene.propagation.type_means import TypeMeans, mean_by_type
from plan2scene.textures.model.embedding import make_embeddings
from plan2scene.textures.observed_surfaces import select_surfaces

if TYPE_CHECKING:
    import pandas as pd


def training_surfaces(
    crops: str | Path, texture_model: str | Path, naive_model: str | Path, *, house: str, seed: int
) -> pd.DataFrame:
    """Return the table ``surfaces.parquet`` of a house, with no photo hidden.

    The crops are embedded here, and the files of both steps are temporary.
    """
    with TemporaryDirectory() as name:
        embeddings, surfaces = Path(name) / "embeddings.parquet", Path(name) / "surfaces.parquet"
        make_embeddings(
            crops, embeddings, texture_model, naive_model, house=house, dataset="", seed=seed
        )
        return select_surfaces(embeddings, crops, (), surfaces, house=house, dataset="")


def training_means(houses: Iterable[tuple[House, pd.DataFrame]]) -> TypeMeans:
    """Return the mean embeddings by room and surface type over the observed surfaces of houses.

    `houses` are plans and their tables of :func:`training_surfaces`. Raises InputError where no
    house has an observed surface.
    """
    types, surfaces, embeddings, naive = [], [], [], []
    for house, table in houses:
        for row in table.itertuples():
            flags = [name in house.room(row.room_id).types for name in ROOM_TYPES]
            types.append(flags)
            surfaces.append(SURFACES.index(row.surface))
            embeddings.append(np.asarray(row.embedding, dtype=np.float32))
            naive.append(np.asarray(row.naive_embedding, dtype=np.float32))
    if not types:
        expected = "a training surface that a photo shows (official.means_splits)"
        raise InputError(expected, "none")
    index = (np.array(types), np.array(surfaces))
    return TypeMeans(
        mean_by_type(*index, np.stack(embeddings)), mean_by_type(*index, np.stack(naive))
    )
