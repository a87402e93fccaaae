"""Training of the texture model: data, one run in small, resuming, the card."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.textures.model.network import Architecture, load_texture_model
from plan2scene_workshop.texture import data as td
from plan2scene_workshop.texture import run as texture_run
from plan2scene_workshop.texture.settings import TextureTraining, schedule
from plan2scene_workshop.texture.training import (
    TextureTrainer,
    train_texture_model,
)

TINY = Architecture(width=4, encoder="statistics")
OPTIONS = TextureTraining(
    warm_up=16,
    steps=2,
    finish=1,
    batch=2,
    tile_batch=1,
    tile_share=0.3,
    low_precision=False,
)


@pytest.fixture(scope="module")
def textures() -> td.TextureSet:
    return td.procedural_textures(8, seed=3)


def test_procedural_textures_are_balanced_and_cached(textures, tmp_path) -> None:
    assert textures.tiles.shape == (8, 256, 256, 3)
    assert np.bincount(textures.substances).tolist() == [2] * len(SUBSTANCES)
    cache = tmp_path / "materials.npz"
    first = td.procedural_textures(4, 3, cache)
    assert np.array_equal(td.procedural_textures(4, 3, cache).tiles, first.tiles)
    assert np.array_equal(first.tiles, textures.tiles[:4])
    # Another seed does not take the cached ones.
    assert not np.array_equal(td.procedural_textures(4, 4, cache).tiles, first.tiles)


def test_weights_balance_substances_and_sources(textures) -> None:
    scanned = td.TextureSet(textures.tiles[:3], np.array([0, 0, 1]), np.ones(3, dtype=bool))
    joined = td.join_sets(textures, scanned)
    weights = td.sampling_weights(joined, 0.4)
    assert weights.sum() == pytest.approx(1.0)
    assert weights[8:].tolist() == pytest.approx([0.1, 0.1, 0.2])
    alone = td.sampling_weights(textures, 0.4)
    assert alone.tolist() == pytest.approx([1 / 8] * 8)


def test_random_crop_of_a_whole_tile_keeps_its_colours(textures) -> None:
    rng = np.random.default_rng(0)
    crop = td.random_crop(textures.tiles[0], rng, closest_px=256)
    assert crop.shape == (128, 128, 3)
    np.testing.assert_allclose(crop.mean((0, 1)), textures.tiles[0].mean((0, 1)), atol=1.0)


def test_degrading_changes_light_but_not_the_median(textures) -> None:
    rng = np.random.default_rng(1)
    flat = np.full((128, 128, 3), 120, np.uint8)
    lit = td.degrade(flat, rng).astype(float)
    assert lit.std() > 1.0
    assert abs(np.median(lit) - 120) <= 2


def test_training_is_reproducible_and_resumes(textures, tmp_path) -> None:
    weights = td.sampling_weights(textures, 0.5)
    checkpoint = tmp_path / "checkpoint.pt"
    model, seconds = train_texture_model(TINY, textures, OPTIONS, 0)
    assert seconds > 0
    whole = model.state_dict()
    trainer = TextureTrainer(TINY, OPTIONS, 0)
    trainer.model.train()
    trainer.warm_up(textures, weights)
    for _ in range(2):
        trainer.train_step(textures, weights)
    trainer.save(checkpoint)
    model, _ = train_texture_model(TINY, textures, OPTIONS, 0, checkpoint=checkpoint)
    continued = model.state_dict()
    for name, value in whole.items():
        np.testing.assert_allclose(continued[name], value, atol=1e-6, err_msg=name)


def test_checkpoint_of_another_run_is_left_alone(textures, tmp_path) -> None:
    checkpoint = tmp_path / "checkpoint.pt"
    trainer = TextureTrainer(TINY, OPTIONS, 0)
    trainer.step = 2
    trainer.save(checkpoint)
    assert TextureTrainer(TINY, replace(OPTIONS, steps=9), 0).resume(checkpoint)
    other = TextureTrainer(TINY, OPTIONS, seed=1)
    assert not other.resume(checkpoint)
    assert other.step == 0


def test_training_reduces_the_loss(textures) -> None:
    one = td.TextureSet(textures.tiles[:1], textures.substances[:1], textures.scanned[:1])
    options = TextureTraining(
        steps=24, batch=2, tile_share=0.0, learning_rate=3e-3, low_precision=False
    )
    trainer = TextureTrainer(TINY, options, 0)
    totals = []
    for _ in range(options.steps):
        losses = trainer.train_step(one, np.ones(1))
        total = losses.spectrum + losses.colour + losses.substance
        totals.append(float(total.detach()))
    assert np.mean(totals[-5:]) < 0.8 * np.mean(totals[:3])


def test_schedule_warms_up_holds_and_falls() -> None:
    assert schedule(0.0) < 0.1
    assert schedule(0.3) == 1.0
    assert schedule(0.8) == pytest.approx(0.505, abs=0.01)
    assert schedule(1.0) == pytest.approx(0.01)


def test_run_writes_weights_and_card(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(texture_run, "ARCHITECTURES", {"texture": TINY})
    output, card = tmp_path / "texture.safetensors", tmp_path / "texture.md"
    data = texture_run.TextureData(procedural=4, held_out=4)
    texture_run.train_texture("texture", data, OPTIONS, output, card)
    assert load_texture_model(output).architecture == TINY
    text = card.read_text()
    assert "| procedural | 0." in text
    assert "nan" not in text
    with pytest.raises(InputError, match="propagation"):
        texture_run.train_texture("propagation", data, OPTIONS, output, card)


def test_wrap_ratio_sees_a_seam() -> None:
    ramp = np.tile(np.arange(64, dtype=np.uint8)[:, None, None], (1, 64, 3))
    assert texture_run.wrap_ratio(ramp) > 30
    noise = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    assert texture_run.wrap_ratio(noise) == pytest.approx(1.0, abs=0.1)


def test_shipped_models_fit_their_cards() -> None:
    folder = Path(__file__).parents[2] / "resources" / "models"
    total = 0
    for name, architecture in texture_run.ARCHITECTURES.items():
        path = folder / f"{name}.safetensors"
        assert load_texture_model(path).architecture == architecture
        assert f"# {name}" in (folder / f"{name}.md").read_text(encoding="utf-8")
        total += path.stat().st_size
    assert total < 20e6


def test_shipped_texture_model_keeps_its_figures() -> None:
    path = Path(__file__).parents[2] / "resources" / "models" / "texture.safetensors"
    figures = texture_run.measure(load_texture_model(path), td.procedural_textures(8, 77), 0)
    assert figures["color"] < 0.3
    assert figures["freq"] < 0.06
    assert figures["wrap"] < 1.2
    assert figures["substance"] >= 0.5
