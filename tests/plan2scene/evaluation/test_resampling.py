"""Further images of decoded textures, and what FID and KID make of them."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from plan2scene.house import SurfaceKey
from plan2scene.textures.decoding import further_images
from plan2scene.textures.house_textures import house_tiles
from plan2scene.textures.inputs import (
    HouseData,
    HouseFiles,
    KnownSurface,
    TextureInputs,
    TextureSettings,
)
from plan2scene.textures.methods import texture_methods
from plan2scene.textures.model.texture_model import Architecture, TextureModel, architecture_header
from plan2scene.weights import save_model_file

KEYS = [SurfaceKey("r1", "floor"), SurfaceKey("r1", "wall"), SurfaceKey("r2", "floor")]


@pytest.fixture
def inputs(tmp_path):
    rng = np.random.default_rng(1)
    surfaces = tuple(
        KnownSurface(
            *(key, True, 1.0, "wood", "c", 1.0),
            np.r_[rng.normal(size=8), rng.uniform(size=3)].astype(np.float32),
            None,
        )
        for key in KEYS
    )
    torch.manual_seed(0)
    model = TextureModel(Architecture(width=4, substances=4, periodic=False))
    with torch.no_grad():  # random weights show next to no texture
        for name, weight in model.decoder.named_parameters():
            weight.mul_(4.0 if name.endswith("weight") else 1.0)
    save_model_file(tmp_path / "texture", model.state_dict(), architecture_header(model))
    data = HouseData(HouseFiles("h", tmp_path, tmp_path))
    settings = TextureSettings(7, 128, {"synth": False})
    return TextureInputs(data, surfaces, (), {"texture": tmp_path / "texture"}, settings)


def test_images_of_a_surface_differ_in_their_noise_only(inputs):
    images = further_images(inputs, texture_methods()["synth"], [KEYS[2], KEYS[0]], 3)
    assert len(images) == 2 * 3
    first = house_tiles("synth", inputs)
    for key, group in ((KEYS[2], images[:3]), (KEYS[0], images[3:])):
        together = [first[key].image, *group]
        assert len({image.tobytes() for image in together}) == 4
        means = np.array([image.mean(axis=(0, 1)) for image in together])
        other = images[3 if key == KEYS[2] else 0].mean(axis=(0, 1))
        assert np.ptp(means, axis=0).max() < np.abs(means[0] - other).max()
    again = further_images(inputs, texture_methods()["synth"], [KEYS[0]], 3)
    for a, b in zip(again, images[3:], strict=True):  # in batches of other sizes: rounding
        assert np.abs(a.astype(int) - b).max() <= 2
    elsewhere = replace(inputs, data=HouseData(replace(inputs.data.files, house_id="another")))
    moved = further_images(elsewhere, texture_methods()["synth"], [KEYS[0]], 3)
    assert not np.array_equal(moved[0], again[0])
