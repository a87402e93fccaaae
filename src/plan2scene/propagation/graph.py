"""The room-door-room graph of a house as arrays; numpy only.

Node features (paper section 5.4, constants of the authors' public configuration): 12 room-type
flags, then for floor, wall and ceiling a presence flag and 11 embedding values, zeros where
absent: 12 + 3 x 12 = 48 per room.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import shortest_path

from plan2scene.house import ROOM_TYPES, SURFACES, House, SurfaceKey

EMBEDDING_SIZE = 11
NODE_SIZE = len(ROOM_TYPES) + len(SURFACES) * (1 + EMBEDDING_SIZE)


@dataclass(frozen=True)
class HouseGraph:
    """A house as a graph: one node for each of its n rooms."""

    room_ids: tuple[str, ...]
    types: np.ndarray  #: (n, 12) float32, multi-hot in the order of ``house.ROOM_TYPES``
    edges: np.ndarray  #: (2, m) int64, both directions of each inner door, source row first
    embeddings: np.ndarray  #: (n, 3, 11) float32, zeros where not observed
    observed: np.ndarray  #: (n, 3) bool, surfaces in the order of ``house.SURFACES``

    def place(self, key: SurfaceKey) -> tuple[int, int]:
        """Return the row and column of a surface."""
        return self.room_ids.index(key.room_id), SURFACES.index(key.surface)

    def node_features(self, visible: np.ndarray) -> np.ndarray:
        """Return the network's input, in which only the `visible` surfaces have values.

        `visible` is (n, 3) bool and is intersected with `observed`. Returns (n, 48) float32.
        """
        presence = (visible & self.observed)[..., None].astype(np.float32)
        blocks = np.concatenate([presence, self.embeddings * presence], axis=2)
        return np.concatenate([self.types, blocks.reshape(len(self.room_ids), -1)], axis=1)

    def standardised(self, centre: np.ndarray, deviation: np.ndarray) -> HouseGraph:
        """Return the graph with embeddings as (value - centre) / deviation, both (11,)."""
        values = (self.embeddings - centre) / deviation * self.observed[..., None]
        return replace(self, embeddings=values.astype(np.float32))


def house_graph(house: House, embeddings: Mapping[SurfaceKey, np.ndarray]) -> HouseGraph:
    """Return the graph of a house.

    Doors to the outside give no edge; a house without inner doors has no edges.
    `embeddings` holds the observed surfaces' (11,) arrays.
    """
    room_ids = tuple(room.id for room in house.rooms)
    position = {room_id: i for i, room_id in enumerate(room_ids)}
    types = np.zeros((len(room_ids), len(ROOM_TYPES)), dtype=np.float32)
    for i, room in enumerate(house.rooms):
        for name in room.types:
            types[i, ROOM_TYPES.index(name)] = 1.0
    pairs = [(position[a], position[b]) for a, b in house.adjacency()]
    directed = [*pairs, *((b, a) for a, b in pairs)]
    edges = np.array(sorted(directed), dtype=np.int64).reshape(-1, 2).T
    values = np.zeros((len(room_ids), len(SURFACES), EMBEDDING_SIZE), dtype=np.float32)
    observed = np.zeros((len(room_ids), len(SURFACES)), dtype=bool)
    for key, value in embeddings.items():
        i, j = position[key.room_id], SURFACES.index(key.surface)
        values[i, j] = np.asarray(value, dtype=np.float32)
        observed[i, j] = True
    return HouseGraph(room_ids, types, np.ascontiguousarray(edges), values, observed)


def doors_between(count: int, edges: np.ndarray) -> np.ndarray:
    """Return (n, n) float: number of doors on the shortest path between rooms; inf for no path."""
    links = csr_array((np.ones(edges.shape[1]), (edges[0], edges[1])), shape=(count, count))
    return np.asarray(shortest_path(links, unweighted=True))
