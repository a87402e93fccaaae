from dataclasses import replace

import numpy as np
import pytest
import torch
from formula import formula_state
from small_models import write_texture_model
from torch_geometric.data import Batch

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, SUBSTANCES, SURFACES
from plan2scene.propagation import graph_networks as networks
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.predictors import Prediction, predict
from plan2scene.propagation.propagate import substances_of, unseen_substances
from plan2scene.propagation.substances import on_surfaces
from plan2scene.propagation.type_means import TypeMeans

ROOM_0 = [
    [0.024754293, -0.156382143, 0.082204133, -0.148976684, 0.103648163, -0.036828607]
    + [-0.211889639, -0.056307912, -0.185268283, -0.272552431, -0.182625264],
    [0.134393245, 0.311820811, -0.160095155, -0.136284545, -0.249168277, -0.312176079]
    + [0.020982552, -0.154467046, -0.184698299, 0.096395053, -0.085825153],
    [0.028601207, -0.02444605, 0.158350676, -0.121622629, 0.239293665, -0.028870851]
    + [0.050096277, 0.379922032, -0.115114138, -0.032846086, 0.189424947],
]


def test_same_output_as_the_reference():
    x = torch.sin(0.11 * (torch.arange(4 * 48, dtype=torch.float64) + 1)).float().reshape(4, 48)
    edges = torch.tensor([[0, 1, 1, 2, 1, 3], [1, 0, 2, 1, 3, 1]])
    with torch.no_grad():
        network = networks.PropagationNetwork().eval()
        network.load_state_dict(formula_state(network))
        output = network(x, edges)
    assert output.shape == (4, 3, 11) and np.allclose(output[0].numpy(), ROOM_0, atol=1e-4)
    assert abs(float(output.sum()) - -3.5751821994781494) < 1e-3


def chain(rooms, observed=None):
    rng = np.random.default_rng(rooms)
    links = [(i, i + 1) for i in range(rooms - 1)]
    edges = np.array(sorted([*links, *((b, a) for a, b in links)]), dtype=np.int64).reshape(-1, 2)
    types = np.eye(12, dtype=np.float32)[rng.integers(12, size=rooms)]
    seen = np.ones((rooms, 3), dtype=bool) if observed is None else observed
    values = rng.normal(size=(rooms, 3, 11)).astype(np.float32) * seen[..., None]
    return HouseGraph(tuple(f"r{i}" for i in range(rooms)), types, edges.T, values, seen)


def pointer(seed=0):
    """Return a small network whose scores reach their bounds."""
    torch.manual_seed(seed)
    network = networks.PointerNetwork(24, 2, 8).eval()
    with torch.no_grad():
        network.none.bias.add_(torch.tensor([20.0, 0.0, -20.0]))
    return network


def test_one_house_is_the_same_alone_in_a_batch_and_with_edges_in_any_order():
    rng = np.random.default_rng(2)
    graphs = [chain(n, rng.random((n, 3)) < 0.6) for n in (7, 1, 4)]
    houses = [networks.graph_data(graph) for graph in graphs]
    network, gated = pointer(), networks.PropagationNetwork(24, 2).eval()
    shuffled = houses[0].clone()
    for name, rows in (("edge_index", 12), ("pair_index", 42)):
        order = torch.from_numpy(rng.permutation(rows))
        shuffled[name] = shuffled[name][:, order]
        if name == "pair_index":
            shuffled.pair_attr = shuffled.pair_attr[order]
    batch = Batch.from_data_list(houses)
    with torch.inference_mode():
        alone, together = network(houses[0]), network(batch)
        permuted = network(shuffled)
        regressed = [gated(d.x, d.edge_index) for d in (*houses, shuffled)]
        joined = gated(batch.x, batch.edge_index)
    torch.testing.assert_close(torch.cat(regressed[:3]), joined)
    torch.testing.assert_close(regressed[3], regressed[0])
    for name in ("own", "own_scale", "log_own"):
        torch.testing.assert_close(getattr(together, name)[:7], getattr(alone, name))
        torch.testing.assert_close(getattr(permuted, name), getattr(alone, name))
    torch.testing.assert_close(together.log_copies[:42], alone.log_copies)
    torch.testing.assert_close(permuted.log_copies, alone.log_copies[order])
    found = predict(network, graphs[0])
    order = rng.permutation(12)
    again = predict(network, replace(graphs[0], edges=graphs[0].edges[:, order]))
    np.testing.assert_allclose(found.embedding, again.embedding, atol=1e-5)


def test_nothing_visible_and_a_single_room_work():
    network = networks.PointerNetwork().eval()
    for graph in (chain(1), chain(4, np.zeros((4, 3), dtype=bool))):
        found = predict(network, graph)
        assert np.isfinite(found.embedding).all()
        assert np.allclose(found.confidence, 0.0, atol=1e-6) and (found.alike == -1).all()


def test_both_networks_come_back_from_their_files(tmp_path):
    means = TypeMeans(np.zeros((12, 3, 11), np.float32), np.zeros((12, 3, 8), np.float32))
    graph = chain(4)
    for network in (networks.PointerNetwork().eval(), networks.PropagationNetwork().eval()):
        path = tmp_path / f"{type(network).__name__}.safetensors"
        networks.save_propagation(path, network, means)
        loaded, _ = networks.load_propagation(path)
        assert type(loaded) is type(network)
        assert np.array_equal(predict(loaded, graph).embedding, predict(network, graph).embedding)
    found = predict(loaded, graph)
    assert np.isnan(found.confidence).all() and (found.alike == -1).all()


def test_substances_are_what_the_texture_model_says_on_that_kind_of_surface(tmp_path):
    torch.manual_seed(5)
    model = write_texture_model(tmp_path / "m", half=False)
    embeddings = torch.randn(40, 3, 11)
    with torch.no_grad():
        shares = torch.softmax(model.substance_layer(embeddings[..., :8]), dim=-1).numpy()
    named = substances_of(embeddings.numpy(), [["Bedroom"]] * 40, tmp_path / "m")
    assert (named == np.array(SUBSTANCES)[on_surfaces(shares, SURFACES).argmax(-1)]).all()
    assert len(set(named[:, 0])) > 1 and set(named[:, 2]) == {"plaster"}
    assert (substances_of(embeddings.numpy(), [["Kitchen"]] * 40, tmp_path / "m") == named).all()
    wet = substances_of(embeddings.numpy(), [["Bathroom"]] * 40, tmp_path / "m")
    assert (wet[:, 0] == "tile").mean() > (named[:, 0] == "tile").mean() + 0.3
    assert (wet[:, 1:] == named[:, 1:]).all()
    write_texture_model(tmp_path / "b", substances=0)
    with pytest.raises(InputError, match="substance head"):
        substances_of(embeddings.numpy(), [["Bedroom"]] * 40, tmp_path / "b")


def test_what_is_like_an_observed_surface_is_called_what_its_crops_were(tmp_path):
    """The head calls all floors the same, but for the bathroom's; the first's crops told carpet."""
    torch.manual_seed(5)
    write_texture_model(tmp_path / "m", half=False)
    embeddings, named = np.zeros((3, 3, 11), np.float32), {(0, 0): "carpet"}
    types = [["Bedroom"], ["Kitchen"], ["Bathroom"]]
    multi_hot = np.array([[name in one for name in ROOM_TYPES] for one in types], np.float32)
    observed = np.zeros((3, 3), bool)
    observed[0, 0] = True
    edges = np.zeros((2, 0), np.int64)
    graph = HouseGraph(("a", "b", "c"), multi_hot, edges, embeddings, observed)
    alike = np.full((3, 3), -1)
    alike[1:, 0] = 0
    predicted = Prediction(embeddings, np.ones((3, 3)), alike)
    looks = substances_of(embeddings, types, tmp_path / "m")
    assert looks[0, 0] == looks[1, 0] != "carpet" and looks[2, 0] == "tile" != looks[0, 0]
    found = unseen_substances(graph, types, predicted, named, tmp_path / "m")
    assert found[1, 0] == "carpet"
    found[1, 0] = looks[1, 0]
    assert (found == looks).all()
    # A bathroom keeps its tiles beside a carpet that the head takes for tiles, a kitchen does not.
    many = np.random.default_rng(0).normal(0, 3, (500, 3, 11)).astype(np.float32)
    tiled = substances_of(many, [["Bedroom"]] * 500, tmp_path / "m")[:, 0] == "tile"
    same = np.repeat(many[tiled][:1], 3, axis=0)
    predicted = Prediction(same, np.ones((3, 3)), alike)
    graph = HouseGraph(("a", "b", "c"), multi_hot, edges, same, observed)
    found = unseen_substances(graph, types, predicted, named, tmp_path / "m")
    assert found[1:, 0].tolist() == ["carpet", "tile"]
