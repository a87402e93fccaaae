"""Predictions for a house: embeddings, how sure they are and whom they are like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, HouseGraph
from plan2scene.propagation.inference import MixtureArrays, Network, mixture, regression
from plan2scene.propagation.pairs import room_pairs

#: How far agreeing components may lie apart, in scales of the copies' distributions.
_REACH = 2.0
#: First of the embedding's three colour values.
_COLOUR = 8


@dataclass(frozen=True, eq=False)
class Prediction:
    """What is expected of every surface of a house's n rooms.

    Parameters
    ----------
    embedding : (n, 3, 11) float32
        Colours clipped to [0, 1].
    confidence : (n, 3) float32
        Probability that the surface is like one that a photo shows; NaN from the paper's network,
        which does not tell.
    alike : (n, 3) int64
        Row of the room whose surface of the same kind is likeliest to be like it; -1 where that
        is none or not told.
    """

    embedding: np.ndarray
    confidence: np.ndarray
    alike: np.ndarray


def predict(network: Network, graph: HouseGraph) -> Prediction:
    """Return the predictions of a network for every surface, the observed ones as if unseen."""
    if network.pointer:
        found = _predict_mixture(network, graph)
    else:
        shape = (len(graph.room_ids), len(SURFACES))
        output = regression(network, graph.node_features(graph.observed), graph.edges)
        found = Prediction(output, np.full(shape, np.nan, np.float32), np.full(shape, -1))
    found.embedding[..., _COLOUR:] = np.clip(found.embedding[..., _COLOUR:], 0.0, 1.0)
    return found


def _predict_mixture(network: Network, graph: HouseGraph) -> Prediction:
    """Return the centres of the pointer network's mixtures."""
    centre, deviation = network.arrays["centre"], network.arrays["deviation"]
    values = (graph.embeddings - centre) / deviation
    scaled = HouseGraph(graph.room_ids, graph.types, graph.edges, values, graph.observed)
    pairs, facts = room_pairs(graph)
    found = mixture(network, scaled.node_features(graph.observed), graph.edges, pairs, facts)
    centres, confidence, alike = mixture_centres(found, values, pairs)
    return Prediction((centres * deviation + centre).astype(np.float32), confidence, alike)


def mixture_centres(
    found: MixtureArrays, values: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centres (n, 3, 11), weight of visible surfaces (n, 3) and the likeliest (n, 3).

    Parameters
    ----------
    values : (n, 3, 11) float
        Standardised embeddings of the visible surfaces.
    pairs : (2, p) int
        As of :func:`~plan2scene.propagation.pairs.room_pairs`.
    """
    own, log_own = found.own, found.log_own
    weights, scales = np.exp(found.log_copies), found.copy_scale
    rooms = len(own)
    centres = np.zeros((rooms, len(SURFACES), EMBEDDING_SIZE), dtype=np.float32)
    alike = np.full((rooms, len(SURFACES)), -1)
    for i in range(rooms):
        rows = pairs[0] == i
        sources = pairs[1, rows]
        for j in range(len(SURFACES)):
            theirs = np.append(weights[rows, j], np.exp(log_own[i, j]))
            components = np.concatenate([values[sources, j], own[i, j][None]])
            centres[i, j] = robust_centre(components, theirs, _REACH * scales[j])
            best = int(theirs.argmax())
            if best < len(sources):
                alike[i, j] = sources[best]
    return centres, (1.0 - np.exp(log_own)).astype(np.float32), alike


def weighted_median(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return per column the value with half of the weight at or below it, (d,) of (c, d), (c,)."""
    order = np.argsort(values, axis=0, kind="stable")
    reached = np.cumsum(weights[order], axis=0) >= 0.5 * weights.sum()
    return np.take_along_axis(values, np.take_along_axis(order, reached.argmax(0)[None], 0), 0)[0]


def robust_centre(values: np.ndarray, weights: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return per column the weighted median moved to the mean of what lies near, (d,).

    Several rooms of one material agree but for noise, which their mean is freer of than any of
    them. Values farther than `reach` (d,) pull no more than those at it (a step of Huber's
    estimator, DOI 10.1214/aoms/1177703732).
    """
    median = weighted_median(values, weights)
    pull = np.clip(values - median, -reach, reach)
    return median + weights @ pull / weights.sum()
