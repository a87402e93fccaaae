"""COLOR, FREQ and TILE: the metrics of image pairs that need no network (paper section 6.2).

COLOR : difference of HSL histograms of 10 x 3 x 3 bins.
    Hue, lightness and saturation are computed by the operations of ``colorsys``, in the same order
    as in the reference: their rounding decides the bin of a colour on the edge of two bins.
FREQ : difference of radial amplitude spectra.
TILE : how strongly an image's low frequencies show that a tile repeats.

Only half of a real image's spectrum is kept (``rfft2``), because the other half mirrors it.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from scipy import fft

from plan2scene.images import METRIC_SIZE

_LUMA = np.array([19595, 38470, 7471], dtype=np.float32) / np.float32(65536)
_HUE_EDGES, _SHADE_EDGES = np.arange(1, 10) / 10, (0.333, 0.666)
_BINS = 90  #: Bins of the histogram
_TILE_SIGMA = 21.0  #: Standard deviation in frequency samples of TILE's window


def _checked(*images: np.ndarray) -> None:
    """Raise ValueError unless all are square (s, s, 3) uint8 images of one size."""
    for image in images:
        if image.dtype != np.uint8 or image.shape != (len(images[0]), len(images[0]), 3):
            found = f"{image.shape} {image.dtype}"
            raise ValueError(f"expected (s, s, 3) uint8 sRGB of one size, found {found}")


def grey(image: np.ndarray) -> np.ndarray:
    """Return (h, w) float64 luma 0..255 of an (h, w, 3) uint8 sRGB image.

    It is rounded to integers with Pillow's fixed-point weights (ITU-R BT.601), as in the reference:
    the third decimal of FREQ depends on it.
    """
    # Products and sums stay below 2^24 / 65536 in steps of 1 / 65536: exact in float32.
    luma = image.reshape(-1, 3).astype(np.float32) @ _LUMA
    return np.floor(luma + np.float32(0.5)).astype(np.float64).reshape(image.shape[:-1])


def color_histogram(image: np.ndarray) -> np.ndarray:
    """Return the (90,) int64 HSL histogram of an (h, w, 3) uint8 sRGB image."""
    red, green, blue = (plane.ravel() / 255.0 for plane in cv2.split(image))
    top = np.maximum(np.maximum(red, green), blue)
    bottom = np.minimum(np.minimum(red, green), blue)
    total, span = top + bottom, top - bottom
    grey = span == 0  # has hue and saturation 0
    away = ((top - channel) / np.where(grey, 1.0, span) for channel in (red, green, blue))
    from_red, from_green, from_blue = away
    hue = np.where(
        red == top,
        from_blue - from_green,
        np.where(green == top, 2.0 + from_red - from_blue, 4.0 + from_green - from_red),
    )
    hue /= 6.0
    hue += hue < 0
    lightness = total / 2.0
    saturation = span / np.where(grey, 1.0, np.where(lightness <= 0.5, total, 2.0 - total))
    bins = sum(9 * (hue >= edge) for edge in _HUE_EDGES)
    for edge in _SHADE_EDGES:
        bins += 3 * (saturation > edge) + (lightness > edge)
    return np.bincount(bins, minlength=_BINS)


def color_distance(prediction: np.ndarray, reference: np.ndarray) -> float:
    """Return COLOR in [0, 1] of two (s, s, 3) uint8 sRGB images; 0 is best.

    It is the L1 difference of the HSL histograms, divided by twice the number of pixels.
    """
    _checked(prediction, reference)
    first, second = color_histogram(prediction), color_histogram(reference)
    return float(np.abs(first - second).sum() / (2 * first.sum()))


@cache
def _border_factors(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two (size, size // 2 + 1) complex factors of the smooth image's half spectrum.

    The first is for the jumps d between the last and the first row, the second for those between
    columns. An image with d in its first row and -d in its last has the spectrum of d times
    ``1 - exp(2 pi i k / size)``. The smooth image solves the periodic Poisson equation for that
    image, so its spectrum is divided by the Laplacian's eigenvalues.
    """
    turn = 2.0 * np.pi * np.arange(size) / size
    wave, step = 2.0 * np.cos(turn), 1.0 - np.exp(1j * turn)
    half = size // 2 + 1
    laplace = wave[:, None] + wave[None, :half] - 4.0
    laplace[0, 0] = 1.0  # both numerators are 0
    return step[:, None] / laplace, step[None, :half] / laplace


@cache
def _rings(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a flat half spectrum's integer radii, how often each value counts, and ring sizes.

    Radii from ``size // 2`` on are beyond the profile and share the last ring.
    """
    half = size // 2
    offset = fft.fftfreq(size, 1 / size)[:, None]
    radius = np.hypot(offset, np.arange(half + 1)[None, :]).astype(np.int64)
    radius = np.minimum(radius, half).ravel()
    twice = np.full((size, half + 1), 2.0)  # the value and its mirror
    twice[:, 0] = 1.0
    if size % 2 == 0:
        twice[:, half] = 1.0
    counts = twice.ravel().astype(np.float32)
    return radius, counts, np.bincount(radius, weights=counts)


def periodic_component(image: np.ndarray) -> np.ndarray:
    """Return the periodic component of an (s, s) float64 image (Moisan 2011).

    It is the image minus the smooth image that has the jumps between opposite borders.
    """
    rows, columns = _border_factors(len(image))
    smooth = rows * fft.rfft(image[-1] - image[0])
    smooth += columns * fft.fft(image[:, -1] - image[:, 0])[:, None]
    return image - fft.irfft2(smooth, s=image.shape, overwrite_x=True)


def frequency_profile(image: np.ndarray) -> np.ndarray:
    """Return (s // 2,) mean spectral amplitudes by integer radius of an (s, s, 3) uint8 image.

    Grey values are 0..255. Amplitudes are divided by the number of pixels, that of the zero
    frequency is set to 0. As in the reference, the periodic component's absolute value is
    transformed, in float32; it differs from the component only where that is negative.
    """
    size = len(image)
    component = np.abs(periodic_component(grey(image))).astype(np.float32)
    # numpy's transform, as in the reference: its float32 rounding changes the tenth digit.
    amplitude = np.abs(np.fft.rfft2(component)) / size**2
    radius, counts, sizes = _rings(size)
    sums = np.bincount(radius, weights=amplitude.ravel() * counts)
    profile = (sums / sizes)[: size // 2]
    profile[0] = 0.0
    return profile


def freq_distance(prediction: np.ndarray, reference: np.ndarray) -> float:
    """Return FREQ of two (s, s, 3) uint8 sRGB images; 0 is best.

    The mean absolute difference of their frequency profiles.
    """
    _checked(prediction, reference)
    return float(np.abs(frequency_profile(prediction) - frequency_profile(reference)).mean())


@cache
def _window() -> np.ndarray:
    """Return the (128, 128) Gaussian of sigma 21 and sum 1, set to 0 at the zero frequency.

    As in the reference, its centre lies between the middle samples (63.5), and the sample that is
    set to 0 is the zero frequency of the shifted spectrum (64, 64).
    """
    offset = np.arange(METRIC_SIZE) - (METRIC_SIZE - 1) / 2
    line = np.exp(-(offset**2) / (2.0 * _TILE_SIGMA**2))
    window = np.outer(line, line)
    window /= window.sum()
    window[METRIC_SIZE // 2, METRIC_SIZE // 2] = 0.0
    return window


@cache
def _half_weights() -> np.ndarray:
    """Return (128 * 65 * 2,) weights of the squared parts of a flat half spectrum.

    They are the squared window. If the half spectrum leaves out the mirrored frequency (of equal
    amplitude), its weight is added. Each weight appears twice, for real and imaginary part.
    """
    squares = np.fft.ifftshift(_window() ** 2)
    half = METRIC_SIZE // 2
    mirrored = np.roll(squares[::-1, ::-1], 1, axis=(0, 1))
    weights = squares[:, : half + 1].copy()
    weights[:, 1:half] += mirrored[:, 1:half]
    return np.repeat(weights.ravel(), 2)


def tile_score(image: np.ndarray) -> float:
    """Return TILE of a (128, 128, 3) uint8 sRGB image; 0 is best."""
    _checked(image)
    if len(image) != METRIC_SIZE:
        raise ValueError(f"expected {METRIC_SIZE} px images, found {len(image)} px")
    parts = fft.rfft2(grey(image)).view(np.float64).ravel()
    return float(np.sqrt((parts * parts) @ _half_weights()))
