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
from torch_geometric.data import Data
from torch_geometric.nn import MessagePassing

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.propagation.data import PAIR_SIZE
from plan2scene.propagation.graph import EMBEDDING_SIZE
from plan2scene.propagation.network import PropagationNetwork

#: Bounds of scores and scales: no component may become a spike.
_MOST_SCORE, _MOST_LOG_SCALE, _LEAST_SCALE = 15.0, 2.0, 0.02
_KINDS = len(SURFACES)


@dataclass(frozen=True)
class Mixture:
    """Predictions of every surface of n rooms, over p pairs of rooms.

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


class PointerNetwork(MessagePassing):
    """Attention over pairs of rooms that may also point at none: houses -> mixtures.

    All embeddings are standardised by `centre` and `deviation`, which the network keeps.

    Parameters
    ----------
    width, layers : int
        Of the paper's network, which is the trunk.
    pair_width : int
        Hidden units that score a pair of rooms.
    """

    def __init__(self, width: int = 96, layers: int = 3, pair_width: int = 64) -> None:
        super().__init__(aggr="sum")
        self.trunk = PropagationNetwork(width, layers)
        self.pair = nn.Sequential(
            nn.Linear(2 * width + PAIR_SIZE, pair_width), nn.ReLU(), nn.Linear(pair_width, _KINDS)
        )
        self.none = nn.Linear(width, _KINDS)
        self.own_scale = nn.Linear(width, _KINDS * EMBEDDING_SIZE)
        self.copy_scale = nn.Parameter(torch.full((_KINDS, EMBEDDING_SIZE), -1.0))
        self.centre: Tensor
        self.deviation: Tensor
        self.register_buffer("centre", torch.zeros(EMBEDDING_SIZE))
        self.register_buffer("deviation", torch.ones(EMBEDDING_SIZE))

    def forward(self, data: Data) -> Mixture:
        """Return the mixture of every surface of every room of :func:`data.graph_data`."""
        hidden = self.trunk.hidden(data.x, data.edge_index)
        blocks = data.x[:, len(ROOM_TYPES) :].reshape(len(hidden), _KINDS, -1)
        scores = self.edge_updater(
            data.pair_index, hidden=hidden, unseen=blocks[..., 0] == 0, pair_attr=data.pair_attr
        )
        none = _bounded(self.none(hidden))
        # A softmax by its logarithms: training needs those of weights that are nothing, too.
        size = (len(hidden), len(hidden))
        total = (none.exp() + self.propagate(data.pair_index, scores=scores, size=size)).log()
        return Mixture(
            self.trunk.regressed(hidden),
            _scale(self.own_scale(hidden)).reshape(-1, _KINDS, EMBEDDING_SIZE),
            _scale(self.copy_scale),
            none - total,
            scores - total[data.pair_index[1]],
        )

    def edge_update(
        self, hidden_i: Tensor, hidden_j: Tensor, unseen_j: Tensor, pair_attr: Tensor
    ) -> Tensor:
        """Return scores (p, 3) of being like room j; -inf where its surface is not visible."""
        scores = self.pair(torch.cat([hidden_i, hidden_j, pair_attr], dim=1))
        return _bounded(scores).masked_fill(unseen_j, -torch.inf)

    def message(self, scores: Tensor) -> Tensor:
        """Return what each pair adds to the sum over the rooms looked at."""
        return scores.exp()


def _bounded(scores: Tensor) -> Tensor:
    return scores.clamp(-_MOST_SCORE, _MOST_SCORE)


def _scale(raw: Tensor) -> Tensor:
    """Return scales of logarithms."""
    return raw.clamp(max=_MOST_LOG_SCALE).exp() + _LEAST_SCALE
