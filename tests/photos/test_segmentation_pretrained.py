from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.photos.segmentation_pretrained import PretrainedSegmenter, load_pretrained


class _Fixed(torch.nn.Module):
    """Stands for an ADE20K network: each quarter of the picture is one class for certain."""

    def forward(self, pixel_values: torch.Tensor) -> object:
        logits = torch.zeros(1, 150, 20, 20)
        logits[0, 3, 10:, :10] = 5  # floor
        logits[0, 0, 10:, 10:] = 5  # wall
        logits[0, 5, :10, :10] = 5  # ceiling
        logits[0, 8, :10, 10:] = 5  # window
        return type("Output", (), {"logits": logits})()


def test_ade20k_classes_become_our_labels() -> None:
    labels = PretrainedSegmenter(_Fixed()).labels(np.zeros((40, 40, 3), np.uint8))
    assert labels[5, 5] == 3
    assert labels[5, 35] == 0
    assert labels[35, 5] == 1
    assert labels[35, 35] == 2


def test_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone.*ADE20K checkpoint"):
        load_pretrained(tmp_path / "gone")


def test_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "config.json").write_text("{}")
    monkeypatch.setitem(__import__("sys").modules, "transformers", None)
    with pytest.raises(InputError, match="extra 'pretrained'"):
        load_pretrained(tmp_path)


def _tiny_segformer(folder: Path, classes: int) -> None:
    transformers = pytest.importorskip("transformers")
    torch.manual_seed(0)
    config = transformers.SegformerConfig(
        num_labels=classes,
        hidden_sizes=[8, 8, 8, 8],
        depths=[1, 1, 1, 1],
        num_attention_heads=[1, 1, 1, 1],
        decoder_hidden_size=8,
    )
    transformers.SegformerForSemanticSegmentation(config).save_pretrained(folder)


def test_a_segformer_checkpoint_loads_and_labels(tmp_path: Path) -> None:
    _tiny_segformer(tmp_path, 150)
    labels = load_pretrained(tmp_path).labels(np.zeros((30, 40, 3), np.uint8))
    assert labels.shape == (30, 40)
    assert set(np.unique(labels)) <= {0, 1, 2, 3}


def test_a_checkpoint_with_other_classes_is_refused(tmp_path: Path) -> None:
    _tiny_segformer(tmp_path, 19)
    with pytest.raises(InputError, match="150 classes"):
        load_pretrained(tmp_path)
