"""Watermarks of estate agents: edges that all photos of one size have at the same pixels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.stats import binom


@dataclass(frozen=True)
class WatermarkSettings:
    """Constants. Source: set by hand on two real listings with a mark (development)."""

    side_px: int = 640  #: longer side that photos are reduced to, pixels
    #: Photos count as of one size if their sides differ by less than this share: a mark keeps its
    #: place on photos that were cropped to nearly one shape and scaled.
    rounding: float = 0.01
    photos: int = 5  #: least number of photos of a size in which a mark is searched
    looked_at: int = 40  #: largest number of photos of a size that are used, to bound the memory
    edge: float = 2.5  #: least median slope of an edge of a mark, grey levels per pixel
    agree: float = 0.75  #: least share of the photos whose slope agrees with the median there
    #: Probability that so many photos agree at a pixel by chance, and that one photo does.
    chance: float = 2e-5
    one_agrees: float = 0.1
    direction: float = 0.7  #: least cosine between a photo's slope and the median for agreement
    strength: float = 0.25  #: least slope of the photo along the median, as a share of the median
    #: Diameter of the disc that closes gaps between edges, and margin added around them, pixels.
    joined_px: int = 9
    margin_px: int = 3
    least_px: int = 40  #: smaller connected components are dropped, pixels
    most: float = 0.1  #: a larger mark (share of the photo) means photos of one view, not a mark


WATERMARK = WatermarkSettings()


def reduced(image: np.ndarray) -> np.ndarray:
    """Return the reduced grey copy (h', w') uint8 of a (h, w, 3) uint8 sRGB photo."""
    zoom = min(1.0, WATERMARK.side_px / max(image.shape[:2]))
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    return cv2.resize(grey, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)


def watermarks(photos: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the marked pixels of photos, (h', w') bool each; photos without a mark are left out.

    `photos` are those of :func:`reduced`.
    """
    found: dict[str, np.ndarray] = {}
    left = dict(photos)
    for size, _ in Counter(grey.shape for grey in photos.values()).most_common():
        names = [name for name in left if _one_size(left[name].shape, size)]
        same = [cv2.resize(left.pop(name), size[::-1]) for name in names]
        mark = shared_mark(same) if same else np.zeros(size, dtype=bool)
        if mark.any():
            found |= dict.fromkeys(names, mark)
    return found


def _one_size(first: Sequence[int], second: Sequence[int]) -> bool:
    """Return whether two sizes (rows, columns) differ by less than `WATERMARK.rounding`."""
    return all(abs(a - b) < WATERMARK.rounding * b for a, b in zip(first, second, strict=True))


def shared_mark(photos: Sequence[np.ndarray]) -> np.ndarray:
    """Return the pixels (h, w) bool of a mark that all `photos`, (h, w) uint8 grey, share.

    The median slope over the photos is the slope of what all share: Dekel et al. 2017,
    DOI 10.1109/CVPR.2017.726. No pixels for too few photos or for photos of one view.
    """
    photos = list({photo.tobytes(): photo for photo in photos}.values())  # without duplicates
    nothing = np.zeros(photos[0].shape, dtype=bool)
    if len(photos) < WATERMARK.photos:
        return nothing
    photos = photos[:: -(-len(photos) // WATERMARK.looked_at)]
    slopes = np.stack([_slope(photo) for photo in photos])
    median_slope = np.median(slopes, axis=0)
    steep = np.hypot(*median_slope)
    along = (slopes * median_slope).sum(axis=1)
    agree = along > WATERMARK.direction * np.hypot(slopes[:, 0], slopes[:, 1]) * steep
    agree &= along > WATERMARK.strength * steep**2
    least = max(
        WATERMARK.agree * len(photos),
        1 + binom.isf(WATERMARK.chance, len(photos), WATERMARK.one_agrees),
    )
    edges = (steep > WATERMARK.edge) & (agree.sum(axis=0) >= least)
    joined = cv2.morphologyEx(edges.astype(np.uint8), cv2.MORPH_CLOSE, _disc(WATERMARK.joined_px))
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(joined)
    large = stats[:, cv2.CC_STAT_AREA] >= WATERMARK.least_px
    large[0] = False
    mark = cv2.dilate(large[pieces].astype(np.uint8), _disc(2 * WATERMARK.margin_px + 1)) > 0
    return nothing if mark.mean() > WATERMARK.most else mark


def _slope(grey: np.ndarray) -> np.ndarray:
    """Return the gradient (2, h, w) float32 of a slightly blurred image, grey levels per pixel."""
    calm = cv2.GaussianBlur(grey, (0, 0), 0.8)
    return np.stack([cv2.Sobel(calm, cv2.CV_32F, dx, 1 - dx, scale=0.125) for dx in (1, 0)])


def _disc(side: int) -> np.ndarray:
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
