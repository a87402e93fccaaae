"""Predictions for a house: embeddings, how sure they are and whom they are like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, HouseGraph
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import (
    Inputs,
    Mixture,
    PointerNetwork,
    robust_centre,
    room_pairs,
)

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


def predict(network: PropagationNetwork | PointerNetwork, graph: HouseGraph) -> Prediction:
    """Return the predictions of a network for every surface, the observed ones as if unseen."""
    if isinstance(network, PointerNetwork):
        found = _predict_mixture(network, graph)
    else:
        shape = (len(graph.room_ids), len(SURFACES))
        with torch.no_grad():
            x = torch.from_numpy(graph.node_features(graph.observed))
            output = network(x, torch.from_numpy(graph.edges)).numpy()
        found = Prediction(output, np.full(shape, np.nan, np.float32), np.full(shape, -1))
    found.embedding[..., _COLOUR:] = np.clip(found.embedding[..., _COLOUR:], 0.0, 1.0)
    return found


def _predict_mixture(network: PointerNetwork, graph: HouseGraph) -> Prediction:
    """Return the centres of the pointer network's mixtures."""
    centre, deviation = network.centre.numpy(), network.deviation.numpy()
    values = (graph.embeddings - centre) / deviation
    scaled = HouseGraph(graph.room_ids, graph.types, graph.edges, values, graph.observed)
    pairs, facts = room_pairs(graph)
    x = torch.from_numpy(scaled.node_features(graph.observed))
    inputs = Inputs(
        x, torch.from_numpy(graph.edges), torch.from_numpy(pairs), torch.from_numpy(facts)
    )
    with torch.no_grad():
        mixture = network(inputs)
    centres, confidence, alike = mixture_centres(mixture, values, pairs)
    return Prediction((centres * deviation + centre).astype(np.float32), confidence, alike)


def mixture_centres(
    mixture: Mixture, values: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centres (n, 3, 11), weight of visible surfaces (n, 3) and the likeliest (n, 3).

    Parameters
    ----------
    values : (n, 3, 11) float
        Standardised embeddings of the visible surfaces.
    pairs : (2, p) int
        As of :func:`~plan2scene.propagation.pointer.room_pairs`.
    """
    own, log_own = mixture.own.numpy(), mixture.log_own.numpy()
    weights, scales = np.exp(mixture.log_copies.numpy()), mixture.copy_scale.numpy()
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
