"""Training samples hide what they should, and folding the scale changes nothing."""

import numpy as np
import pytest
import torch

from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.model import network_of
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import PointerNetwork
from plan2scene.propagation.predict import predict
from plan2scene_workshop.propagation.measure import (
    confidence_table,
    error_table,
    hidden_errors,
    network_predictor,
    simple_predictors,
)
from plan2scene_workshop.propagation.training import (
    DROP_FRACTIONS,
    PropagationSettings,
    Scale,
    batches,
    hide,
    train_network,
    type_means,
    without_doors,
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
    assert abs(np.mean(shares) - np.mean(DROP_FRACTIONS)) < 0.03
    rooms = hide(graph, np.random.default_rng(3), 1.0)
    # Whole rooms are hidden, but for the one surface that always is.
    assert sum(0 < row.sum() < 3 for row in rooms) <= 1


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


def test_the_pointer_network_keeps_the_scale():
    rng = np.random.default_rng(1)
    graphs = [house_of_one_colour(rng) for _ in range(5)]
    scale = Scale.of(graphs)
    torch.manual_seed(0)
    network = PointerNetwork().eval()
    before = predict(network_of(network), scale.apply(graphs[0])).embedding
    scale.fold(network)
    after = predict(network_of(network), graphs[0]).embedding
    unclipped = np.s_[..., :8]
    raw = before * scale.deviation + scale.mean
    assert np.allclose(raw[unclipped], after[unclipped], atol=1e-4)


@pytest.mark.parametrize(
    ("network", "steps", "share"), [("pointer", 500, 0.75), ("gated", 1000, 0.88)]
)
def test_training_learns_what_neighbours_tell(network, steps, share):
    rng = np.random.default_rng(2)
    graphs = [house_of_one_colour(rng) for _ in range(120)]
    settings = PropagationSettings(network=network, steps=steps, batch=16, learning_rate=3e-3)
    trained = train_network(graphs[:100], graphs[100:], settings)
    predictors = simple_predictors(type_means(graphs[:100]))
    predictors["own"] = network_predictor(trained)
    errors = hidden_errors(predictors, graphs[100:], 0)
    l1 = {name: e.absolute.mean() for name, e in errors.items()}
    # Where something is visible these two are exact in such houses.
    assert l1["house_mean"] == pytest.approx(l1["nearest_room"])
    assert l1["house_mean"] < 0.5 * l1["type_mean"]
    assert l1["own"] < share * l1["type_mean"]
    assert "| own |" in error_table(errors)
    if network == "pointer":  # sure of what it copies, and right about it
        sure = errors["own"].confidence > 0.8
        assert sure.any()
        assert errors["own"].absolute[sure].mean() < 0.2 * l1["type_mean"]
        assert "0.8-1.0" in confidence_table(errors["own"])


def test_batches_keep_houses_apart():
    rng = np.random.default_rng(5)
    graphs = [house_of_one_colour(rng, rooms=3 + k) for k in range(4)]
    sample = next(batches(graphs, PropagationSettings(batch=6), np.random.default_rng(0)))
    first = sample.values[:, 0, 0]
    source, target = sample.inputs.edges
    assert torch.equal(first[source], first[target])  # a house has one value
    assert torch.equal(first[sample.inputs.pairs[0]], first[sample.inputs.pairs[1]])
    assert sample.hidden.any(1).any() and not sample.hidden.all()
    flags = sample.inputs.x[:, 12:].reshape(-1, 3, 12)[..., 0]
    assert torch.equal(flags == 0, sample.hidden)


def test_without_doors_keeps_rooms_only():
    graph = house_of_one_colour(np.random.default_rng(6))
    (bare,) = without_doors([graph])
    assert bare.edges.shape == (2, 0) and bare.room_ids == graph.room_ids


def test_type_means_are_means():
    rng = np.random.default_rng(4)
    graph = house_of_one_colour(rng, rooms=2)
    graph.types[:] = np.eye(12, dtype=np.float32)[[1, 1]]
    graph.embeddings[1] *= 3.0
    means = type_means([graph])
    assert np.allclose(means[1, 0], graph.embeddings[:, 0].mean(axis=0))
    assert np.allclose(means[5, 2], graph.embeddings[:, 2].mean(axis=0))  # no sample: the kind's
