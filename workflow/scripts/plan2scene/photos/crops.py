"""Crops of rectified planes, sampled as in the paper, with the metres they cover.

Paper: up to 10 random 256x256 windows fully inside the rectified mask (upscaled by 3), at most
1000 tries each, resized to 128x128; the reference crop of a surface is the medoid. Here windows
are squares in metres, so that a crop knows its scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.photos.camera import Camera
from plan2scene.photos.planes import Plane
from plan2scene.photos.rectification import RectifiedPlane, rectify

CROP_PX = 128
CROPS_PER_MASK = 10
TRIES = 1000
#: Sides of the windows in metres; the first that fits a plane is taken.
CROP_METRES = (1.0, 0.75, 0.5, 0.35, 0.25)
#: Most crop pixels per photo pixel (paper: 256 px windows of a x3 image at 128 px are 1.5).
MAX_UPSAMPLING = 1.5
#: The same where nothing of a plane is that sharp: its colour is still worth having.
LAST_UPSAMPLING = 3.0
#: Windows that fit a plane only in fewer places than this are given up for smaller ones.
MIN_PLACES = 64


@dataclass(frozen=True)
class Crop:
    """A 128x128 crop of one plane.

    Parameters
    ----------
    index : int
        0..9 within its mask.
    window : (4,) tuple of float
        x0 y0 x1 y1 on the rectified plane, metres.
    metres : float
        Side of the window.
    sharpness : float
        Photo pixels per crop pixel at its middle (1: as sharp as the photo; 0.5: upsampled x2).
    grazing_deg : float
        Angle between the view ray and the plane at its middle, degrees.
    image : (128, 128, 3) uint8
        sRGB.
    """

    index: int
    window: tuple[float, float, float, float]
    metres: float
    sharpness: float
    grazing_deg: float
    image: np.ndarray


def sample_crops(
    image: np.ndarray,
    camera: Camera,
    plane: Plane,
    rng: np.random.Generator,
    *,
    metres: Sequence[float] = CROP_METRES,
    per_mask: int = CROPS_PER_MASK,
    tries: int = TRIES,
) -> list[Crop]:
    """Return up to `per_mask` crops of a plane of a photo; empty when no window fits.

    Parameters
    ----------
    image : (h, w, 3) uint8
        The photo, sRGB.
    camera, plane : Camera, Plane
        Its camera and the plane.
    rng : numpy.random.Generator
        Draws the windows.
    metres : sequence of float
        Sides to try, in this order.
    per_mask, tries : int
        Most crops, and most draws for each.
    """
    for upsampling in (MAX_UPSAMPLING, LAST_UPSAMPLING):
        for side in metres:
            density = CROP_PX / side / upsampling
            rectified = rectify(image, camera, plane, min_density=density)
            if rectified is None:
                continue
            windows = draw_windows(rectified, side, rng, per_mask=per_mask, tries=tries)
            if windows:
                return [
                    _cut(rectified, index, row, column, side)
                    for index, (row, column) in enumerate(windows)
                ]
    return []


def window_pixels(rectified: RectifiedPlane, metres: float) -> int:
    """Return the side of a window of that many metres in pixels of the rectified image."""
    return max(1, round(metres / rectified.metres_per_pixel))


def draw_windows(
    rectified: RectifiedPlane,
    metres: float,
    rng: np.random.Generator,
    *,
    per_mask: int = CROPS_PER_MASK,
    tries: int = TRIES,
) -> list[tuple[int, int]]:
    """Return (row, column) of the top left pixels of random windows fully inside the mask.

    No window is drawn twice; fewer come back when `tries` draws find none.
    """
    side = window_pixels(rectified, metres)
    rows, columns = (extent - side + 1 for extent in rectified.mask.shape)
    if rows < 1 or columns < 1:
        return []
    total = cv2.integral(rectified.mask.astype(np.uint8))
    covered = total[side:, side:] - total[:-side, side:] - total[side:, :-side]
    inside = covered + total[:-side, :-side] == side * side
    if inside.sum() < MIN_PLACES:
        return []
    chosen: list[tuple[int, int]] = []
    for _ in range(per_mask):
        row = rng.integers(0, rows, tries)
        column = rng.integers(0, columns, tries)
        hits = np.nonzero(inside[row, column])[0]
        if not len(hits):
            break
        place = (int(row[hits[0]]), int(column[hits[0]]))
        if place not in chosen:
            chosen.append(place)
    return chosen


def _cut(rectified: RectifiedPlane, index: int, row: int, column: int, metres: float) -> Crop:
    """Return one window as a crop."""
    side = window_pixels(rectified, metres)
    patch = rectified.image[row : row + side, column : column + side]
    shrink = side > CROP_PX
    patch = cv2.resize(
        patch, (CROP_PX, CROP_PX), interpolation=cv2.INTER_AREA if shrink else cv2.INTER_CUBIC
    )
    window = rectified.window(row, column, side)
    grazing, density = rectified.view((window[0] + window[2]) / 2, (window[1] + window[3]) / 2)
    covered = side * rectified.metres_per_pixel
    return Crop(
        index=index,
        window=window,
        metres=covered,
        sharpness=density * covered / CROP_PX,
        grazing_deg=grazing,
        image=patch,
    )


def medoid_index(images: Sequence[np.ndarray]) -> int:
    """Return the index of the image closest (L2) to the mean RGB image (paper, reference crop).

    Images are (h, w, 3) uint8 of one size; of equals the first. ValueError without any.
    """
    if not len(images):
        raise ValueError("the medoid of no images")
    stack = np.stack([image.astype(np.float64) for image in images])
    distance = ((stack - stack.mean(axis=0)) ** 2).reshape(len(stack), -1).sum(axis=1)
    return int(np.argmin(distance))
