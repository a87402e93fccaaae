from dataclasses import replace

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.textures.model.texture_model import Architecture, load_texture_model
from plan2scene.weights import MODELS
from plan2scene_workshop.texture import data as td
from plan2scene_workshop.texture import run as texture_run
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.texture.training import texture_trainer, train_texture_model, warm_up

TINY = Architecture(width=4, encoder="statistics")
STEPS = {"warm_up": 16, "warm_up_steps": 4, "steps": 2, "finish": 1, "batch": 2, "tile_batch": 1}
SETTINGS = TextureSettings(**STEPS, tile_share=0.3, low_precision=False)


@pytest.fixture(scope="module")
def textures():
    return td.procedural_textures(8, seed=3)


@pytest.fixture(scope="module")
def materials(tmp_path_factory):
    path = tmp_path_factory.mktemp("materials") / "materials.npz"
    td.write_materials(path, td.MaterialSettings(procedural=4, held_out=4), seed=3)
    return path


def test_materials_come_back_as_they_were_made(textures, materials):
    learnt, held_out = td.read_materials(materials)
    assert np.array_equal(learnt.tiles, textures.tiles[:4])
    assert list(held_out) == ["procedural"]
    assert not np.array_equal(held_out["procedural"].tiles, learnt.tiles)
    assert td.seen_textures(learnt)[:2] == ["4 procedural materials.", "No real tileable textures."]


def test_training_repeats_itself_and_resumes_to_the_byte(textures, tmp_path):
    checkpoint = tmp_path / "texture.checkpoint"
    whole = train_texture_model(TINY, textures, SETTINGS, 0).network.state_dict()
    trainer = texture_trainer(TINY, textures, SETTINGS, 0)
    warm_up(trainer.network, textures, SETTINGS, 0)
    for _ in range(2):
        trainer.train_step()
    trainer.save(checkpoint)
    again = train_texture_model(TINY, textures, SETTINGS, 0, checkpoint=checkpoint)
    for name, value in again.network.state_dict().items():
        assert np.array_equal(whole[name], value), name
    other = replace(SETTINGS, colour=1.0)
    trainer.save(checkpoint)
    assert not texture_trainer(TINY, textures, other, 0).resume(checkpoint)
    assert not texture_trainer(TINY, textures, SETTINGS, 0, run="others").resume(checkpoint)


def test_run_writes_weights_and_card(materials, tmp_path, monkeypatch):
    monkeypatch.setattr(texture_run, "ARCHITECTURES", {"texture": TINY})
    output, card = tmp_path / "texture.safetensors", tmp_path / "texture.md"
    texture_run.train_texture("texture", materials, output, card, settings=SETTINGS, seed=0)
    assert load_texture_model(output).architecture == TINY
    text = card.read_text()
    assert "| procedural | 4 | 0." in text and "nan" not in text
    with pytest.raises(InputError, match="other"):
        texture_run.train_texture("other", materials, output, card, settings=SETTINGS, seed=0)


def test_shipped_texture_model_keeps_its_figures():
    model = load_texture_model(MODELS / "texture.safetensors")
    figures = texture_run.measure(model, td.procedural_textures(8, 77), 0)
    assert figures["color"] < 0.3 and figures["freq"] < 0.06
    assert figures["wrap"] < 1.2 and figures["substance"] >= 0.5
