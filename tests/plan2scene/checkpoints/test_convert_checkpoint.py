import os

import numpy as np
import pandas as pd
import pytest
import torch
from formula import EMBEDDING, LOGITS, formula_crop, formula_model, formula_state

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene.checkpoints.means import training_means
from plan2scene.checkpoints.reading import read_checkpoint
from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.metrics.vgg import VggClassifier
from plan2scene.propagation.graph_networks import PropagationNetwork, load_propagation
from plan2scene.propagation.type_means import TypeMeans
from plan2scene.textures.model.texture_model import Architecture, TextureModel, load_texture_model
from plan2scene.weights import load_model_file
from plan2scene_workshop.homes.floorplans import generate_house

SIGNED = {  # (channel, row, column): 2 RGB - 1
    (0, 0, 2): 0.2800731658935547,
    (0, 0, 50): 0.3260993957519531,
    (0, 1, 0): 0.2174290418624878,
    (0, 1, 127): 0.30496203899383545,
    (1, 127, 127): -0.409664511680603,
    (2, 64, 50): -0.5213954448699951,
}


class Code:
    """Something that a pickle can hold: reading it calls the system's shell."""

    def __init__(self, witness):
        self.witness = witness

    def __reduce__(self):
        return os.system, (f"touch {self.witness}",)


def released(path, state, **more):
    stats = {"loss": np.float64(0.5), "epochs": [1, 2]}
    optimizer = dict(state={0: {"step": 3, "exp_avg": torch.zeros(2)}}, param_groups=[{"lr": 1e-4}])
    document = {"model_state_dict": state, "epoch": 3000, "stats": stats}
    torch.save(document | {"optimizer_state_dict": optimizer} | more, path)
    return path


@pytest.fixture(scope="module")
def official():
    return formula_model()


@pytest.fixture(scope="module")
def checkpoint(official, tmp_path_factory):
    return released(tmp_path_factory.mktemp("released") / "synth.ckpt", official.state_dict())


@pytest.fixture
def means():
    rng = np.random.default_rng(0)
    shape = (len(ROOM_TYPES), 3)
    return TypeMeans(
        rng.random((*shape, 11)).astype(np.float32), rng.random((*shape, 8)).astype(np.float32)
    )


def test_converted_texture_model_returns_the_reference_s_figures(official, checkpoint, tmp_path):
    convert_checkpoint("texture", checkpoint, tmp_path / "texture.safetensors")
    model = load_texture_model(tmp_path / "texture.safetensors")
    rgb = torch.from_numpy(formula_crop()).permute(2, 0, 1)[None].float() / 255.0
    seeds = torch.from_numpy(np.float32((np.arange(24) * 0.6180339887) % 1)).view(1, 8, 3)
    with torch.no_grad():
        encoding = model.encode(rgb)
        signed = 2.0 * model.decode(encoding.embedding, seeds)[0].numpy() - 1.0
        same = official.decode(official.encode(rgb).embedding, seeds)[0].numpy()
    np.testing.assert_allclose(encoding.embedding[0], EMBEDDING, atol=1e-4)
    np.testing.assert_allclose(encoding.logits[0], LOGITS, atol=1e-4)
    for place, value in SIGNED.items():
        assert signed[place] == pytest.approx(value, abs=1e-3)
    np.testing.assert_allclose((signed + 1.0) / 2.0, same, atol=1e-6)
    assert len(torch.load(checkpoint, weights_only=False)) == 4


@pytest.mark.parametrize("form", ["lightning", "bare", "parallel", "old"])
def test_other_forms_of_the_same_weights(official, tmp_path, form):
    state = official.state_dict()
    document = {"model_state_dict": state}
    if form == "lightning":
        document = {"hyper_parameters": {"lr": 1e-4}, "pytorch-lightning_version": "1.4.9"}
        document["state_dict"] = {f"model.{k}": v for k, v in state.items()}
    elif form == "bare":
        document = state
    elif form == "parallel":
        document["model_state_dict"] = {f"module.{k}": v.double() for k, v in state.items()}
    torch.save(document, tmp_path / "c", _use_new_zipfile_serialization=form != "old")
    convert_checkpoint("texture", tmp_path / "c", tmp_path / "o")
    found, architecture = load_model_file(tmp_path / "o")
    assert architecture["periodic"] is False and found.keys() == state.keys()
    assert all(torch.equal(found[name], state[name]) for name in state)


def test_naive_model_has_no_head(official, tmp_path):
    torch.manual_seed(1)
    naive = TextureModel(Architecture(periodic=False, delta_hsv=False, substances=0)).eval()
    state = dict(naive.state_dict())
    head = {"substance_layer.weight": torch.ones(4, 8), "substance_layer.bias": torch.ones(4)}
    for name, tensors in (("plain", state), ("with_head", state | head)):
        convert_checkpoint("naivesynth", released(tmp_path / name, tensors), tmp_path / "o")
        model = load_texture_model(tmp_path / "o")
        rgb = torch.rand(1, 3, 128, 128, generator=torch.Generator().manual_seed(2))
        with torch.no_grad():
            a, b = model.encode(rgb).embedding, naive.encode(rgb).embedding
            seeds = torch.full((1, 8, 3), 0.3)
            tiles = model.decode(a, seeds, 32), naive.decode(b, seeds, 32)
        assert a.shape == (1, 8)
        np.testing.assert_allclose(a, b, atol=1e-6)
        np.testing.assert_allclose(*tiles, atol=1e-6)


def test_classes_are_sorted_to_our_order(official, checkpoint, tmp_path):
    theirs = ["carpet", "tile", "wood", "plastered"]
    convert_checkpoint("texture", checkpoint, tmp_path / "o", substances=theirs)
    state, _ = load_model_file(tmp_path / "o")
    assert torch.equal(state["substance_layer.bias"], official.substance_layer.bias[[2, 3, 0, 1]])
    theirs = ["wood", "wood", "carpet", "tile"]
    with pytest.raises(InputError, match="in some order, found wood, wood, carpet, tile"):
        convert_checkpoint("texture", checkpoint, tmp_path / "o", substances=theirs)


def test_converted_propagation_is_the_network_that_was_given(means, tmp_path):
    network = PropagationNetwork().eval()
    network.load_state_dict(formula_state(network))
    path = tmp_path / "gnn.ckpt"
    torch.save({"model_params": {"width": 96}, "model_state_dict": network.state_dict()}, path)
    convert_checkpoint("propagation", path, tmp_path / "o", means=means)
    converted, kept = load_propagation(tmp_path / "o")
    x = torch.sin(0.11 * (torch.arange(4 * 48, dtype=torch.float64) + 1)).float().reshape(4, 48)
    edges = torch.tensor([[0, 1, 1, 2, 1, 3], [1, 0, 2, 1, 3, 1]])
    with torch.no_grad():
        assert torch.equal(converted(x, edges), network(x, edges))
    np.testing.assert_array_equal(kept.embedding, means.embedding)
    np.testing.assert_array_equal(kept.naive, means.naive)
    with pytest.raises(InputError, match="means over training surfaces"):
        convert_checkpoint("propagation", path, tmp_path / "o")


def test_the_classifier_is_that_of_released_checkpoints(tmp_path):
    with torch.device("meta"):
        shapes = {k: tuple(v.shape) for k, v in VggClassifier().state_dict().items()}
    assert len(shapes) == 32 and shapes["features.28.weight"] == (512, 512, 3, 3)
    assert shapes["classifier.0.weight"] == (4096, 25088)
    assert shapes["classifier.6.weight"] == (4, 4096)
    small = VggClassifier(divisor=64).state_dict()
    torch.save({"model_params": {}, "model_state_dict": small}, tmp_path / "c")
    with pytest.raises(InputError, match=r"shape \(64, 3, 3, 3\) of tensor features\.0\.weight"):
        convert_checkpoint("vgg16", tmp_path / "c", tmp_path / "o")


@pytest.mark.parametrize("old", [False, True])
@pytest.mark.parametrize("place", ["stats", "model_state_dict", "extra"])
def test_code_in_a_checkpoint_is_refused_and_not_run(tmp_path, place, old):
    witness, path = tmp_path / "witness", tmp_path / "c.ckpt"
    document = {"model_state_dict": {"a": torch.zeros(2)}, place: Code(witness)}
    torch.save(document, path, _use_new_zipfile_serialization=not old)
    with pytest.raises(InputError) as caught:
        convert_checkpoint("texture", path, tmp_path / "o")
    assert str(caught.value) == (
        f"file {path}: expected a checkpoint of tensors and plain values, "
        f"found {os.system.__module__}.system in it, which is not run"
    )
    assert not witness.exists() and not (tmp_path / "o").exists()
    torch.load(path, weights_only=False)
    assert witness.exists()  # the file does carry code: another reader runs it


def test_a_missing_or_half_checkpoint_is_one_line(checkpoint, tmp_path):
    with pytest.raises(InputError, match=r"c: expected a checkpoint, found no such file"):
        read_checkpoint(tmp_path / "c")
    whole = checkpoint.read_bytes()
    (tmp_path / "c").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"^file .*c: expected a checkpoint of torch.save"):
        read_checkpoint(tmp_path / "c")


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            "missing",
            "expected tensor linear2.2.bias (33,), found 1 of 13 tensors missing, 0 unknown",
        ),
        ("shape", "expected shape (33, 96) of tensor linear2.2.weight, found (32, 96)"),
        ("unknown", "expected the 13 tensors of the network, found also linear9.bias (1 unknown)"),
        ("nan", "expected finite values in tensor conv1.weight, found NaN or infinity"),
        ("other", "tensors missing, 38 unknown"),
    ],
)
def test_weights_that_do_not_fit_are_one_line(official, means, tmp_path, change, line):
    state = dict(PropagationNetwork().state_dict())
    if change == "missing":
        del state["linear2.2.bias"]
    elif change == "shape":
        state["linear2.2.weight"] = torch.zeros(32, 96)
    elif change == "unknown":
        state["linear9.bias"] = torch.zeros(1)
    elif change == "nan":
        state["conv1.weight"] = torch.full((3, 96, 96), float("nan"))
    else:
        state = dict(official.state_dict())
    path = released(tmp_path / "c", state)
    with pytest.raises(InputError) as caught:
        convert_checkpoint("propagation", path, tmp_path / "o", means=means)
    assert str(caught.value).startswith(f"file {path}: expected ")
    assert line in str(caught.value) and not (tmp_path / "o").exists()


def test_means_over_training_surfaces():
    house = generate_house("h", 2)
    room = next(room for room in house.rooms if room.types == ("Bedroom",))
    rows = [
        {"room_id": room.id, "surface": "floor", "embedding": [v] * 11, "naive_embedding": [-v] * 8}
        for v in (1.0, 3.0)
    ]
    means = training_means([(house, pd.DataFrame(rows))])
    embedding, naive = means.predict(np.array([t == "Bedroom" for t in ROOM_TYPES]))
    np.testing.assert_allclose(embedding[SURFACES.index("floor")], 2.0)
    np.testing.assert_allclose(naive[SURFACES.index("floor")], -2.0)
    with pytest.raises(InputError, match=r"official.means_splits\), found none"):
        training_means([(house, pd.DataFrame(rows)[:0])])
