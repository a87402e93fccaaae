"""What the house's own surfaces tell of unseen ones, and when the network is heard."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from plan2scene.house import ROOM_TYPES
from plan2scene.paint.observations import HouseColours
from plan2scene.propagation import predictors
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.graph_networks import PropagationNetwork
from plan2scene.propagation.predictors import PREDICTORS, Prediction, house_evidence, network_share
from plan2scene.propagation.type_means import TypeMeans

ROOMS = 5
MEANS = TypeMeans(
    np.full((len(ROOM_TYPES), 3, 11), 0.8, np.float32),
    np.zeros((len(ROOM_TYPES), 3, 8), np.float32),
)


def house(colours: np.ndarray, seen: np.ndarray) -> HouseGraph:
    """Return rooms in a row whose surfaces have these colours, (5, 3) grey values."""
    values = np.zeros((ROOMS, 3, 11), np.float32)
    values[..., -3:] = colours[..., None]
    types = np.eye(len(ROOM_TYPES), dtype=np.float32)[:ROOMS]
    edges = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    both = np.concatenate([edges, edges[::-1]], axis=1)
    names = tuple(f"r{k}" for k in range(ROOMS))
    return HouseGraph(names, types, both, values * seen[..., None], seen)


def alike() -> HouseGraph:
    """Return a dim house whose grey ceilings agree; the last room shows nothing but its floor."""
    seen = np.ones((ROOMS, 3), bool)
    seen[-1, 1:] = False
    return house(np.tile([0.3, 0.5, 0.45], (ROOMS, 1)), seen)


def shown(graph: HouseGraph) -> HouseColours:
    """Return what the graph's surfaces tell."""
    return HouseColours.of_embeddings(graph.embeddings, graph.observed)


def evidence(graph: HouseGraph) -> np.ndarray:
    return house_evidence(graph, MEANS, shown(graph))


def share(graph: HouseGraph, value: float) -> float:
    return network_share(graph, stubborn(value), MEANS, shown(graph))


def stubborn(value: float) -> PropagationNetwork:
    """Return a network that answers one value to everything."""
    network = PropagationNetwork().eval()
    with torch.no_grad():
        network.linear2[-1].weight.zero_()
        network.linear2[-1].bias.fill_(value)
    return network


def test_an_unseen_ceiling_follows_the_seen_ones():
    found = evidence(alike())
    assert found[-1, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)
    # As if not seen: what a surface itself looks like is not in its prediction.
    odd = alike()
    odd.embeddings[0, 2, -3:] = 0.9
    assert evidence(odd)[0, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)


def test_a_network_that_is_wrong_in_this_house_is_not_heard():
    graph = alike()
    assert share(graph, 0.95) < 1e-3
    embedding = PREDICTORS["house"](graph, stubborn(0.95), MEANS).embedding
    assert embedding[-1, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)


def test_a_network_that_is_right_in_this_house_is_heard(monkeypatch):
    colours = np.random.default_rng(0).uniform(0.1, 0.9, (ROOMS, 3))
    graph = house(colours, np.ones((ROOMS, 3), bool))
    nan = np.full((ROOMS, 3), np.nan, np.float32)
    known = Prediction(graph.embeddings, nan, np.full((ROOMS, 3), -1))
    monkeypatch.setattr(predictors, "predict", lambda network, shown: known)
    assert share(graph, 0.5) > 0.99
    blind = replace(graph, observed=np.zeros((ROOMS, 3), bool))
    assert share(blind, 0.5) == pytest.approx(1 / 3)


def test_confidence_grows_with_surfaces_of_the_kind():
    graph = alike()
    sure = PREDICTORS["house"](graph, stubborn(0.95), MEANS).confidence[-1, 2]
    few = graph.observed.copy()
    few[1:, 2] = False
    less = replace(graph, observed=few, embeddings=graph.embeddings * few[..., None])
    assert 0 < PREDICTORS["house"](less, stubborn(0.95), MEANS).confidence[-1, 2] < sure < 1


@pytest.mark.parametrize("name", sorted(PREDICTORS))
def test_every_predictor_predicts_every_surface(name):
    found = PREDICTORS[name](alike(), stubborn(0.6), MEANS)
    assert found.embedding.shape == (ROOMS, 3, 11)
    assert found.confidence.shape == found.alike.shape == (ROOMS, 3)
    assert ((found.embedding[..., -3:] >= 0) & (found.embedding[..., -3:] <= 1)).all()
