import json
from dataclasses import asdict

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.pretrained import Checkpoint, PretrainedSegmenter, load_pretrained

COMMIT = "0123456789abcdef0123456789abcdef01234567"


class _Fixed(torch.nn.Module):
    """Stands for an ADE20K network: each quarter of the picture is one class for certain."""

    def forward(self, pixel_values):
        logits = torch.zeros(1, 150, 20, 20)
        logits[0, 3, 10:, :10] = 5  # floor
        logits[0, 0, 10:, 10:] = 5  # wall
        logits[0, 5, :10, :10] = 5  # ceiling
        logits[0, 8, :10, 10:] = 5  # window
        return type("Output", (), {"logits": logits})()


def test_ade20k_classes_become_our_labels():
    labels = PretrainedSegmenter(_Fixed()).labels(np.zeros((40, 40, 3), np.uint8))
    assert labels[5, 5] == 3 and labels[5, 35] == 0
    assert labels[35, 5] == 1 and labels[35, 35] == 2


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({}, "expected photos.pretrained.path or photos.pretrained.id, found neither"),
        ({"path": "x", "id": "a/b"}, "found both"),
        ({"path": "gone"}, "gone.*ADE20K checkpoint.*no such file"),
        ({"path": "gone", "revision": COMMIT}, "revision only with an id"),
        ({"id": "a/b"}, r"a/b: expected .*revision.* 40 hexadecimal digits, found none"),
        ({"id": "a/b", "revision": "main"}, "found main"),
        ({"id": "../b", "revision": COMMIT}, "owner/name"),
        ({"id": "b", "revision": COMMIT}, "owner/name"),
    ],
)
def test_unclear_keys_are_one_line(keys, words):
    with pytest.raises(InputError, match=words):
        load_pretrained(Checkpoint(**keys))


def _tiny_segformer(folder, classes=150, **options):
    transformers = pytest.importorskip("transformers")
    torch.manual_seed(0)
    options |= dict(hidden_sizes=[8] * 4, depths=[1] * 4, num_attention_heads=[1] * 4)
    config = transformers.SegformerConfig(num_labels=classes, decoder_hidden_size=8, **options)
    transformers.SegformerForSemanticSegmentation(config).save_pretrained(folder)
    return Checkpoint(str(folder))


def test_the_masks_stage_takes_a_segformer_checkpoint(tmp_path):
    checkpoint = _tiny_segformer(tmp_path)
    label = labeller("pretrained", pretrained=asdict(checkpoint), house_id="h")
    image = np.random.default_rng(0).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    labels = label.label("a.jpg", image, None).labels
    assert labels.shape == (30, 40) and set(np.unique(labels)) <= {0, 1, 2, 3}
    assert np.array_equal(labels, load_pretrained(checkpoint).labels(image))
    with pytest.raises(InputError, match="neither"):
        labeller("pretrained", pretrained={"path": None}, house_id="h")


def test_other_classes_and_pickled_weights_are_refused(tmp_path):
    from safetensors.torch import load_file

    with pytest.raises(InputError, match="150 classes"):
        load_pretrained(_tiny_segformer(tmp_path, 19))
    checkpoint = _tiny_segformer(tmp_path)
    weights = tmp_path / "model.safetensors"
    torch.save(load_file(weights), tmp_path / "pytorch_model.bin")
    weights.unlink()
    with pytest.raises(InputError, match="safetensors"):
        load_pretrained(checkpoint)


def test_code_of_a_checkpoint_is_never_run(tmp_path):
    pytest.importorskip("transformers")
    (tmp_path / "evil.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    auto = {"AutoConfig": "evil.C", "AutoModelForSemanticSegmentation": "evil.M"}
    (tmp_path / "config.json").write_text(json.dumps({"model_type": "evil", "auto_map": auto}))
    with pytest.raises(InputError, match="segmentation checkpoint"):
        load_pretrained(Checkpoint(str(tmp_path)))
    assert not (tmp_path / "ran").exists()
