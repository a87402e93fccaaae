"""What the image metrics share: the check of their inputs and the grey conversion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_LUMA = np.array([19595, 38470, 7471], dtype=np.float32) / np.float32(65536)


def over_images(
    measure: Callable[[np.ndarray], np.ndarray | np.float64], images: np.ndarray
) -> np.ndarray:
    """Return `measure` of each of (..., s, s, 3) uint8 sRGB images, shape (..., *its result's).

    One image after another: one fits the processor's cache, a batch does not. ValueError for
    images of another kind.
    """
    array = np.asarray(images)
    if array.dtype != np.uint8 or array.ndim < 3 or array.shape[-1] != 3:
        raise ValueError(f"expected (..., s, s, 3) uint8 sRGB, found {array.shape} {array.dtype}")
    if array.shape[-2] != array.shape[-3]:
        raise ValueError(f"expected square images, found {array.shape}")
    flat = array.reshape(-1, *array.shape[-3:])
    results = np.array([measure(image) for image in flat])
    return results.reshape((*array.shape[:-3], *results.shape[1:]))[()]


def grey(image: np.ndarray) -> np.ndarray:
    """Return (..., h, w) float64 luma 0..255 of (..., h, w, 3) uint8 sRGB.

    Rounded to integers with Pillow's fixed-point weights (ITU-R BT.601), as the reference does:
    the third decimal of FREQ depends on it.
    """
    # Products and sums stay below 2^24 / 65536 in steps of 1 / 65536: exact in float32.
    luma = image.reshape(-1, 3).astype(np.float32) @ _LUMA
    return np.floor(luma + np.float32(0.5)).astype(np.float64).reshape(image.shape[:-1])
