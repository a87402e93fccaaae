"""TILE: how much an image's low frequencies betray a repeated tile (paper section 5)."""

from __future__ import annotations

from functools import cache

import numpy as np

from plan2scene.metrics.images import METRIC_SIZE, grey

_SIGMA = 21.0


@cache
def _window() -> np.ndarray:
    """Return the (128, 128) Gaussian of sigma 21 with sum 1, the zero frequency's sample 0.

    Its centre lies between the middle samples (63.5), the zeroed sample is the shifted
    spectrum's zero frequency (64, 64), as in the reference.
    """
    offset = np.arange(METRIC_SIZE) - (METRIC_SIZE - 1) / 2
    line = np.exp(-(offset**2) / (2.0 * _SIGMA**2))
    window = np.outer(line, line)
    window /= window.sum()
    window[METRIC_SIZE // 2, METRIC_SIZE // 2] = 0.0
    return window


def tile_scores(images: np.ndarray) -> np.ndarray:
    """Return (...) float64 TILE scores of (..., 128, 128, 3) uint8 sRGB images; 0 is best."""
    luma = grey(images)
    if luma.shape[-1] != METRIC_SIZE:
        raise ValueError(f"expected {METRIC_SIZE} px images, found {luma.shape[-1]} px")
    spectrum = np.fft.fftshift(np.fft.fft2(luma), axes=(-2, -1))
    return np.linalg.norm(spectrum * _window(), axis=(-2, -1))


def tile_score(image: np.ndarray) -> float:
    """Return the TILE score of one (128, 128, 3) uint8 sRGB image."""
    return float(tile_scores(image))
