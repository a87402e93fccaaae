"""What the image metrics share: the check of their inputs and the grey conversion."""

from __future__ import annotations

import numpy as np

_LUMA = np.array([19595, 38470, 7471], dtype=np.float32) / np.float32(65536)


def require_images(images: np.ndarray) -> np.ndarray:
    """Return `images` if it is (..., h, w, 3) uint8 with square images, else raise ValueError."""
    array = np.asarray(images)
    if array.dtype != np.uint8 or array.ndim < 3 or array.shape[-1] != 3:
        raise ValueError(f"expected (..., h, w, 3) uint8 sRGB, found {array.shape} {array.dtype}")
    if array.shape[-2] != array.shape[-3]:
        raise ValueError(f"expected square images, found {array.shape}")
    return array


def grey(images: np.ndarray) -> np.ndarray:
    """Return (..., h, w) float64 luma 0..255 of (..., h, w, 3) uint8 sRGB.

    Rounded to integers with Pillow's fixed-point weights (ITU-R BT.601), as the reference does:
    the third decimal of FREQ depends on it.
    """
    pixels = require_images(images)
    # Products and sums stay below 2^24 / 65536 in steps of 1 / 65536: exact in float32.
    luma = pixels.reshape(-1, 3).astype(np.float32) @ _LUMA
    return np.floor(luma + np.float32(0.5)).astype(np.float64).reshape(pixels.shape[:-1])
