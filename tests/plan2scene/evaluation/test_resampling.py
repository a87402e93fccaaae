"""Further images of decoded textures, and what FID and KID make of them."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from plan2scene.house import SurfaceKey
from plan2scene.metrics.feature_sets import SurfaceDistances, frechet_distance, kernel_distance
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
from plan2scene.textures.seams import make_seamless
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


def test_seams_are_corrected_as_on_disk(inputs):
    plain = further_images(inputs, texture_methods()["synth"], KEYS[:1], 1)
    corrected = replace(inputs, settings=TextureSettings(7, 128, {"synth": True}))
    found = further_images(corrected, texture_methods()["synth"], KEYS[:1], 1)
    assert not np.array_equal(plain[0], found[0])
    assert np.array_equal(make_seamless(plain[0])[0], found[0])


def test_no_further_image_or_no_surface_is_nothing(inputs):
    assert further_images(inputs, texture_methods()["synth"], [], 3) == []
    assert further_images(inputs, texture_methods()["synth"], KEYS, 0) == []


def test_each_surface_counts_once_however_many_images_it_has():
    rng = np.random.default_rng(3)
    images = [rng.normal(size=(1 + i, 4)) for i in range(5)]
    crops = [rng.normal(0.5, 1, (2 + (i == 0), 4)) for i in range(5)]
    distances = SurfaceDistances()
    for house in (slice(0, 2), slice(2, 3), slice(3, 5)):
        distances.add(images[house], crops[house])
    owners = np.repeat(np.arange(5), [1, 2, 3, 4, 5])
    crop_owners = np.repeat(np.arange(5), [3, 2, 2, 2, 2])
    sets = (np.concatenate(images), np.concatenate(crops), owners, crop_owners)
    found = distances.values()
    assert found["FID"] == pytest.approx(frechet_distance(*sets), rel=1e-12)
    assert found["KID"] == pytest.approx(kernel_distance(*sets), rel=1e-12)
