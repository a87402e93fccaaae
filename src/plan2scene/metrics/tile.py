"""TILE: how much an image's low frequencies betray a repeated tile (paper section 6.2)."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy import fft

from plan2scene.images import METRIC_SIZE
from plan2scene.metrics.images import grey, over_images

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


@cache
def _half_weights() -> np.ndarray:
    """Return (128 * 65 * 2,) weights of the squared parts of a flat half spectrum.

    The squared window, with that of the mirrored frequency (of equal amplitude) added where the
    half spectrum leaves it out; each weight twice, for the real and the imaginary part.
    """
    squares = np.fft.ifftshift(_window() ** 2)
    half = METRIC_SIZE // 2
    mirrored = np.roll(squares[::-1, ::-1], 1, axis=(0, 1))
    weights = squares[:, : half + 1].copy()
    weights[:, 1:half] += mirrored[:, 1:half]
    return np.repeat(weights.ravel(), 2)


def _score(image: np.ndarray) -> np.float64:
    """Return the TILE score of one (128, 128, 3) uint8 image."""
    parts = fft.rfft2(grey(image)).view(np.float64).ravel()
    return np.sqrt((parts * parts) @ _half_weights())


def tile_score(images: np.ndarray) -> np.ndarray:
    """Return TILE (...) of (..., 128, 128, 3) uint8 sRGB images; 0 is best."""
    if np.shape(images)[-2] != METRIC_SIZE:
        raise ValueError(f"expected {METRIC_SIZE} px images, found {np.shape(images)[-2]} px")
    return over_images(_score, images)
