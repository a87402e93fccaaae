import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from plan2scene.materials import random_material
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance
from plan2scene.textures.decoding import match_statistics
from plan2scene.textures.seams import wrap_ratio


def material(substance, seed):
    return random_material(substance, seed, size_px=128).albedo


@pytest.mark.parametrize(("substance", "seed"), [("wood", 1), ("carpet", 2), ("tile", 3)])
def test_colours_and_spectrum_become_the_crops(substance, seed):
    tile, crop = material("wood", 40 + seed), material(substance, seed)
    made = match_statistics(tile, crop, seed=0)
    assert made.shape == crop.shape and made.dtype == np.uint8
    assert color_distance(made, crop) < 0.08
    assert freq_distance(made, crop) < 0.6 * freq_distance(tile, crop)
    for channel in range(3):
        d = np.sort(made[..., channel].ravel()).astype(float) - np.sort(crop[..., channel].ravel())
        assert np.abs(d).mean() < 1.5


def test_what_repeats_still_repeats_the_same_again():
    noise = np.random.default_rng(0).normal(128.0, 300.0, (128, 128, 3))
    tile = np.clip(gaussian_filter(noise, (3, 3, 0), mode="wrap"), 0, 255).astype(np.uint8)
    made = match_statistics(tile, material("carpet", 6), seed=3)
    for shift in (0, 17, 50):
        assert wrap_ratio(np.roll(made, (shift, shift), axis=(0, 1))) < 1.15
    tile, crop = material("tile", 7), material("wood", 8)
    assert np.array_equal(match_statistics(tile, crop, 1), match_statistics(tile, crop, 1))
    flat = np.full_like(crop, (200, 180, 150))
    assert np.abs(match_statistics(tile, flat, 1).astype(int) - flat).max() <= 1
