"""The degradation protocol: seeded, toroidal, as strong as it says."""

import numpy as np
import pytest

from plan2scene.materials import random_material
from plan2scene_workshop.texture.degradation import (
    ROOM_PHOTO,
    UNEVEN_LIGHT,
    Degradation,
    degrade,
    gain_field,
    photograph,
    window,
)

UNLIT = Degradation(
    gain=0.0, shadow_share=0.0, highlight_share=0.0, white_balance=0.0, jpeg_quality=(100, 100)
)


@pytest.fixture
def tile() -> np.ndarray:
    """A smooth periodic tile of mean grey 120."""
    wave = 2 * np.pi * (np.arange(128) + 0.5) / 128
    grey = 120 + 30 * np.cos(wave * 4)[:, None] + 20 * np.cos(wave * 3)[None, :]
    return np.rint(np.repeat(grey[..., None], 3, axis=2)).astype(np.uint8)


def test_same_seed_same_bytes_and_crops_differ(tile) -> None:
    first, again, other = degrade(tile, 3), degrade(tile, 3), degrade(tile, 4)
    assert len(first) == 6
    for one, same, different in zip(first, again, other, strict=True):
        assert one.image.shape == (128, 128, 3) and one.image.dtype == np.uint8
        np.testing.assert_array_equal(one.image, same.image)
        assert (one.image != different.image).any()
    assert (first[0].image != first[1].image).any()


def test_a_crop_does_not_depend_on_how_many_there_are(tile) -> None:
    few, many = degrade(tile, 1, crops=2, how=UNLIT), degrade(tile, 1, crops=5, how=UNLIT)
    np.testing.assert_array_equal(few[1].image, many[1].image)


def test_shares_of_shadows_and_highlights_hold_over_the_crops(tile) -> None:
    crops = degrade(tile, 0)
    assert sum(crop.shadow for crop in crops) == 2
    assert sum(crop.highlight for crop in crops) == 1
    for crop in crops:
        assert 0.75 * 0.8 <= crop.side <= 0.75 * 1.25
        assert abs(crop.angle_deg) <= 3.0


def test_windows_wrap_around_the_torus(tile) -> None:
    inside = window(tile, np.array([0.4, 0.5]), 0.75, 2.0)
    beyond = window(tile, np.array([1.4, -0.5]), 0.75, 2.0)
    np.testing.assert_array_equal(inside, beyond)


def test_the_whole_tile_comes_back_unturned(tile) -> None:
    np.testing.assert_array_equal(window(tile, np.array([0.5, 0.5]), 1.0, 0.0), tile)


def test_unlit_crops_keep_the_colour_and_lit_ones_do_not(tile) -> None:
    unlit = np.stack([crop.image for crop in degrade(tile, 2, how=UNLIT)]).mean(axis=(1, 2))
    np.testing.assert_allclose(unlit, 120.0, atol=8.0)
    casts = [np.ptp(crop.image.mean(axis=(0, 1))) for crop in degrade(tile, 2)]
    assert max(casts) > 3.0


def test_gain_field_is_smooth_and_bounded() -> None:
    field = gain_field(np.random.default_rng(0), 0.25)
    assert field.shape == (128, 128)
    assert 0.75 <= field.min() < 0.95 and 1.05 < field.max() <= 1.25
    assert np.abs(np.diff(field, axis=0)).max() < 0.02


def test_a_tile_that_is_not_square_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(s, s, 3\) uint8"):
        degrade(np.zeros((64, 128, 3), np.uint8), 0)


def test_uneven_light_keeps_the_median_colour() -> None:
    grey = np.full((128, 128, 3), 120, np.uint8)
    lit = photograph(grey, np.random.default_rng(1), UNEVEN_LIGHT).astype(float)
    assert lit.std() > 1.0
    assert np.abs(np.median(lit, axis=(0, 1)) - 120).max() <= 2


@pytest.mark.parametrize("seed", range(6))
def test_a_photographed_crop_is_a_similar_image(seed) -> None:
    crop = random_material("wood", seed, size_px=128).albedo
    first, again = (photograph(crop, np.random.default_rng(seed), ROOM_PHOTO) for _ in range(2))
    assert first.shape == crop.shape
    assert first.dtype == np.uint8
    assert np.array_equal(first, again)
    assert 0 < np.abs(first.astype(float) - crop).mean() < 90
