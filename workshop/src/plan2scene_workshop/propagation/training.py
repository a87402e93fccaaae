"""Training of the propagation networks on synthetic houses (paper section 5.4).

A sample hides surfaces, singly or by whole rooms (what a house with unphotographed rooms looks
like), and predicts all that it hid. Each sample starts from the full house: exclusions never
accumulate. The paper's network learns by L1, the pointer network by likelihood.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch_geometric.data import Batch, Data
from torch_geometric.utils import scatter

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.propagation.data import graph_data
from plan2scene.propagation.graph import EMBEDDING_SIZE, HouseGraph
from plan2scene.propagation.model import NETWORKS, Network
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import Mixture, PointerNetwork
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, cosine

#: Shares of surfaces hidden, as often as listed: the authors' public configuration has
#: (0, 0, 0, .2, .2, .4, .6), which the benchmark's houses with .6 hidden lie at the edge of.
DROP_FRACTIONS = (0.0, 0.2, 0.4, 0.6, 0.6, 0.8)


def hide(graph: HouseGraph, rng: np.random.Generator, room_share: float) -> np.ndarray:
    """Return which surfaces stay visible, (n, 3) bool; at least one is hidden."""
    visible = graph.observed.copy()
    fraction = DROP_FRACTIONS[rng.integers(len(DROP_FRACTIONS))]
    if rng.random() < room_share:
        visible[rng.random(len(visible)) < fraction] = False
    else:
        visible &= rng.random(visible.shape) >= fraction
    visible[rng.integers(len(visible)), rng.integers(len(SURFACES))] = False
    return visible


class Houses:
    """Houses with standardised embeddings; `room_share` of their samples hide whole rooms."""

    def __init__(self, graphs: Sequence[HouseGraph], room_share: float) -> None:
        self.graphs, self.room_share = graphs, room_share
        self.full = [graph_data(graph) for graph in graphs]

    def draw(self, count: int, rng: np.random.Generator) -> Batch:
        """Return `count` houses as one disjoint graph; ``hidden`` (n, 3) are to predict."""
        chosen = rng.integers(len(self.graphs), size=count)
        return Batch.from_data_list([self._sample(int(k), rng) for k in chosen])

    def _sample(self, k: int, rng: np.random.Generator) -> Data:
        graph, sample = self.graphs[k], copy(self.full[k])
        visible = hide(graph, rng, self.room_share)
        sample.x = torch.tensor(graph.node_features(visible))
        sample.hidden = torch.from_numpy(graph.observed & ~visible)
        return sample


def surface_losses(network: Network, data: Data) -> Tensor:
    """Return the losses of the hidden surfaces: negative log likelihood, or the paper's L1."""
    if isinstance(network, PointerNetwork):
        return -log_likelihood(network(data), data)[data.hidden]
    output = network(data.x, data.edge_index)
    return (output - data.embeddings).abs().mean(2)[data.hidden]


def log_likelihood(mixture: Mixture, data: Data) -> Tensor:
    """Return log densities (n, 3) of the surfaces' true embeddings, ``data.embeddings``."""
    values, (source, target) = data.embeddings, data.pair_index
    own = _laplace(values - mixture.own, mixture.own_scale) + mixture.log_own
    copies = _laplace(values[target] - values[source], mixture.copy_scale) + mixture.log_copies
    parts = torch.cat([own, copies])
    rows = torch.cat([torch.arange(len(values)), target])
    top = scatter(parts.detach(), rows, dim_size=len(values), reduce="max")
    total = scatter((parts - top[rows]).exp(), rows, dim_size=len(values), reduce="sum")
    return total.log() + top


def _laplace(gap: Tensor, scale: Tensor) -> Tensor:
    """Return log densities, summed over the last axis."""
    return -(gap.abs() / scale + (2.0 * scale).log()).sum(-1)


def scale_of(graphs: Sequence[HouseGraph]) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and deviation, (11,) float32, of the observed surfaces' embeddings."""
    values = np.concatenate([graph.embeddings[graph.observed] for graph in graphs])
    return values.mean(axis=0), values.std(axis=0) + 1e-6


@torch.no_grad()
def fold(network: Network, centre: np.ndarray, deviation: np.ndarray) -> None:
    """Make a network of standardised embeddings one of raw embeddings, in place.

    The pointer network keeps the scale. In the paper's, first and last layer are rewritten,
    exactly: a surface's presence flag is an input beside its values, so the shift by the mean
    moves into the flag's weight and no layer is added.
    """
    mean, spread = torch.from_numpy(centre), torch.from_numpy(deviation)
    if isinstance(network, PointerNetwork):
        network.centre.copy_(mean)
        network.deviation.copy_(spread)
        return
    shape = (len(SURFACES), EMBEDDING_SIZE)
    state = network.state_dict()
    # A surface's inputs are its flag, then its values.
    blocks = state["linear1.0.weight"][:, len(ROOM_TYPES) :].unflatten(1, (shape[0], -1))
    blocks[..., 1:] /= spread
    blocks[..., 0] -= blocks[..., 1:] @ mean
    state["linear2.2.weight"].unflatten(0, shape).mul_(spread[:, None])
    state["linear2.2.bias"].unflatten(0, shape).mul_(spread).add_(mean)


def train_network(
    graphs: Sequence[HouseGraph],
    held_out: Sequence[HouseGraph],
    settings: PropagationSettings,
    seed: int,
    *,
    checkpoint: Path | None = None,
    run: object = None,
) -> Trained[PropagationNetwork | PointerNetwork]:
    """Return the network that does best on `held_out`.

    Graphs hold raw embeddings; so do the returned network's input and output. `checkpoint` is
    continued where it is of this run; `run` tells these graphs from others.
    """
    torch.manual_seed(derive_seed(seed, "propagation weights"))
    network: Network = NETWORKS[settings.network]()
    centre, deviation = scale_of(graphs)

    def houses(raw: Sequence[HouseGraph], room_share: float) -> Houses:
        kept = raw if settings.doors else without_doors(raw)
        return Houses([graph.standardised(centre, deviation) for graph in kept], room_share)

    stream = houses(graphs, settings.room_drop_share)
    trial, rng = houses(held_out, 1.0), generator(seed, "propagation held out")
    trials = [trial.draw(len(held_out), rng) for _ in range(3)]

    def loss(step: int, rng: np.random.Generator) -> dict[str, Tensor]:
        return {"hidden": surface_losses(network, stream.draw(settings.batch, rng)).mean()}

    def evaluate(network: Network) -> float:
        return -float(torch.cat([surface_losses(network, sample) for sample in trials]).mean())

    steps = settings.steps
    options = TrainerOptions(
        "propagation",
        seed,
        steps,
        lambda step: cosine(step, steps, floor=0.0),
        clip_norm=2.0,
        evaluate_every=250,
    )
    optimiser = torch.optim.AdamW(
        network.parameters(), settings.learning_rate, weight_decay=settings.weight_decay
    )
    trainer = Trainer(network, loss, optimiser, options, evaluate=evaluate, run=(settings, run))
    trainer.resume(checkpoint)
    trained = trainer.fit(checkpoint)
    fold(trained.network, centre, deviation)
    return trained


def without_doors(graphs: Sequence[HouseGraph]) -> list[HouseGraph]:
    """Return graphs of the same rooms without edges."""
    return [replace(graph, edges=graph.edges[:, :0]) for graph in graphs]
