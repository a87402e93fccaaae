"""COLOR: difference of HSL histograms of 10 x 3 x 3 bins (paper section 6.2).

The reference works out hue, lightness and saturation of every pixel in floats (``colorsys``) and
compares them with the edges of the bins. The conversions of libraries take longer than all of this
module, and in float32 they miss the reference's bin on an edge. Here two small tables, made of
integer comparisons, say the bin; they agree with the floats wherever no edge is met exactly:

- Lightness and saturation depend on the largest and the smallest channel alone, and no 8-bit
  colour lies on one of their edges (.333 and .666).
- Hue depends on the differences red - green and green - blue alone. Its edges are rays of that
  plane: halves of five straight lines, so that the signs of integer forms tell the bin. A colour
  on a ray falls where the reference's rounding puts it: those few go through its own arithmetic.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from plan2scene.metrics.images import over_images

_HUE_EDGES = np.arange(1, 10) / 10
_SIZE = 90
#: Largest difference of two channels; a table over differences has a side of 2 * 255 + 1.
_REACH = 255
_SIDE = 511
#: Marks a hue that lies on an edge.
_ON_EDGE = 255


@cache
def _hue_table() -> np.ndarray:
    """Return (511 * 511,) uint8: 9 * hue bin by (red - green + 255) * 511 + green - blue + 255."""
    difference = np.arange(-_REACH, _REACH + 1, dtype=np.int16)
    x, y = difference[:, None], difference[None, :]  # red - green, green - blue
    # Each line through hue k / 10 and k / 10 + 1 / 2, k = 1..4; positive past k / 10.
    forms = (2 * y - 3 * x, -y - 5 * x, -4 * y - 5 * x, -5 * y - 3 * x)
    # The line through hue 0 (red, x > 0) and 1 / 2 (cyan); the floats are exact on it.
    second = (y < 0) | ((y == 0) & (x < 0))
    past = sum(((form > 0) ^ second).astype(np.uint8) for form in forms)
    table = 9 * (past + 5 * second.astype(np.uint8))
    for form in forms:
        table[form == 0] = _ON_EDGE
    table[_REACH, _REACH] = 0  # grey has hue 0
    return table.ravel()


@cache
def _shade_table() -> np.ndarray:
    """Return (256 * 256,) uint8: 3 * saturation bin + lightness bin by largest * 256 + smallest.

    Entries whose largest channel is below the smallest mean nothing.
    """
    top, bottom = np.arange(256)[:, None], np.arange(256)[None, :]
    total, span = top + bottom, top - bottom  # each over 255
    lightness = (1000 * total > 333 * 510).astype(np.uint8) + (1000 * total > 666 * 510)
    divisor = np.minimum(total, 510 - total)
    saturation = (1000 * span > 333 * divisor).astype(np.uint8) + (1000 * span > 666 * divisor)
    return np.where(span > 0, 3 * saturation + lightness, lightness).astype(np.uint8).ravel()


def _float_hue(colours: np.ndarray) -> np.ndarray:
    """Return (n,) float64 hues in [0, 1) of (n, 3) uint8 sRGB that are not grey.

    The operations of colorsys in their order, so that each rounds as there.
    """
    rgb = colours / 255.0
    red, green, blue = rgb.T
    top = rgb.max(axis=-1)
    span = top - rgb.min(axis=-1)
    from_red, from_green, from_blue = ((top - c) / span for c in (red, green, blue))
    hue = np.where(
        red == top,
        from_blue - from_green,
        np.where(green == top, 2.0 + from_red - from_blue, 4.0 + from_green - from_red),
    )
    return (hue / 6.0) % 1.0


def _histogram(image: np.ndarray) -> np.ndarray:
    """Return the (90,) int64 histogram of one (h, w, 3) uint8 image."""
    red, green, blue = (plane.ravel() for plane in cv2.split(image))
    top = np.maximum(np.maximum(red, green), blue)
    bottom = np.minimum(np.minimum(red, green), blue)
    shade = _shade_table().take(top.astype(np.uint16) * np.uint16(256) + bottom)
    # red * 511 - green * 510 - blue is both differences of the table's index at once.
    place = red * np.int32(_SIDE) - green * np.int32(_SIDE - 1) - blue
    bins = _hue_table().take(place + np.int32(_REACH * _SIDE + _REACH))
    edge = np.flatnonzero(bins == _ON_EDGE)
    if len(edge):
        hue = _float_hue(image.reshape(-1, 3)[edge])
        bins[edge] = 9 * np.searchsorted(_HUE_EDGES, hue, side="right")
    return np.bincount(bins + shade, minlength=_SIZE)


def color_histogram(images: np.ndarray) -> np.ndarray:
    """Return (..., 90) int64 HSL histograms of (..., s, s, 3) uint8 sRGB images."""
    return over_images(_histogram, images)


def color_distance(predictions: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return COLOR (...) in [0, 1] of pairs of (..., s, s, 3) uint8 sRGB images; 0 is best.

    L1 difference of the HSL histograms over twice the number of pixels.
    """
    first, second = color_histogram(np.stack([predictions, references]))
    return np.abs(first - second).sum(axis=-1) / (2 * first.sum(axis=-1))
