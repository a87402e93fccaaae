"""The pointer network: pairs, mixtures and their medians."""

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.inference import (
    MixtureArrays,
    mixture,
    read_propagation,
    read_substance_head,
    regression,
)
from plan2scene.propagation.model import network_of, save_propagation
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pairs import doors_between, room_pairs
from plan2scene.propagation.pointer import (
    Inputs,
    Mixture,
    PointerNetwork,
    log_likelihood,
)
from plan2scene.propagation.predict import (
    mixture_centres,
    predict,
    robust_centre,
    weighted_median,
)
from plan2scene.propagation.prior import TypeMeans
from plan2scene.textures.model.network import Architecture, TextureModel, architecture_header
from plan2scene.weights import save_model_file


def chain(rooms: int, observed: np.ndarray | None = None) -> HouseGraph:
    """Return rooms in a row, a door between neighbours."""
    rng = np.random.default_rng(rooms)
    links = [(i, i + 1) for i in range(rooms - 1)]
    edges = np.array(sorted([*links, *((b, a) for a, b in links)]), dtype=np.int64).reshape(-1, 2)
    types = np.eye(12, dtype=np.float32)[rng.integers(12, size=rooms)]
    seen = np.ones((rooms, 3), dtype=bool) if observed is None else observed
    values = rng.normal(size=(rooms, 3, 11)).astype(np.float32) * seen[..., None]
    return HouseGraph(tuple(f"r{i}" for i in range(rooms)), types, edges.T, values, seen)


def test_doors_on_the_shortest_way():
    doors = doors_between(6, chain(6).edges)
    assert doors[0].tolist() == [4, 1, 2, 3, 4, 4]
    assert doors[2].tolist() == [2, 1, 4, 1, 2, 3]


def test_pairs_are_all_other_rooms_with_their_facts():
    graph = chain(4)
    graph.types[:] = np.eye(12, dtype=np.float32)[[1, 1, 2, 3]]
    pairs, facts = room_pairs(graph)
    assert pairs.shape == (2, 12) and (pairs[0] != pairs[1]).all()
    known = {(int(a), int(b)): row.tolist() for (a, b), row in zip(pairs.T, facts, strict=True)}
    assert known[0, 1] == [1, 0, 0, 0, 1]  # one door, same type
    assert known[0, 3] == [0, 0, 1, 0, 0]


def test_weighted_median_of_known_values():
    values = np.array([[0.0, 9.0], [1.0, 8.0], [5.0, 1.0]])
    assert weighted_median(values, np.array([0.2, 0.2, 0.6])).tolist() == [5.0, 1.0]
    assert weighted_median(values, np.array([0.3, 0.4, 0.3])).tolist() == [1.0, 8.0]


def test_robust_centre_averages_what_agrees_and_ignores_the_rest():
    values = np.array([[1.0], [1.2], [1.4], [50.0]])
    weights = np.array([0.3, 0.3, 0.3, 0.1])
    near = robust_centre(values, weights, np.array([0.5]))
    assert near[0] == pytest.approx(1.2 + 0.1 * 0.5)  # the stray one pulls by its reach only
    assert robust_centre(values, weights, np.array([0.0]))[0] == pytest.approx(1.2)


def test_weights_sum_to_one_and_unseen_surfaces_have_none():
    observed = np.ones((5, 3), dtype=bool)
    observed[1, 0] = observed[3] = False
    graph = chain(5, observed)
    torch.manual_seed(0)
    network = PointerNetwork().eval()
    pairs, facts = room_pairs(graph)
    x = torch.from_numpy(graph.node_features(observed))
    inputs = Inputs(x, torch.from_numpy(graph.edges), torch.from_numpy(pairs), torch.tensor(facts))
    with torch.no_grad():
        mixture = network(inputs)
    copies = mixture.log_copies.exp()
    total = mixture.log_own.exp().index_add(0, inputs.pairs[0], copies)
    assert torch.allclose(total, torch.ones(5, 3), atol=1e-5)
    assert (copies[pairs[1] == 3] == 0).all() and (copies[pairs[1] == 1][:, 0] == 0).all()
    assert (copies[pairs[1] == 1][:, 1:] > 0).all()


def test_likelihood_is_that_of_the_mixture():
    """Two rooms, one component each: densities worked out by hand."""
    values = torch.zeros(2, 3, 11)
    values[1] = 2.0
    inputs = Inputs(
        torch.zeros(2, 48),
        torch.zeros(2, 0).long(),
        torch.tensor([[0, 1], [1, 0]]),
        torch.ones(2, 5),
    )
    half = torch.full((2, 3), np.log(0.5))
    mixture = Mixture(torch.ones(2, 3, 11), torch.ones(2, 3, 11), torch.ones(3, 11), half, half)
    wanted = torch.zeros(2, 3, dtype=torch.bool)
    wanted[0, 1] = True
    found = log_likelihood(mixture, inputs, values, wanted)
    own, copied = (np.exp(-11.0 * gap) / 2.0**11 for gap in (1.0, 2.0))
    assert found.item() == pytest.approx(np.log(0.5 * own + 0.5 * copied), abs=1e-4)


def test_centres_take_the_likelier_side_and_name_it():
    graph = chain(3)
    pairs, _ = room_pairs(graph)
    copies = np.full((6, 3), -np.inf)
    copies[(pairs[0] == 0) & (pairs[1] == 2)] = np.log(0.7)
    own = np.full((3, 3), np.log(1.0))
    own[0] = np.log(0.3)
    found = MixtureArrays(np.zeros((3, 3, 11)), own, copies, np.full((3, 11), 0.01))
    medians, confidence, alike = mixture_centres(found, graph.embeddings, pairs)
    reach = 2.0 * 0.01  # the regression, far away, pulls by no more than its share of that
    assert np.abs(medians[0] - graph.embeddings[2]).max() <= 0.3 * reach + 1e-6
    assert np.allclose(medians[1:], 0.0)
    assert np.allclose(confidence[:, 0], [0.7, 0.0, 0.0], atol=1e-6)
    assert alike[:, 0].tolist() == [2, -1, -1]


def test_nothing_visible_and_a_single_room_work():
    torch.manual_seed(0)
    network = PointerNetwork().eval()
    for graph in (chain(1), chain(4, np.zeros((4, 3), dtype=bool))):
        found = predict(network_of(network), graph)
        assert np.isfinite(found.embedding).all()
        assert np.allclose(found.confidence, 0.0, atol=1e-6)
        assert (found.alike == -1).all()


def test_both_networks_come_back_from_their_files(tmp_path):
    means = TypeMeans(np.zeros((12, 3, 11), np.float32), np.zeros((12, 3, 8), np.float32))
    graph = chain(4)
    torch.manual_seed(1)
    for network in (PointerNetwork().eval(), PropagationNetwork().eval()):
        path = tmp_path / f"{type(network).__name__}.safetensors"
        save_propagation(path, network, means)
        loaded, _ = read_propagation(path)
        assert loaded.pointer == isinstance(network, PointerNetwork)
        own = network_of(network)
        assert np.array_equal(predict(loaded, graph).embedding, predict(own, graph).embedding)
    assert np.isnan(predict(loaded, graph).confidence).all()


def test_a_file_of_another_network_is_refused(tmp_path):
    save_model_file(tmp_path / "x", {"a": torch.zeros(1)}, {"network": "oracle"})
    with pytest.raises(InputError, match="gated, pointer"):
        read_propagation(tmp_path / "x")


@pytest.mark.parametrize("missing", ["trunk.conv1.weight", "none.bias", "deviation"])
def test_weights_of_other_shapes_are_refused(tmp_path, missing):
    network = PointerNetwork(8, 2, 4)
    state = {f"network.{k}": v for k, v in network.state_dict().items()}
    sizes = {"network": "pointer", "width": 8, "layers": 2, "pair_width": 4}
    state[f"network.{missing}"] = torch.zeros(2, 2)
    save_model_file(tmp_path / "wrong", state, sizes)
    with pytest.raises(InputError, match=rf"found {missing} \(2, 2\)"):
        read_propagation(tmp_path / "wrong")
    del state[f"network.{missing}"]
    save_model_file(tmp_path / "less", state, sizes)
    with pytest.raises(InputError, match=f"found {missing} missing"):
        read_propagation(tmp_path / "less")


def test_predictions_without_torch_are_the_networks_own():
    observed = np.random.default_rng(2).random((7, 3)) < 0.6
    graph = chain(7, observed)
    x, edges = graph.node_features(observed), graph.edges
    pairs, facts = room_pairs(graph)
    torch.manual_seed(3)
    gated, pointer = PropagationNetwork(24, 2).eval(), PointerNetwork(24, 2, 8).eval()
    with torch.no_grad():
        # Scores beyond the bounds, too.
        pointer.none.bias.add_(torch.tensor([20.0, 0.0, -20.0]))
        inputs = Inputs(*(torch.from_numpy(part) for part in (x, edges, pairs, facts)))
        regressed = gated(inputs.x, inputs.edges).numpy()
        wanted = pointer(inputs)
    found = mixture(network_of(pointer), x, edges, pairs, facts)
    assert np.allclose(regression(network_of(gated), x, edges), regressed, atol=1e-5)
    for name in ("own", "log_own", "log_copies", "copy_scale"):
        assert np.allclose(getattr(found, name), getattr(wanted, name).numpy(), atol=1e-4), name


def test_substance_head_names_what_the_model_names(tmp_path):
    torch.manual_seed(5)
    model = TextureModel(Architecture(width=4))
    save_model_file(tmp_path / "m", model.state_dict(), architecture_header(model), half=False)
    head = read_substance_head(tmp_path / "m")
    embeddings = torch.randn(40, 11)
    with torch.no_grad():
        classes = model.substance_layer(embeddings[:, :8]).argmax(1)
    named = [head.name(embedding) for embedding in embeddings.numpy()]
    assert named == [SUBSTANCES[k] for k in classes]
    assert len(set(named)) > 1
    bare = TextureModel(Architecture(width=4, substances=0))
    save_model_file(tmp_path / "b", bare.state_dict(), architecture_header(bare))
    with pytest.raises(InputError, match="substance head"):
        read_substance_head(tmp_path / "b")
