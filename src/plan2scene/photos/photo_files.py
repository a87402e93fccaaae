"""Reading of photos: large ones are reduced, so that time and memory stay bounded."""

from __future__ import annotations

import os

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import read_reduced_image

#: Longer side, pixels, that photos are reduced to. With a field of view of 60 degrees, a wall 2.5 m
#: away then has 550 pixels per metre, more than the densest crop (128 pixels of 0.35 m) can hold.
MAX_SIDE = 1600
#: Least shorter side, pixels, after the reduction: narrower photos show no usable surface.
MIN_SIDE = 32


def reduced_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the (height, width) to which a photo of `size` (height, width) is reduced."""
    scale = min(1.0, MAX_SIDE / max(size))
    return max(1, round(size[0] * scale)), max(1, round(size[1] * scale))


def read_photo(path: str | os.PathLike[str], *, house_id: str = "") -> np.ndarray:
    """Return a photo as (h, w, 3) uint8 sRGB, its longer side at most `MAX_SIDE`.

    Masks, cameras and windows use the pixels of this picture. Raises InputError as
    :func:`plan2scene.images.read_reduced_image` does, and for a side below `MIN_SIDE`.
    """
    image, size = read_reduced_image(path, MAX_SIDE, house_id=house_id)
    height, width = reduced_size(size)
    if min(height, width) < MIN_SIDE:
        expected = f"a photo of at least {MIN_SIDE} pixels a side and no narrow strip"
        found = f"{size[1]}x{size[0]}"
        raise InputError(expected, found, file=path, house=house_id)
    if (height, width) == image.shape[:2]:
        return image
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
