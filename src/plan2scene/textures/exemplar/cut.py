"""Minimum cuts on a torus: where a patch takes over from what is there (Kwatra et al. 2003)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

_UNITS = 1000.0  # capacities are whole numbers
_BIG = 10_000_000


def minimum_cut(
    cost: tuple[np.ndarray, np.ndarray], old: np.ndarray, new: np.ndarray
) -> np.ndarray:
    """Return (h, w) bool: the pixels that the patch takes.

    Parameters
    ----------
    cost : ((h, w), (h, w)) float
        Cost of a joint between each pixel and its lower and its right neighbour, wrapped around.
    old, new : (h, w) bool
        Pixels that have to stay and pixels that have to be the patch's.
    """
    height, width = old.shape
    free = ~(old | new)
    nodes = np.full((height, width), -1)
    nodes[free] = np.arange(int(free.sum()))
    count = int(free.sum())
    source, sink = count, count + 1
    nodes[old], nodes[new] = source, sink
    heads, tails, weights = [], [], []
    for axis in (0, 1):
        other = np.roll(nodes, -1, axis=axis)
        used = nodes != other
        heads.append(nodes[used])
        tails.append(other[used])
        weights.append(cost[axis][used])
    head, tail = np.concatenate(heads), np.concatenate(tails)
    capacity = np.minimum(np.rint(np.concatenate(weights) * _UNITS) + 1, _BIG).astype(np.int32)
    graph = coo_matrix(
        (np.r_[capacity, capacity], (np.r_[head, tail], np.r_[tail, head])),
        shape=(count + 2, count + 2),
    ).tocsr()
    graph.data = np.minimum(graph.data, _BIG).astype(np.int32)
    residual = graph - maximum_flow(graph, source, sink).flow
    residual.eliminate_zeros()
    reached = np.zeros(count + 2, dtype=bool)
    reached[breadth_first_order(residual, source, return_predecessors=False)] = True
    return ~reached[nodes]
