"""Repetition and sharpness of surfaces whose answers are known."""

import numpy as np
import pytest

from plan2scene.metrics.repetition import repetition


def noise(height, width, seed=0):
    values = np.random.default_rng(seed).normal(128, 30, (height, width, 1))
    return np.clip(np.repeat(values, 3, axis=2), 0, 255).astype(np.uint8)


def test_a_repeated_tile_is_found_and_noise_is_not() -> None:
    tile = noise(50, 50)
    assert repetition(np.tile(tile, (4, 4, 1)), 50.0) == pytest.approx(1.0, abs=0.02)
    assert repetition(noise(200, 200), 50.0) < 0.1
    # Nothing repeats within half a surface that one tile covers.
    assert repetition(tile, 50.0) < 0.3
