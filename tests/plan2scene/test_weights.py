"""Weights on disk: what is written comes back, the same bytes every time, nothing foreign."""

import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.weights import MODELS, load_model_file, save_model_file

STATE = {"a.weight": torch.arange(6.0).reshape(2, 3) / 3, "b": torch.tensor([1, 2])}


def test_round_trip_in_half_and_full_precision(tmp_path):
    for half, tolerance in ((True, 1e-3), (False, 0.0)):
        save_model_file(tmp_path / "m.safetensors", STATE, {"width": 2}, half=half)
        state, architecture = load_model_file(tmp_path / "m.safetensors")
        assert architecture == {"width": 2}
        assert state["a.weight"].dtype == torch.float32
        assert (state["a.weight"] - STATE["a.weight"]).abs().max() <= tolerance
        assert torch.equal(state["b"], STATE["b"])


def test_same_state_same_bytes(tmp_path):
    files = []
    for k in range(8):
        save_model_file(tmp_path / f"{k}.safetensors", STATE, {"width": 2, "depth": 1})
        files.append((tmp_path / f"{k}.safetensors").read_bytes())
    assert len(set(files)) == 1


@pytest.mark.parametrize("data", [b"", b"garbage", b"\x80\x04pickle"])
def test_damaged_files_are_one_line(tmp_path, data):
    path = tmp_path / "x.safetensors"
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"x\.safetensors"):
        load_model_file(path)


def test_foreign_safetensors_are_refused(tmp_path):
    from safetensors.torch import save_file

    save_file({"a": torch.zeros(1)}, tmp_path / "x.safetensors")
    with pytest.raises(InputError, match="plan2scene header"):
        load_model_file(tmp_path / "x.safetensors")


def test_shipped_weights_have_cards_and_fit_their_budget():
    files = sorted(MODELS.glob("*.safetensors"))
    assert [file.stem for file in files] == [
        "features",
        "naivesynth",
        "propagation",
        "segmentation",
        "texture",
    ]
    for file in files:
        card = file.with_suffix(".md").read_text()
        assert "Command" in card or "rule `" in card
    assert sum(file.stat().st_size for file in files) <= 40e6
    assert (MODELS / "segmentation.safetensors").stat().st_size <= 10e6
