"""The degradation protocol: seeded, toroidal, as strong as it says."""

import numpy as np
import pytest

from plan2scene.materials import random_material
from plan2scene_workshop.texture.degradation import (
    ROOM_PHOTO,
    degrade,
    photograph,
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


def test_shares_of_shadows_and_highlights_hold_over_the_crops(tile) -> None:
    crops = degrade(tile, 0)
    assert sum(crop.shadow for crop in crops) == 2
    assert sum(crop.highlight for crop in crops) == 1
    for crop in crops:
        assert 0.75 * 0.8 <= crop.side <= 0.75 * 1.25
        assert abs(crop.angle_deg) <= 3.0


@pytest.mark.parametrize("seed", range(6))
def test_a_photographed_crop_is_a_similar_image(seed) -> None:
    crop = random_material("wood", seed, size_px=128).albedo
    first, again = (photograph(crop, np.random.default_rng(seed), ROOM_PHOTO) for _ in range(2))
    assert first.shape == crop.shape
    assert first.dtype == np.uint8
    assert np.array_equal(first, again)
    assert 0 < np.abs(first.astype(float) - crop).mean() < 90
