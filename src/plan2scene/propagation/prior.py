"""Predictors without a network: means of training surfaces, of the house, the nearest room.

The first is NaiveSynth's for unobserved surfaces; all are what the networks are compared with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.propagation.graph import HouseGraph, doors_between


@dataclass(frozen=True)
class TypeMeans:
    """Mean embeddings over training surfaces.

    Parameters
    ----------
    embedding : (12, 3, 11) float32
        Mean by room type and surface; a pair without samples holds the surface's mean.
    naive : (12, 3, 8) float32
        The same for the NaiveSynth model's code.
    """

    embedding: np.ndarray
    naive: np.ndarray

    def predict(self, types: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the (3, 11) and (3, 8) means of a room of the types (12,), multi-hot."""
        return self.embedding[types > 0].mean(axis=0), self.naive[types > 0].mean(axis=0)


def mean_by_type(types: np.ndarray, surface: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return means (12, 3, d) of `values` (n, d) by room type and surface.

    Parameters
    ----------
    types : (n, 12) bool or float, multi-hot
    surface : (n,) int, index into ``SURFACES``
    values : (n, d) float32
    """
    result = np.zeros((len(ROOM_TYPES), len(SURFACES), values.shape[1]), dtype=np.float32)
    for j in range(len(SURFACES)):
        rows = surface == j
        overall = values[rows].mean(axis=0) if rows.any() else np.zeros(values.shape[1])
        for i in range(len(ROOM_TYPES)):
            mine = rows & (types[:, i] > 0)
            result[i, j] = values[mine].mean(axis=0) if mine.any() else overall
    return result


def room_type_mean(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the mean of training surfaces of the rooms' types."""
    return np.stack([means.predict(types)[0] for types in graph.types])


def house_mean(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the mean over the house's observed surfaces of the kind; without any, as above."""
    values = room_type_mean(graph, means)
    for j in range(len(SURFACES)):
        if graph.observed[:, j].any():
            values[:, j] = graph.embeddings[graph.observed[:, j], j].mean(axis=0)
    return values


def nearest_room(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the surface of the kind fewest doors away, the first in the plan of equals.

    Where doors lead to none, the mean of the house.
    """
    values = house_mean(graph, means)
    doors = doors_between(len(graph.room_ids), graph.edges)
    for j in range(len(SURFACES)):
        seen = np.flatnonzero(graph.observed[:, j])
        if len(seen):
            nearest = seen[doors[:, seen].argmin(axis=1)]
            led = np.isfinite(doors[np.arange(len(doors)), nearest])
            values[led, j] = graph.embeddings[nearest[led], j]
    return values


#: Rules by the name that tables show; each returns embeddings of all surfaces, (n, 3, 11) float32.
RULES: Mapping[str, Callable[[HouseGraph, TypeMeans], np.ndarray]] = {
    "room_type_mean": room_type_mean,
    "house_mean": house_mean,
    "nearest_room": nearest_room,
}
