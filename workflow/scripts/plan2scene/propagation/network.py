"""The gated graph network that predicts unseen embeddings (paper section 4.3, Li et al. 2016)."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch
from torch import Tensor, nn

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, NODE_SIZE


class GatedConv(nn.Module):
    """The gated graph layer (Li et al. 2016, arXiv:1511.05493), as PyTorch Geometric has it.

    Same parameters and results as ``torch_geometric.nn.GatedGraphConv``, with which the networks
    are trained: importing that package takes longer than a house's predictions by far.

    Parameters
    ----------
    width, layers : int
        Values per node, message-passing steps.
    """

    def __init__(self, width: int, layers: int) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.empty(layers, width, width))
        nn.init.uniform_(self.weight, -1.0 / math.sqrt(width), 1.0 / math.sqrt(width))
        self.rnn = nn.GRUCell(width, width)

    def forward(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return (n, width) of (n, width) node values and (2, m) edges, source row first."""
        source, target = edge_index
        for weight in self.weight:
            messages = (x @ weight)[source]
            x = self.rnn(torch.zeros_like(x).index_add(0, target, messages), x)
        return x


class PropagationNetwork(nn.Module):
    """Linear, ReLU, Linear, ReLU, GatedGraphConv, ReLU, Linear, ReLU, Linear.

    Parameter names and shapes are those of the authors' checkpoints.

    Parameters
    ----------
    width : int
        Hidden size (96 in the paper's configuration).
    layers : int
        Message-passing steps (3).
    conv : callable
        Makes the graph layer of (width, layers).

    Shapes
    ------
    x : (n, 48) float32, `graph.HouseGraph.node_features`
    edge_index : (2, m) int64
    returns : (n, 3, 11) float32, embeddings of floor, wall, ceiling
    """

    def __init__(
        self,
        width: int = 96,
        layers: int = 3,
        conv: Callable[[int, int], nn.Module] = GatedConv,
    ) -> None:
        super().__init__()
        self.linear1 = nn.Sequential(
            nn.Linear(NODE_SIZE, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.conv1 = conv(width, layers)
        self.linear2 = nn.Sequential(
            nn.Linear(width, width),
            nn.ReLU(),
            nn.Linear(width, len(SURFACES) * EMBEDDING_SIZE),
        )

    def forward(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return the predicted embedding of every surface of every room."""
        return self.linear2(self.hidden(x, edge_index)).reshape(-1, len(SURFACES), EMBEDDING_SIZE)

    def hidden(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return what the network knows of every room, (n, width)."""
        return torch.relu(self.conv1(self.linear1(x), edge_index))
