"""The gated graph network that predicts unseen embeddings (paper section 5.4, Li et al. 2016)."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch_geometric.nn import GatedGraphConv

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, NODE_SIZE


class PropagationNetwork(nn.Module):
    """Linear, ReLU, Linear, ReLU, GatedGraphConv, ReLU, Linear, ReLU, Linear.

    Parameter names and shapes are those of the authors' checkpoints.

    Parameters
    ----------
    width : int
        Hidden size (96 in the paper's configuration).
    layers : int
        Message-passing steps (3).

    Shapes
    ------
    x : (n, 48) float32, `graph.HouseGraph.node_features`
    edge_index : (2, m) int64
    returns : (n, 3, 11) float32, embeddings of floor, wall, ceiling
    """

    def __init__(self, width: int = 96, layers: int = 3) -> None:
        super().__init__()
        self.linear1 = nn.Sequential(
            nn.Linear(NODE_SIZE, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.conv1 = GatedGraphConv(width, layers)
        self.linear2 = nn.Sequential(
            nn.Linear(width, width),
            nn.ReLU(),
            nn.Linear(width, len(SURFACES) * EMBEDDING_SIZE),
        )

    def forward(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return the predicted embedding of every surface of every room."""
        return self.regressed(self.hidden(x, edge_index))

    def hidden(self, x: Tensor, edge_index: Tensor) -> Tensor:
        """Return what the network knows of every room, (n, width)."""
        return torch.relu(self.conv1(self.linear1(x), edge_index))

    def regressed(self, hidden: Tensor) -> Tensor:
        """Return the embeddings (n, 3, 11) of hidden states (n, width)."""
        return self.linear2(hidden).reshape(-1, len(SURFACES), EMBEDDING_SIZE)
