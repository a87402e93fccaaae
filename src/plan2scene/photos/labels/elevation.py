"""How far above or below the horizon each pixel looks: a geometric cue for segmentation.

Floors lie below the horizon and ceilings above it, whatever they look like; how far a pixel looks
down says how near a floor there would be.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def elevation_map(
    up: Sequence[float] | np.ndarray,
    focal_px: float,
    photo_size: tuple[int, int],
    size: tuple[int, int],
) -> np.ndarray:
    """Return the sine of each pixel's elevation above the horizon, (h, w) float32 in [-1, 1].

    Parameters
    ----------
    up : (3,) sequence of float
        The world's up direction in camera axes (x right, y down, z forward), a unit vector: the
        second column of the rotation of ``docs/conventions.md``.
    focal_px : float
        Focal length in pixels of the photo; its principal point is the middle.
    photo_size, size : (height, width)
        Of the photo and of the map, which covers the same view.
    """
    axes = [
        (np.arange(n) + 0.5) / n * full - full / 2 for n, full in zip(size, photo_size, strict=True)
    ]
    y, x = np.meshgrid(*(axis / focal_px for axis in axes), indexing="ij")
    rise = x * up[0] + y * up[1] + up[2]
    return np.asarray(rise / np.sqrt(x * x + y * y + 1), dtype=np.float32)
