"""A quilted image brought to a colour and a size."""

from __future__ import annotations

import cv2
import numpy as np


def enlarged(image: np.ndarray, size_px: int) -> np.ndarray:
    """Return a periodic (s, s, 3) image at `size_px`, still periodic (cubic interpolation)."""
    if image.shape[0] == size_px:
        return image
    pad = 8
    side = image.shape[0]
    wide = np.pad(image, ((pad, pad), (pad, pad), (0, 0)), mode="wrap").astype(np.float32)
    position = (np.arange(size_px) + 0.5) * side / size_px - 0.5 + pad
    across, down = np.meshgrid(position.astype(np.float32), position.astype(np.float32))
    if size_px < side:
        wide = cv2.GaussianBlur(wide, (0, 0), 0.45 * side / size_px)
    return cv2.remap(wide, across, down, cv2.INTER_CUBIC)


def toned(image: np.ndarray, tone: np.ndarray) -> np.ndarray:
    """Return an sRGB image in [0, 1] scaled to the median colour `tone`, (3,)."""
    median = np.median(image.reshape(-1, 3), axis=0)
    return np.clip(image * (tone / np.maximum(median, 1 / 255)), 0.0, 1.0)
