"""The networks that predict unobserved surfaces, and their weight files.

The paper's network (section 5.4) is a gated graph network (Li et al. 2016) over the rooms. It
regresses one embedding per surface. If the material is uncertain, the embedding is a mean of
several materials and looks like none. The pointer network therefore also scores the house's visible
surfaces of the same kind, from the same hidden states. Its prediction is a mixture of Laplace
distributions: one around each visible surface's embedding (after pointer networks, Vinyals et al.
2015, arXiv:1506.03134, and mixture density networks, Bishop 1994), one around the regressed
embedding. The total weight of the visible surfaces is the confidence; the mixture's median is a
sharp prediction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor, nn
from torch_geometric.data import Data
from torch_geometric.nn import GatedGraphConv, MessagePassing

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, NODE_SIZE, HouseGraph, doors_between
from plan2scene.propagation.type_means import TypeMeans
from plan2scene.weights import filled, load_model_file, save_model_file

#: Facts about a pair of rooms: flags for 1, 2, 3, more (or no path) doors between; types in common.
PAIR_SIZE = 5
_FAR = 4


def graph_data(graph: HouseGraph) -> Data:
    """Return a house in the form that the networks take.

    ``x`` is (n, 48) float32, ``edge_index`` (2, m) int64, ``pair_index`` (2, p) int64 and
    ``pair_attr`` (p, 5) float32 are :func:`room_pairs`, ``embeddings`` (n, 3, 11) float32.
    """
    pairs, facts = room_pairs(graph)
    # Copies: numpy's memory alignment differs from run to run and changes how products round.
    return Data(
        x=torch.tensor(graph.node_features(graph.observed)),
        edge_index=torch.tensor(graph.edges),
        pair_index=torch.tensor(pairs),
        pair_attr=torch.tensor(facts),
        embeddings=torch.tensor(graph.embeddings),
    )


def room_pairs(graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
    """Return all ordered pairs of different rooms and the facts about each pair.

    Pairs (2, p) int64: row of the source room, whose surfaces are scored, and row of the target
    room, whose surfaces are predicted. Facts (p, 5) float32.
    """
    count = len(graph.room_ids)
    target, source = np.nonzero(~np.eye(count, dtype=bool))
    doors = np.minimum(doors_between(count, graph.edges)[target, source], _FAR).astype(np.int64)
    facts = np.zeros((len(target), PAIR_SIZE), dtype=np.float32)
    facts[np.arange(len(target)), doors - 1] = 1.0
    common = np.minimum(graph.types[target], graph.types[source]).sum(axis=1)
    facts[:, PAIR_SIZE - 1] = common / np.maximum(graph.types[target].sum(axis=1), 1.0)
    return np.stack([source, target]).astype(np.int64), facts


class PropagationNetwork(nn.Module):
    """Linear, ReLU, Linear, ReLU, GatedGraphConv, ReLU, Linear, ReLU, Linear.

    `HouseGraph.node_features` (n, 48) float32 and edges (2, m) int64 -> embeddings (n, 3, 11)
    float32 of floor, wall, ceiling. `width` is the hidden size (96 in the paper), `layers` the
    steps of message passing (3). Parameter names and shapes are those of the authors' checkpoints.
    """

    def __init__(self, width: int = 96, layers: int = 3) -> None:
        super().__init__()
        self.linear1 = nn.Sequential(
            nn.Linear(NODE_SIZE, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.conv1 = GatedGraphConv(width, layers)
        self.linear2 = nn.Sequential(
            nn.Linear(width, width), nn.ReLU(), nn.Linear(width, len(SURFACES) * EMBEDDING_SIZE)
        )

    def forward(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return the predicted embedding of every surface of every room."""
        return self.regressed(self.hidden(x, edge_index))

    def hidden(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return the hidden states of the rooms, (n, width)."""
        return torch.relu(self.conv1(self.linear1(x), edge_index))

    def regressed(self, hidden: Tensor) -> Tensor:
        """Return the embeddings (n, 3, 11) of hidden states (n, width)."""
        return self.linear2(hidden).reshape(-1, len(SURFACES), EMBEDDING_SIZE)


_KINDS = len(SURFACES)


@dataclass(frozen=True)
class Mixture:
    """Predictions of every surface of n rooms, over p pairs of rooms. All are float32."""

    own: Tensor  #: (n, 3, 11), the embeddings that the paper's network regresses
    own_scale: Tensor  #: (n, 3, 11), scale of the Laplace distribution around it
    copy_scale: Tensor  #: (3, 11), scale of the distributions around visible surfaces
    log_own: Tensor  #: (n, 3), log weight of `own`
    log_copies: Tensor  #: (p, 3), log weight of each pair's source room; -inf: not visible


@dataclass(frozen=True)
class PointerBounds:
    """Bounds of a mixture, in standardised embeddings; they prevent very narrow distributions."""

    score: float = 15.0  #: largest absolute log weight before normalisation
    log_scale: float = 2.0  #: largest log scale of a Laplace distribution
    least_scale: float = 0.02  #: added to every scale


_BOUNDS = PointerBounds()


class PointerNetwork(MessagePassing):
    """Attention from each room to the others, or to none of them: houses -> mixtures.

    All embeddings are standardised by the buffers `centre` and `deviation`. `width` and `layers`
    are those of the paper's network, which is the trunk. A layer of `pair_width` hidden units
    scores the pairs of rooms.
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
        """Return the mixture of every surface of every room of :func:`graph_data`."""
        hidden = self.trunk.hidden(data.x, data.edge_index)
        blocks = data.x[:, len(ROOM_TYPES) :].reshape(len(hidden), _KINDS, -1)
        scores = self.edge_updater(
            data.pair_index, hidden=hidden, unseen=blocks[..., 0] == 0, pair_attr=data.pair_attr
        )
        none = _bounded(self.none(hidden))
        # Softmax in log space: training also needs the logarithms of weights near zero.
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
        """Return scores (p, 3) for being like room j's surface; -inf where that is not visible."""
        scores = self.pair(torch.cat([hidden_i, hidden_j, pair_attr], dim=1))
        return _bounded(scores).masked_fill(unseen_j, -torch.inf)

    def message(self, scores: Tensor) -> Tensor:
        """Return what each pair adds to its target room's sum over the source rooms."""
        return scores.exp()


def _bounded(scores: Tensor) -> Tensor:
    return scores.clamp(-_BOUNDS.score, _BOUNDS.score)


def _scale(raw: Tensor) -> Tensor:
    """Return bounded scales from their logarithms."""
    return raw.clamp(max=_BOUNDS.log_scale).exp() + _BOUNDS.least_scale


Network: TypeAlias = PropagationNetwork | PointerNetwork
#: Networks by their name in weight files: the paper's, and that of the embedded weights.
NETWORKS: Mapping[str, type[PropagationNetwork] | type[PointerNetwork]] = {
    "gated": PropagationNetwork,
    "pointer": PointerNetwork,
}
_NETWORK, _PRIOR = "network.", "prior."


def save_propagation(path: str | Path, network: Network, means: TypeMeans, **sizes: int) -> None:
    """Write network and means as one safetensors file (float32: it is small).

    `sizes` are the arguments of the network's constructor.
    """
    kind = next(name for name, cls in NETWORKS.items() if type(network) is cls)
    state = {_NETWORK + name: value for name, value in network.state_dict().items()}
    state[_PRIOR + "embedding"] = torch.from_numpy(means.embedding)
    state[_PRIOR + "naive"] = torch.from_numpy(means.naive)
    save_model_file(path, state, {"network": kind, **sizes}, half=False)


def load_propagation(path: str | Path) -> tuple[Network, TypeMeans]:
    """Return network and means from a file of :func:`save_propagation`; else InputError."""
    state, sizes = load_model_file(path)
    kind = str(sizes.pop("network", "gated"))
    if kind not in NETWORKS:
        raise InputError(f"a propagation network of {', '.join(NETWORKS)}", str(kind), file=path)
    weights = {k.removeprefix(_NETWORK): v for k, v in state.items() if k.startswith(_NETWORK)}
    network = filled(lambda: NETWORKS[kind](**sizes), weights, "a propagation network", path)
    means = [state.get(_PRIOR + name) for name in ("embedding", "naive")]
    if means[0] is None or means[1] is None:
        raise InputError("means by room type", "none", file=path)
    return network, TypeMeans(means[0].numpy(), means[1].numpy())
