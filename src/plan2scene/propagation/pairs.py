"""Pairs of rooms and what is known of them: whom the pointer network may point at; numpy only."""

from __future__ import annotations

import numpy as np

from plan2scene.propagation.graph import HouseGraph

#: Facts about a pair of rooms: doors between them (1, 2, 3 or more, no way), types in common.
PAIR_SIZE = 5
_FAR = 4


def room_pairs(graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
    """Return all ordered pairs of different rooms and what is known of them.

    Returns
    -------
    (2, p) int64
        Row of the room in question, row of the room that is looked at.
    (p, 5) float32
    """
    count = len(graph.room_ids)
    doors = doors_between(count, graph.edges)
    target, source = np.nonzero(~np.eye(count, dtype=bool))
    facts = np.zeros((len(target), PAIR_SIZE), dtype=np.float32)
    facts[np.arange(len(target)), np.minimum(doors[target, source], _FAR) - 1] = 1.0
    common = np.minimum(graph.types[target], graph.types[source]).sum(axis=1)
    facts[:, PAIR_SIZE - 1] = common / np.maximum(graph.types[target].sum(axis=1), 1.0)
    return np.stack([target, source]).astype(np.int64), facts


def doors_between(count: int, edges: np.ndarray) -> np.ndarray:
    """Return (n, n) int: doors on the shortest way between rooms, 4 where there is none up to 3."""
    linked = np.zeros((count, count), dtype=bool)
    linked[edges[0], edges[1]] = True
    doors = np.full((count, count), _FAR)
    reached = np.eye(count, dtype=bool)
    for distance in range(1, _FAR):
        beyond = (reached @ linked) & ~reached
        doors[beyond & (doors == _FAR)] = distance
        reached |= beyond
    return doors
