"""Training of the propagation network on synthetic houses (paper section 4.3, method.md).

A sample hides one surface and predicts it; further surfaces are hidden as augmentation, singly
(the paper's fractions) or by whole rooms (what a house with unphotographed rooms looks like).
Each sample starts from the full house: exclusions never accumulate.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, HouseGraph
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.prior import mean_by_type

_LOG = logging.getLogger("plan2scene")

#: Shares of the other surfaces hidden, as often as listed (authors' public configuration).
DROP_FRACTIONS = (0.0, 0.0, 0.0, 0.2, 0.2, 0.4, 0.6)


@dataclass(frozen=True)
class PropagationSettings:
    """How the network is trained."""

    steps: int = 6000  # optimiser steps
    batch: int = 32  # graphs a step (paper: 32)
    learning_rate: float = 5e-4  # Adam (paper: 5e-4), cosine to zero
    weight_decay: float = 1e-4
    room_drop_share: float = 0.5  # samples that hide whole rooms instead of single surfaces
    seed: int = 0


def split_graphs(
    house: np.ndarray, types: np.ndarray, edges: np.ndarray, embeddings: np.ndarray
) -> list[HouseGraph]:
    """Return one graph a house from arrays over all rooms (see ``write_training_houses``)."""
    graphs = []
    for k in np.unique(house):
        rows = np.flatnonzero(house == k)
        start, stop = rows[0], rows[-1] + 1
        mine = (edges[0] >= start) & (edges[0] < stop)
        graphs.append(
            HouseGraph(
                tuple(f"room_{i}" for i in range(len(rows))),
                types[rows],
                edges[:, mine] - start,
                embeddings[rows],
                np.ones((len(rows), len(SURFACES)), dtype=bool),
            )
        )
    return graphs


def hide(graph: HouseGraph, rng: np.random.Generator, room_share: float) -> np.ndarray:
    """Return which surfaces stay visible, (n, 3) bool, before the target is taken out too."""
    visible = graph.observed.copy()
    fraction = DROP_FRACTIONS[rng.integers(len(DROP_FRACTIONS))]
    if rng.random() < room_share:
        visible[rng.random(len(visible)) < fraction] = False
    else:
        visible &= rng.random(visible.shape) >= fraction
    return visible


@dataclass(frozen=True)
class Scale:
    """Mean and deviation of each embedding dimension: training runs on standardised values."""

    mean: np.ndarray  # (11,) float32
    deviation: np.ndarray  # (11,) float32

    @classmethod
    def of(cls, graphs: list[HouseGraph]) -> Scale:
        """Return the scale over all observed surfaces."""
        values = np.concatenate([graph.embeddings[graph.observed] for graph in graphs])
        return cls(values.mean(axis=0), values.std(axis=0) + 1e-6)

    def apply(self, graph: HouseGraph) -> HouseGraph:
        """Return the graph with standardised embeddings (zeros where not observed)."""
        values = (graph.embeddings - self.mean) / self.deviation * graph.observed[..., None]
        return HouseGraph(
            graph.room_ids, graph.types, graph.edges, values.astype(np.float32), graph.observed
        )

    def fold(self, network: PropagationNetwork) -> None:
        """Rewrite the first and last layer in place so that the network takes raw embeddings.

        Exact: a surface's presence flag is an input beside its values, so the shift by the mean
        moves into the flag's weight and no layer is added to the paper's network.
        """
        parameters = dict(network.named_parameters())
        first = parameters["linear1.0.weight"]
        last, last_bias = parameters["linear2.2.weight"], parameters["linear2.2.bias"]
        mean, deviation = torch.from_numpy(self.mean), torch.from_numpy(self.deviation)
        with torch.no_grad():
            for j in range(len(SURFACES)):
                flag = 12 + j * (1 + EMBEDDING_SIZE)
                block = slice(flag + 1, flag + 1 + EMBEDDING_SIZE)
                first[:, block] /= deviation
                first[:, flag] -= first[:, block] @ mean
                out = slice(j * EMBEDDING_SIZE, (j + 1) * EMBEDDING_SIZE)
                last[out] *= deviation[:, None]
                last_bias[out] = last_bias[out] * deviation + mean


def batches(
    graphs: list[HouseGraph], settings: PropagationSettings, rng: np.random.Generator
) -> Iterator[tuple[Tensor, Tensor, Tensor, Tensor, Tensor]]:
    """Yield (x, edge_index, target row, target surface, target value) without end."""
    while True:
        nodes, edges, rows, columns, targets, offset = [], [], [], [], [], 0
        for k in rng.integers(len(graphs), size=settings.batch):
            graph = graphs[k]
            visible = hide(graph, rng, settings.room_drop_share)
            i, j = rng.integers(len(graph.room_ids)), rng.integers(len(SURFACES))
            visible[i, j] = False
            nodes.append(graph.node_features(visible))
            edges.append(graph.edges + offset)
            rows.append(offset + i)
            columns.append(j)
            targets.append(graph.embeddings[i, j])
            offset += len(graph.room_ids)
        yield (
            torch.from_numpy(np.concatenate(nodes)),
            torch.from_numpy(np.concatenate(edges, axis=1)),
            torch.tensor(rows),
            torch.tensor(columns),
            torch.from_numpy(np.stack(targets)),
        )


def train_network(
    graphs: list[HouseGraph], validation: list[HouseGraph], settings: PropagationSettings
) -> tuple[PropagationNetwork, dict[str, float]]:
    """Return the network that did best on `validation`, and held-out figures.

    Graphs hold raw embeddings; so does the returned network's input and output.
    """
    torch.manual_seed(settings.seed)
    scale = Scale.of(graphs)
    scaled, held_out = [scale.apply(g) for g in graphs], [scale.apply(g) for g in validation]
    network = PropagationNetwork()
    optimiser = torch.optim.Adam(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.steps)
    stream = batches(scaled, settings, np.random.default_rng(settings.seed))
    best, best_state = np.inf, network.state_dict()
    for step in range(1, settings.steps + 1):
        x, edge_index, row, column, target = next(stream)
        loss = (network(x, edge_index)[row, column] - target).abs().mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        if step % 500 == 0 or step == settings.steps:
            error = float(np.mean(hidden_errors(network, held_out, settings)["network"]))
            _LOG.info("step %d: training L1 %.4f, held-out L1 %.4f", step, loss.item(), error)
            if error < best:
                best = error
                best_state = {k: v.clone() for k, v in network.state_dict().items()}
    network.load_state_dict(best_state)
    scale.fold(network)
    return network.eval(), {"standardised_l1": best}


def hidden_errors(
    network: PropagationNetwork,
    graphs: list[HouseGraph],
    settings: PropagationSettings,
    means: np.ndarray | None = None,
    repeats: int = 3,
) -> dict[str, np.ndarray]:
    """Return per-sample (11,) absolute errors of hidden surfaces on a fixed set of samples.

    Keys: ``network``, and ``type_mean`` (mean of room and surface type, from `means` (12, 3, 11))
    and ``house_mean`` (mean of the visible surfaces of that kind, else the type mean) where
    `means` is given. Six tenths of the rooms are hidden, as in the paper's Unobserved column.
    """
    rng = np.random.default_rng(settings.seed + 1)
    errors: dict[str, list[np.ndarray]] = {"network": []}
    for graph in graphs * repeats:
        hidden = rng.random(len(graph.room_ids)) < 0.6
        visible = graph.observed & ~hidden[:, None]
        if not hidden.any():
            continue
        with torch.no_grad():
            output = network(
                torch.from_numpy(graph.node_features(visible)), torch.from_numpy(graph.edges)
            ).numpy()
        for i in np.flatnonzero(hidden):
            for j in range(len(SURFACES)):
                truth = graph.embeddings[i, j]
                errors["network"].append(np.abs(output[i, j] - truth))
                if means is None:
                    continue
                prior = means[graph.types[i] > 0, j].mean(axis=0)
                seen = graph.embeddings[visible[:, j], j]
                mean = seen.mean(axis=0) if len(seen) else prior
                errors.setdefault("type_mean", []).append(np.abs(prior - truth))
                errors.setdefault("house_mean", []).append(np.abs(mean - truth))
    return {name: np.array(values) for name, values in errors.items()}


def type_means(graphs: list[HouseGraph]) -> np.ndarray:
    """Return mean embeddings (12, 3, 11) by room and surface type over all graphs."""
    types = np.concatenate([np.repeat(g.types, len(SURFACES), axis=0) for g in graphs])
    surface = np.concatenate([np.tile(np.arange(len(SURFACES)), len(g.room_ids)) for g in graphs])
    values = np.concatenate([g.embeddings.reshape(-1, g.embeddings.shape[-1]) for g in graphs])
    return mean_by_type(types, surface, values)


def load_houses(path: str | Path) -> dict[str, np.ndarray]:
    """Return the arrays of ``write_training_houses``."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}
