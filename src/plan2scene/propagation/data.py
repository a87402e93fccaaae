"""A house's graph as the networks take it: PyTorch Geometric's ``Data``, which batches houses."""

from __future__ import annotations

import numpy as np
import torch
from torch_geometric.data import Data

from plan2scene.propagation.graph import HouseGraph, doors_between

#: Facts about a pair of rooms: doors between them (1, 2, 3 or more, no way), types in common.
PAIR_SIZE = 5
_FAR = 4


def graph_data(graph: HouseGraph, visible: np.ndarray | None = None) -> Data:
    """Return a house with only the `visible` surfaces shown, (n, 3) bool; all observed when None.

    Returns
    -------
    Data
        ``x`` (n, 48) float32, ``edge_index`` (2, m) int64, ``pair_index`` (2, p) int64 and
        ``pair_attr`` (p, 5) float32 of :func:`room_pairs`, ``embeddings`` (n, 3, 11) float32.
    """
    shown = graph.observed if visible is None else visible
    pairs, facts = room_pairs(graph)
    # Copies: products of arrays that lie where numpy put them round differently run by run.
    return Data(
        x=torch.tensor(graph.node_features(shown)),
        edge_index=torch.tensor(graph.edges),
        pair_index=torch.tensor(pairs),
        pair_attr=torch.tensor(facts),
        embeddings=torch.tensor(graph.embeddings),
    )


def room_pairs(graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
    """Return all ordered pairs of different rooms and what is known of them.

    Returns
    -------
    (2, p) int64
        Row of the room that is looked at, row of the room in question (source, target).
    (p, 5) float32
    """
    count = len(graph.room_ids)
    target, source = np.nonzero(~np.eye(count, dtype=bool))
    doors = np.minimum(doors_between(count, graph.edges)[target, source], _FAR).astype(np.int64)
    facts = np.zeros((len(target), PAIR_SIZE), dtype=np.float32)
    facts[np.arange(len(target)), doors - 1] = 1.0
    common = np.minimum(graph.types[target], graph.types[source]).sum(axis=1)
    facts[:, PAIR_SIZE - 1] = common / np.maximum(graph.types[target].sum(axis=1), 1.0)
    return np.stack([source, target]).astype(np.int64), facts
