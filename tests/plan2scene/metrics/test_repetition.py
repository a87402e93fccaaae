"""Repetition and sharpness of surfaces whose answers are known."""

import cv2
import numpy as np
import pytest

from plan2scene.metrics.repetition import fine_power, repetition


def noise(height, width, seed=0):
    values = np.random.default_rng(seed).normal(128, 30, (height, width, 1))
    return np.clip(np.repeat(values, 3, axis=2), 0, 255).astype(np.uint8)


def test_a_repeated_tile_is_found_and_noise_is_not() -> None:
    tile = noise(50, 50)
    assert repetition(np.tile(tile, (4, 4, 1)), 50.0) == pytest.approx(1.0, abs=0.02)
    assert repetition(noise(200, 200), 50.0) < 0.1
    # Nothing repeats within half a surface that one tile covers.
    assert repetition(tile, 50.0) < 0.3


def test_fine_power_is_the_variance_above_32_cycles_a_metre() -> None:
    x = np.arange(256) / 256.0  # one metre
    for cycles, amplitude in ((16, 40), (64, 40), (64, 20)):
        wave = 128 + amplitude * np.sin(2 * np.pi * cycles * x)
        image = np.repeat(np.tile(wave, (256, 1))[..., None], 3, 2).astype(np.uint8)
        expected = amplitude**2 / 2 if cycles > 32 else 0.0
        assert fine_power(image, 256.0) == pytest.approx(expected, rel=0.02, abs=1.0)
    sharp = noise(256, 256)
    blurred = cv2.GaussianBlur(sharp, (0, 0), 4)
    assert fine_power(blurred, 256.0) < 0.05 * fine_power(sharp, 256.0)
    assert fine_power(sharp, 256.0, most=64.0) < 0.3 * fine_power(sharp, 256.0)
    assert np.isnan(fine_power(sharp, 60.0))
