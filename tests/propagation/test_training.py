"""Training samples hide what they should, and folding the scale changes nothing."""

import numpy as np
import torch

from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.training.propagation import (
    PropagationSettings,
    Scale,
    hidden_errors,
    hide,
    train_network,
    type_means,
)


def house_of_one_colour(rng: np.random.Generator, rooms: int = 4) -> HouseGraph:
    """Return a chain of rooms that all share one embedding: what a graph can tell."""
    types = np.eye(12, dtype=np.float32)[rng.integers(12, size=rooms)]
    chain = [(i, i + 1) for i in range(rooms - 1)]
    edges = np.array(sorted([*chain, *((b, a) for a, b in chain)])).T
    value = rng.normal(size=11).astype(np.float32)
    embeddings = np.broadcast_to(value, (rooms, 3, 11)).copy()
    ids = tuple(f"r{i}" for i in range(rooms))
    return HouseGraph(ids, types, edges, embeddings, np.ones((rooms, 3), dtype=bool))


def test_hide_never_changes_the_graph_and_follows_the_fractions():
    rng = np.random.default_rng(0)
    graph = house_of_one_colour(rng, rooms=50)
    shares = [1 - hide(graph, rng, 0.0).mean() for _ in range(400)]
    assert graph.observed.all()
    assert abs(np.mean(shares) - np.mean([0, 0, 0, 0.2, 0.2, 0.4, 0.6])) < 0.03
    rooms = hide(graph, np.random.default_rng(3), 1.0)
    assert all(row.all() or not row.any() for row in rooms)


def test_folded_scale_gives_the_same_predictions():
    rng = np.random.default_rng(1)
    graphs = [house_of_one_colour(rng) for _ in range(5)]
    scale = Scale.of(graphs)
    torch.manual_seed(0)
    network = PropagationNetwork()
    visible = np.array([[True, False, True]] * 4)
    scaled = scale.apply(graphs[0])
    edges = torch.from_numpy(graphs[0].edges)
    with torch.no_grad():
        before = network(torch.from_numpy(scaled.node_features(visible)), edges).numpy()
        scale.fold(network)
        after = network(torch.from_numpy(graphs[0].node_features(visible)), edges).numpy()
    assert np.allclose(before * scale.deviation + scale.mean, after, atol=1e-4)


def test_training_learns_what_neighbours_tell():
    rng = np.random.default_rng(2)
    graphs = [house_of_one_colour(rng) for _ in range(120)]
    settings = PropagationSettings(steps=700, batch=16, learning_rate=3e-3)
    network, _ = train_network(graphs[:100], graphs[100:], settings)
    errors = hidden_errors(network, graphs[100:], settings, type_means(graphs[:100]))
    assert errors["network"].mean() < 0.8 * errors["type_mean"].mean()


def test_type_means_are_means():
    rng = np.random.default_rng(4)
    graph = house_of_one_colour(rng, rooms=2)
    graph.types[:] = np.eye(12, dtype=np.float32)[[1, 1]]
    graph.embeddings[1] *= 3.0
    means = type_means([graph])
    assert np.allclose(means[1, 0], graph.embeddings[:, 0].mean(axis=0))
    assert np.allclose(means[5, 2], graph.embeddings[:, 2].mean(axis=0))  # no sample: the kind's
