"""Training of the propagation networks on synthetic houses (paper section 5.4).

A sample hides surfaces, one by one or by whole rooms (as in a house with unphotographed rooms),
and the network predicts all hidden ones. Each sample starts from the full house: hidden surfaces
never accumulate. The loss is L1 for the paper's network, the likelihood for the pointer network.
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
from plan2scene.propagation.graph import EMBEDDING_SIZE, HouseGraph
from plan2scene.propagation.graph_networks import (
    NETWORKS,
    Mixture,
    Network,
    PointerNetwork,
    PropagationNetwork,
    graph_data,
)
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.propagation.light import CORRECTED, PHOTOS, lit
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, cosine

#: Shares of hidden surfaces; each entry is equally likely. The authors' public configuration is
#: (0, 0, 0, .2, .2, .4, .6), but then the benchmark's .6 would be at the edge of the range.
DROP_FRACTIONS = (0.0, 0.2, 0.4, 0.6, 0.6, 0.8)
#: Largest share of surfaces that are hidden in rooms that are not hidden as a whole.
MISSED = 0.4


def hide(graph: HouseGraph, rng: np.random.Generator, room_share: float) -> np.ndarray:
    """Hide random surfaces; return which stay visible, (n, 3) bool. At least one is hidden."""
    visible = graph.observed.copy()
    fraction = DROP_FRACTIONS[rng.integers(len(DROP_FRACTIONS))]
    if rng.random() < room_share:
        visible[rng.random(len(visible)) < fraction] = False
        visible &= rng.random(visible.shape) >= rng.uniform(0.0, MISSED)
    else:
        visible &= rng.random(visible.shape) >= fraction
    visible[rng.integers(len(visible)), rng.integers(len(SURFACES))] = False
    return visible


class Houses:
    """Houses to draw samples from, each in new random light, with standardised embeddings.

    `settings` give the shares of samples that hide whole rooms and of each light; `scale` is the
    embeddings' mean and standard deviation.
    """

    def __init__(
        self,
        graphs: Sequence[HouseGraph],
        settings: PropagationSettings,
        scale: tuple[np.ndarray, np.ndarray],
    ) -> None:
        self.graphs, self.settings, self.scale = graphs, settings, scale
        self.full = [graph_data(graph) for graph in graphs]

    def draw(self, count: int, rng: np.random.Generator) -> Batch:
        """Return `count` houses as one disjoint graph; ``hidden`` (n, 3) marks what to predict.

        ``embeddings`` (n, 3, 11) are those from photos, ``truth`` the true ones.
        """
        chosen = rng.integers(len(self.graphs), size=count)
        return Batch.from_data_list([self._sample(int(k), rng) for k in chosen])

    def _sample(self, k: int, rng: np.random.Generator) -> Data:
        graph, sample = self.graphs[k], copy(self.full[k])
        light = PHOTOS if rng.random() < self.settings.photo_light_share else CORRECTED
        told, truth = lit(graph, rng, light)
        shown = replace(graph, embeddings=told).standardised(*self.scale)
        visible = hide(graph, rng, self.settings.room_drop_share)
        sample.x = torch.tensor(shown.node_features(visible))
        sample.embeddings = torch.tensor(shown.embeddings)
        truth = replace(graph, embeddings=truth).standardised(*self.scale).embeddings
        sample.truth = torch.tensor(truth)
        sample.hidden = torch.from_numpy(graph.observed & ~visible)
        return sample


def surface_losses(network: Network, data: Data) -> Tensor:
    """Return the loss of each hidden surface: negative log likelihood, or the paper's L1."""
    if isinstance(network, PointerNetwork):
        return -log_likelihood(network(data), data)[data.hidden]
    output = network(data.x, data.edge_index)
    return (output - data.truth).abs().mean(2)[data.hidden]


def log_likelihood(mixture: Mixture, data: Data) -> Tensor:
    """Return the log densities (n, 3) of ``data.truth`` under the mixture."""
    truth, (source, target) = data.truth, data.pair_index
    own = _laplace(truth - mixture.own, mixture.own_scale) + mixture.log_own
    apart = truth[target] - data.embeddings[source]
    copies = _laplace(apart, mixture.copy_scale) + mixture.log_copies
    parts = torch.cat([own, copies])
    rows = torch.cat([torch.arange(len(truth)), target])
    top = scatter(parts.detach(), rows, dim_size=len(truth), reduce="max")
    total = scatter((parts - top[rows]).exp(), rows, dim_size=len(truth), reduce="sum")
    return total.log() + top


def _laplace(gap: Tensor, scale: Tensor) -> Tensor:
    """Return log densities of the Laplace distribution, summed over the last axis."""
    return -(gap.abs() / scale + (2.0 * scale).log()).sum(-1)


def scale_of(graphs: Sequence[HouseGraph]) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard deviation, (11,) float32, of surface embeddings in photos' light."""
    rng = generator(0, "scale")
    values = np.concatenate([lit(graph, rng, PHOTOS)[1][graph.observed] for graph in graphs])
    return values.mean(axis=0), values.std(axis=0) + 1e-6


@torch.no_grad()
def fold(network: Network, centre: np.ndarray, deviation: np.ndarray) -> None:
    """Change a network for standardised embeddings into one for raw embeddings, in place.

    The pointer network stores the scale. In the paper's network the scale is folded exactly into
    the weights of the first and last layer: each surface has a presence flag as an input beside its
    values, so the shift by the mean goes into the flag's weight.
    """
    mean, spread = torch.from_numpy(centre), torch.from_numpy(deviation)
    if isinstance(network, PointerNetwork):
        network.centre.copy_(mean)
        network.deviation.copy_(spread)
        return
    shape = (len(SURFACES), EMBEDDING_SIZE)
    state = network.state_dict()
    # The inputs of a surface are its flag, then its values.
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
    """Train; return the network with the lowest loss on `held_out`.

    The graphs, and the returned network's input and output, have raw embeddings. Training continues
    from `checkpoint` if it is of this run; `run` identifies the graphs.
    """
    torch.manual_seed(derive_seed(seed, "propagation weights"))
    network: Network = NETWORKS[settings.network]()
    scale = scale_of(graphs)
    if not settings.doors:
        graphs, held_out = without_doors(graphs), without_doors(held_out)
    stream = Houses(graphs, settings, scale)
    trial = Houses(held_out, replace(settings, room_drop_share=1.0), scale)
    rng = generator(seed, "propagation held out")
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
    fold(trained.network, *scale)
    return trained


def without_doors(graphs: Sequence[HouseGraph]) -> list[HouseGraph]:
    """Return the graphs without their edges."""
    return [replace(graph, edges=graph.edges[:, :0]) for graph in graphs]
