from dataclasses import replace

import numpy as np
import pytest
import torch

from plan2scene.house import ROOM_TYPES
from plan2scene.paint.observations import HouseColours
from plan2scene.propagation import predictors
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.graph_networks import PropagationNetwork
from plan2scene.propagation.type_means import TypeMeans

ROOMS = 5
MEANS = TypeMeans(
    np.full((len(ROOM_TYPES), 3, 11), 0.8, np.float32),
    np.zeros((len(ROOM_TYPES), 3, 8), np.float32),
)


def house(colours, seen):
    """Return rooms in a row whose surfaces have these colours, (5, 3) grey values."""
    values = np.zeros((ROOMS, 3, 11), np.float32)
    values[..., -3:] = colours[..., None]
    types = np.eye(len(ROOM_TYPES), dtype=np.float32)[:ROOMS]
    edges = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    both = np.concatenate([edges, edges[::-1]], axis=1)
    names = tuple(f"r{k}" for k in range(ROOMS))
    return HouseGraph(names, types, both, values * seen[..., None], seen)


def alike():
    """Return a dim house whose grey ceilings agree; the last room shows nothing but its floor."""
    seen = np.ones((ROOMS, 3), bool)
    seen[-1, 1:] = False
    return house(np.tile([0.3, 0.5, 0.45], (ROOMS, 1)), seen)


def shown(graph):
    return HouseColours.of_embeddings(graph.embeddings, graph.observed)


def evidence(graph):
    return predictors.house_evidence(graph, MEANS, shown(graph))


def share(graph, value):
    return predictors.network_share(graph, stubborn(value), MEANS, shown(graph))


def stubborn(value):
    """Return a network that answers one value to everything."""
    network = PropagationNetwork().eval()
    with torch.no_grad():
        network.linear2[-1].weight.zero_()
        network.linear2[-1].bias.fill_(value)
    return network


def test_an_unseen_ceiling_follows_the_seen_ones():
    assert evidence(alike())[-1, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)
    # As if not seen: what a surface itself looks like is not in its prediction.
    odd = alike()
    odd.embeddings[0, 2, -3:] = 0.9
    assert evidence(odd)[0, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)


def test_a_network_is_heard_as_it_is_right_in_this_house(monkeypatch):
    graph = alike()
    assert share(graph, 0.95) < 1e-3
    embedding = predictors.PREDICTORS["house"](graph, stubborn(0.95), MEANS).embedding
    assert embedding[-1, 2, -3:] == pytest.approx(np.full(3, 0.45), abs=0.03)
    graph = house(np.random.default_rng(0).uniform(0.1, 0.9, (ROOMS, 3)), np.ones((ROOMS, 3), bool))
    nan = np.full((ROOMS, 3), np.nan, np.float32)
    known = predictors.Prediction(graph.embeddings, nan, np.full((ROOMS, 3), -1))
    monkeypatch.setattr(predictors, "predict", lambda network, shown: known)
    assert share(graph, 0.5) > 0.99
    assert share(replace(graph, observed=np.zeros((ROOMS, 3), bool)), 0.5) == pytest.approx(1 / 3)


def test_confidence_grows_with_surfaces_of_the_kind():
    graph = alike()
    sure = predictors.PREDICTORS["house"](graph, stubborn(0.95), MEANS).confidence[-1, 2]
    few = graph.observed.copy()
    few[1:, 2] = False
    less = replace(graph, observed=few, embeddings=graph.embeddings * few[..., None])
    found = predictors.PREDICTORS["house"](less, stubborn(0.95), MEANS)
    assert 0 < found.confidence[-1, 2] < sure < 1


@pytest.mark.parametrize("name", sorted(predictors.PREDICTORS))
def test_every_predictor_predicts_every_surface(name):
    found = predictors.PREDICTORS[name](alike(), stubborn(0.6), MEANS)
    assert found.embedding.shape == (ROOMS, 3, 11)
    assert found.confidence.shape == found.alike.shape == (ROOMS, 3)
    assert ((found.embedding[..., -3:] >= 0) & (found.embedding[..., -3:] <= 1)).all()


def floors(types, doors, shown):
    """Return the kindred floor of each room; `shown` are grey values of observed floors."""
    names = {"L": "Reception", "B": "Bedroom", "K": "Kitchen", "W": "Bathroom", "C": "Closet"}
    names |= {"T": "Terrace", "H": "Corridor"}
    multi_hot = np.zeros((len(types), len(ROOM_TYPES)), np.float32)
    values = np.zeros((len(types), 3, 11), np.float32)
    seen = np.zeros((len(types), 3), bool)
    for k, letter in enumerate(types):
        multi_hot[k, ROOM_TYPES.index(names[letter])] = 1.0
    for k, grey in shown.items():
        values[k, 0, -3:], seen[k, 0] = grey, True
    pairs = [(int(a), int(b)) for a, b in doors.split()]
    edges = np.array([*pairs, *((b, a) for a, b in pairs)]).reshape(-1, 2).T
    ids = tuple(map(str, range(len(types))))
    return predictors.kindred_floors(HouseGraph(ids, multi_hot, edges, values, seen)).tolist()


@pytest.mark.parametrize(
    ("types", "doors", "shown", "expected"),
    [
        # A hall joins a stone living room, bedrooms (two carpeted) and a bathroom.
        ("HLBBBW", "01 02 03 04 05", {1: 0.8, 2: 0.4, 3: 0.42}, {4: {2, 3}, 5: {-1}}),
        ("HLWWT", "01 02 03 14", {1: 0.4, 2: 0.9}, {3: {2}, 4: {-1}, 0: {1}}),
        ("HLBBC", "01 02 03 34", {1: 0.8, 2: 0.4}, {3: {2}, 4: {2}}),
        ("HBBBL", "01 02 03", {1: 0.4, 2: 0.42, 3: 0.8, 4: 0.8}, {0: {1, 2}}),
    ],
    ids=["bedroom", "bathroom and open air", "closet", "hall"],
)
def test_an_unseen_floor_is_like_a_kindred_one(types, doors, shown, expected):
    found = floors(types, doors, shown)
    assert all(found[room] in likely for room, likely in expected.items())


def test_the_house_predictor_copies_a_kindred_floor():
    graph = alike()
    graph.types[:] = 0.0
    graph.types[:, ROOM_TYPES.index("Bedroom")] = 1.0
    graph.embeddings[:4, 0, :8] = np.arange(4)[:, None]
    graph.observed[4, 0] = False
    graph.embeddings[4] = 0.0
    found = predictors.PREDICTORS["house"](graph, stubborn(0.5), MEANS, None)
    assert found.embedding[4, 0] == pytest.approx(graph.embeddings[found.alike[4, 0], 0])
