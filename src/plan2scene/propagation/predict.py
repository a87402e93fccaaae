"""Predictions for a house: embeddings, how sure they are and whom they are like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from plan2scene.house import SURFACES
from plan2scene.propagation.data import graph_data
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.model import Network
from plan2scene.propagation.pointer import Mixture, PointerNetwork

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
    seen : (n, 3, 3) float64, optional
        sRGB that surfaces have of which photos show anything, where the predictor tells it.
    """

    embedding: np.ndarray
    confidence: np.ndarray
    alike: np.ndarray
    seen: np.ndarray | None = None


@torch.inference_mode()
def predict(network: Network, graph: HouseGraph) -> Prediction:
    """Return the predictions of a network for every surface, the observed ones as if unseen."""
    if isinstance(network, PointerNetwork):
        centre, deviation = network.centre.numpy(), network.deviation.numpy()
        data = graph_data(graph.standardised(centre, deviation))
        mixture = network(data)
        components, weights = mixture_components(mixture, data.embeddings, data.pair_index)
        embedding = robust_centre(components, weights, _REACH * mixture.copy_scale)
        embedding = embedding * network.deviation + network.centre
        confidence = 1.0 - mixture.log_own.exp()
        likeliest = weights.argmax(1)
        alike = likeliest.masked_fill(likeliest == len(graph.room_ids), -1)
    else:
        data = graph_data(graph)
        embedding = network(data.x, data.edge_index)
        confidence = torch.full((len(graph.room_ids), len(SURFACES)), torch.nan)
        alike = torch.full(confidence.shape, -1)
    embedding[..., _COLOUR:].clamp_(0.0, 1.0)
    return Prediction(embedding.numpy(), confidence.numpy(), alike.numpy())


def mixture_components(
    mixture: Mixture, values: Tensor, pair_index: Tensor
) -> tuple[Tensor, Tensor]:
    """Return what a surface may be like, all n rooms and none, and how likely each is.

    Parameters
    ----------
    values : (n, 3, 11) float32
        Standardised embeddings of the visible surfaces.
    pair_index : (2, p) int64
        As of :func:`~plan2scene.propagation.data.room_pairs`.

    Returns
    -------
    components : (n, n + 1, 3, 11) float32
    weights : (n, n + 1, 3) float32
        Zero for the room itself and for those without visible surface.
    """
    rooms = len(values)
    source, target = pair_index
    weights = values.new_zeros(rooms, rooms + 1, len(SURFACES))
    weights[target, source] = mixture.log_copies.exp()
    weights[:, rooms] = mixture.log_own.exp()
    others = values.expand(rooms, *values.shape)
    return torch.cat([others, mixture.own[:, None]], dim=1), weights


def robust_centre(values: Tensor, weights: Tensor, reach: Tensor) -> Tensor:
    """Return the weighted median over axis 1, moved to the mean of what lies near.

    Several rooms of one material agree but for noise, which their mean is freer of than any of
    them. Values farther than `reach` pull no more than those at it (a step of Huber's
    estimator, DOI 10.1214/aoms/1177703732).

    Shapes
    ------
    values : (n, c, ..., d)
    weights : (n, c, ...)
    reach : (..., d)
    returns : (n, ..., d)
    """
    weights = weights[..., None]
    ordered, order = values.sort(dim=1, stable=True)
    reached = weights.expand_as(values).gather(1, order).cumsum(1) >= 0.5 * weights.sum(1, True)
    median = ordered.gather(1, reached.int().argmax(1, keepdim=True))
    pull = (values - median).clamp(-reach, reach)
    return median.squeeze(1) + (weights * pull).sum(1) / weights.sum(1)
