"""COLOR: difference of HSL histograms (paper section 5, method notes: 10 x 3 x 3 bins)."""

from __future__ import annotations

import numpy as np

from plan2scene.metrics.images import require_images

_HUE_EDGES = np.arange(1, 10) / 10
_THIRDS = np.array([0.333, 0.666])
_BINS = (10, 3, 3)


def _hls(images: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return hue, lightness, saturation in [0, 1] (float64) with the arithmetic of colorsys.

    Same operations in the same order, so that a value on a bin's edge falls on the same side.
    """
    rgb = images / 255.0
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    top, bottom = rgb.max(axis=-1), rgb.min(axis=-1)
    total, span = top + bottom, top - bottom
    lightness = total / 2.0
    coloured = span > 0
    divisor = np.where(lightness <= 0.5, total, 2.0 - top - bottom)
    saturation = np.divide(span, divisor, out=np.zeros_like(span), where=coloured)
    safe = np.where(coloured, span, 1.0)
    from_red, from_green, from_blue = ((top - c) / safe for c in (red, green, blue))
    hue = np.where(
        red == top,
        from_blue - from_green,
        np.where(green == top, 2.0 + from_red - from_blue, 4.0 + from_green - from_red),
    )
    return np.where(coloured, (hue / 6.0) % 1.0, 0.0), lightness, saturation


def color_histogram(images: np.ndarray) -> np.ndarray:
    """Return (..., 90) int64 HSL histograms of (..., h, w, 3) uint8 sRGB images."""
    pixels = require_images(images)
    hue, lightness, saturation = _hls(pixels)
    hue_bin = np.searchsorted(_HUE_EDGES, hue, side="right")
    saturation_bin = np.searchsorted(_THIRDS, saturation, side="right")
    lightness_bin = np.searchsorted(_THIRDS, lightness, side="right")
    index = (hue_bin * _BINS[1] + saturation_bin) * _BINS[2] + lightness_bin
    lead = pixels.shape[:-3]
    count = int(np.prod(lead, dtype=np.int64))
    size = _BINS[0] * _BINS[1] * _BINS[2]
    flat = index.reshape(count, -1) + size * np.arange(count)[:, None]
    return np.bincount(flat.ravel(), minlength=size * count).reshape(*lead, size)


def color_distance(prediction: np.ndarray, reference: np.ndarray) -> float:
    """Return COLOR in [0, 1] of two (h, w, 3) uint8 sRGB images of one size; 0 is best.

    L1 difference of the HSL histograms over twice the number of pixels.
    """
    if prediction.shape != reference.shape:
        raise ValueError(f"expected equal shapes, found {prediction.shape}, {reference.shape}")
    difference = np.abs(color_histogram(prediction) - color_histogram(reference)).sum()
    return float(difference / (2 * prediction.shape[0] * prediction.shape[1]))
