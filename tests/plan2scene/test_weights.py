import json

import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.metrics.substance_network import load_substance_network
from plan2scene.photos.labels.segmentation import load_segmenter
from plan2scene.propagation.graph_networks import load_propagation
from plan2scene.textures.model.texture_model import load_texture_model
from plan2scene.weights import MODELS, load_model_file, read_model_arrays, save_model_file

STATE = {"a.weight": torch.arange(6.0).reshape(2, 3) / 3, "b": torch.tensor([1, 2])}


def test_weights_round_trip_and_have_the_same_bytes_each_time(tmp_path):
    for half, tolerance in ((True, 1e-3), (False, 0.0)):
        save_model_file(tmp_path / "m.safetensors", STATE, {"width": 2}, half=half)
        state, architecture = load_model_file(tmp_path / "m.safetensors")
        assert architecture == {"width": 2} and state["a.weight"].dtype == torch.float32
        assert (state["a.weight"] - STATE["a.weight"]).abs().max() <= tolerance
        assert torch.equal(state["b"], STATE["b"])
    files = []
    for k in range(8):
        save_model_file(tmp_path / f"{k}.safetensors", STATE, {"width": 2, "depth": 1})
        files.append((tmp_path / f"{k}.safetensors").read_bytes())
    assert len(set(files)) == 1


def written(path, state, architecture):
    from safetensors.torch import save_file

    save_file(state, path, metadata={"format": "plan2scene", "architecture": architecture})
    return path


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"width": 1e9}', '{"width": [[5000]]}', "null", '{"a": {"b": 1}}']
)
def test_an_odd_architecture_is_one_line(tmp_path, text):
    path = written(tmp_path / "x.safetensors", STATE, text)
    with pytest.raises(InputError, match="expected an architecture"):
        load_model_file(path)


@pytest.mark.parametrize(
    "tensor",
    [torch.tensor([1.0, float("nan")]), torch.tensor([float("inf")]), torch.zeros(2) * 1j],
    ids=["nan", "infinity", "complex"],
)
@pytest.mark.parametrize("read", [load_model_file, read_model_arrays])
def test_what_is_no_finite_number_is_one_line(tmp_path, tensor, read):
    from safetensors import SafetensorError

    try:
        path = written(tmp_path / "x.safetensors", {"a": tensor}, "{}")
    except (SafetensorError, KeyError):
        pytest.skip("this safetensors writes no such tensor")
    with pytest.raises(InputError, match=r"x\.safetensors: expected"):
        read(path)


LOADERS = {
    "segmentation": load_segmenter,
    "texture": load_texture_model,
    "propagation": load_propagation,
    "features": load_substance_network,
}


@pytest.mark.parametrize("name", LOADERS)
def test_a_header_of_another_network_is_one_line(tmp_path, name):
    state, architecture = load_model_file(MODELS / f"{name}.safetensors")
    first = next(iter(state))
    changed = [
        (state, {key: 7 for key in architecture}),
        (state, {key: "x" for key in architecture}),
        (state, {key: [-1, 0] for key in architecture}),
        (state, {}),
        ({first: state[first][..., :1]} | {k: v for k, v in state.items() if k != first}, None),
        ({k: v for k, v in state.items() if k != first}, None),
    ]
    for k, (tensors, other) in enumerate(changed):
        header = json.dumps(architecture if other is None else other)
        contiguous = {key: value.contiguous() for key, value in tensors.items()}
        path = written(tmp_path / f"{k}.safetensors", contiguous, header)
        with pytest.raises(InputError, match=r"safetensors: expected .* found"):
            LOADERS[name](path)
