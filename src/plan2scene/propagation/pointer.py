"""The pointer network: a predicted surface is like one that a photo shows, or like none of them.

The paper's network regresses one embedding, which under doubt is a mean of several materials and
looks like none of them. Here its hidden states score the house's visible surfaces of the same
kind: a prediction is a mixture of Laplace distributions, one around every visible surface's
embedding (after pointer networks, Vinyals et al. 2015, arXiv:1506.03134, and mixture density
networks, Bishop 1994) and one around what the paper's network regresses. The weight of the visible
surfaces is a confidence, and the mixture's median a sharp prediction.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE
from plan2scene.propagation.inference import LEAST_SCALE, MOST_LOG_SCALE, MOST_SCORE
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pairs import PAIR_SIZE


@dataclass(frozen=True)
class Inputs:
    """One or several houses as tensors (rows of later houses follow those of earlier ones).

    Parameters
    ----------
    x : (n, 48) float32
        Node features of standardised embeddings.
    edges : (2, m) int64
    pairs : (2, p) int64
    facts : (p, 5) float32
    """

    x: Tensor
    edges: Tensor
    pairs: Tensor
    facts: Tensor


@dataclass(frozen=True)
class Mixture:
    """Predictions of every surface.

    Parameters
    ----------
    own : (n, 3, 11) float32
        What the paper's network regresses.
    own_scale, copy_scale : (n, 3, 11), (3, 11) float32
        Scales of the Laplace distributions around it and around visible surfaces.
    log_own : (n, 3) float32
        Log weight of `own`.
    log_copies : (p, 3) float32
        Log weight of each pair's looked-at room; -inf where its surface is not visible.
    """

    own: Tensor
    own_scale: Tensor
    copy_scale: Tensor
    log_own: Tensor
    log_copies: Tensor


class PointerNetwork(nn.Module):
    """Node features and room pairs -> mixtures, all in standardised embeddings.

    Parameters
    ----------
    width, layers : int
        Of the paper's network, which is the trunk.
    pair_width : int
        Hidden units that score a pair of rooms.
    """

    def __init__(self, width: int = 96, layers: int = 3, pair_width: int = 64) -> None:
        super().__init__()
        self.trunk = PropagationNetwork(width, layers)
        kinds = len(SURFACES)
        self.pair = nn.Sequential(
            nn.Linear(2 * width + PAIR_SIZE, pair_width), nn.ReLU(), nn.Linear(pair_width, kinds)
        )
        self.none = nn.Linear(width, kinds)
        self.own_scale = nn.Linear(width, kinds * EMBEDDING_SIZE)
        self.copy_scale = nn.Parameter(torch.full((kinds, EMBEDDING_SIZE), -1.0))
        self.centre: Tensor
        self.deviation: Tensor
        self.register_buffer("centre", torch.zeros(EMBEDDING_SIZE))
        self.register_buffer("deviation", torch.ones(EMBEDDING_SIZE))

    def forward(self, inputs: Inputs) -> Mixture:
        """Return the mixture of every surface of every room."""
        hidden = self.trunk.hidden(inputs.x, inputs.edges)
        target, source = inputs.pairs
        scores = self.pair(torch.cat([hidden[target], hidden[source], inputs.facts], dim=1))
        blocks = inputs.x[:, len(ROOM_TYPES) :].reshape(len(inputs.x), len(SURFACES), -1)
        unseen = blocks[source, :, 0] == 0
        scores = scores.clamp(-MOST_SCORE, MOST_SCORE).masked_fill(unseen, -torch.inf)
        none = self.none(hidden).clamp(-MOST_SCORE, MOST_SCORE)
        total = none.exp().index_add(0, target, scores.exp()).log()
        shape = (-1, len(SURFACES), EMBEDDING_SIZE)
        return Mixture(
            self.trunk.linear2(hidden).reshape(shape),
            _scale(self.own_scale(hidden)).reshape(shape),
            _scale(self.copy_scale),
            none - total,
            scores - total[target],
        )


def _scale(raw: Tensor) -> Tensor:
    """Return scales of logarithms."""
    return raw.clamp(max=MOST_LOG_SCALE).exp() + LEAST_SCALE


def log_likelihood(mixture: Mixture, inputs: Inputs, values: Tensor, wanted: Tensor) -> Tensor:
    """Return log densities of the `wanted` surfaces' true embeddings.

    Parameters
    ----------
    values : (n, 3, 11) float32, true standardised embeddings, those of visible surfaces included
    wanted : (n, 3) bool
    """
    target, source = inputs.pairs
    own = _laplace(values - mixture.own, mixture.own_scale) + mixture.log_own
    copies = _laplace(values[target] - values[source], mixture.copy_scale) + mixture.log_copies
    top = own.detach().clone()
    top = top.scatter_reduce(0, target[:, None].expand_as(copies), copies.detach(), "amax")
    total = (own - top).exp().index_add(0, target, (copies - top[target]).exp())
    return (total.log() + top)[wanted]


def _laplace(gap: Tensor, scale: Tensor) -> Tensor:
    """Return log densities, summed over the last axis."""
    return -(gap.abs() / scale + (2.0 * scale).log()).sum(-1)
