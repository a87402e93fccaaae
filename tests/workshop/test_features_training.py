"""Training of the features network in a few steps."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from plan2scene.materials import random_material
from plan2scene.metrics.features import extract_features, load_features_network
from plan2scene.weights import load_model_file
from plan2scene_workshop.features.training import FeaturesTraining, photograph, train_features

TINY = FeaturesTraining(procedural=8, steps=3, batch=4, held_out_crops=16)


def test_training_writes_weights_and_card_and_repeats_itself(tmp_path):
    results = [
        train_features(tmp_path / f"{k}.safetensors", tmp_path / f"{k}.md", settings=TINY)
        for k in "ab"
    ]
    assert results[0] == results[1]
    first, again = (load_model_file(tmp_path / f"{k}.safetensors")[0] for k in "ab")
    assert all(torch.equal(first[name], again[name]) for name in first)
    card = (tmp_path / "a.md").read_text()
    for name, accuracy in results[0].items():
        assert f"| {name} | 16 | {accuracy:.3f} |" in card
    network = load_features_network(tmp_path / "a.safetensors")
    features, _ = extract_features(network, [random_material("tile", 1, size_px=128).albedo])
    assert features.shape == (1, 64)
    assert np.isfinite(features).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_photographed_crop_is_a_similar_image(seed):
    crop = random_material("wood", seed, size_px=128).albedo
    first = photograph(crop, np.random.default_rng(seed))
    assert first.shape == crop.shape
    assert first.dtype == np.uint8
    assert np.array_equal(first, photograph(crop, np.random.default_rng(seed)))
    assert 0 < np.abs(first.astype(float) - crop).mean() < 90


def test_training_goes_on_from_earlier_weights(tmp_path):
    first = tmp_path / "first.safetensors"
    train_features(first, tmp_path / "first.md", settings=TINY)
    # A rate of 0 leaves the weights as they were: whatever differs was not loaded.
    still = replace(TINY, learning_rate=0.0, start=str(first))
    train_features(tmp_path / "next.safetensors", tmp_path / "next.md", settings=still)
    before, after = (load_model_file(tmp_path / f"{k}.safetensors")[0] for k in ("first", "next"))
    assert torch.equal(before["head.weight"], after["head.weight"])
    assert "going on from weights" in (tmp_path / "next.md").read_text()
