"""Predictors without a network: what the networks are compared with.

Each takes a house's graph and the means over training surfaces and returns embeddings of all
surfaces, (n, 3, 11) float32.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph, doors_between
from plan2scene.propagation.prior import TypeMeans


def room_type_mean(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the mean of training surfaces of the rooms' types."""
    return np.stack([means.embedding[types > 0].mean(axis=0) for types in graph.types])


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


#: Baselines by the name that tables show.
BASELINES: Mapping[str, Callable[[HouseGraph, TypeMeans], np.ndarray]] = {
    "room_type_mean": room_type_mean,
    "house_mean": house_mean,
    "nearest_room": nearest_room,
}
