"""FREQ: difference of radial amplitude spectra (paper section 6.2).

Spectra of real images are kept as their first half (``rfft2``): the other half mirrors it.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy import fft

from plan2scene.metrics.images import grey, over_images


@cache
def _border_factors(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return two (size, size // 2 + 1) complex factors of the smooth image's half spectrum.

    For the jumps d between the last and the first row, and for those between columns. As an
    image, d on the first row and -d on the last, their spectrum is that of d times
    ``1 - exp(2 pi i k / size)``; the smooth image solves the periodic Poisson equation for it: a
    division by the Laplacian's eigenvalues.
    """
    turn = 2.0 * np.pi * np.arange(size) / size
    wave, step = 2.0 * np.cos(turn), 1.0 - np.exp(1j * turn)
    half = size // 2 + 1
    laplace = wave[:, None] + wave[None, :half] - 4.0
    laplace[0, 0] = 1.0  # both numerators are 0
    return step[:, None] / laplace, step[None, :half] / laplace


@cache
def _rings(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return integer radii of a flat half spectrum, how often each value counts, and ring sizes.

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


def _periodic(image: np.ndarray) -> np.ndarray:
    """Return :func:`periodic_component` of one (s, s) float64 image."""
    rows, columns = _border_factors(len(image))
    smooth = rows * fft.rfft(image[-1] - image[0])
    smooth += columns * fft.fft(image[:, -1] - image[:, 0])[:, None]
    return image - fft.irfft2(smooth, s=image.shape, overwrite_x=True)


def periodic_component(images: np.ndarray) -> np.ndarray:
    """Return the periodic component of (..., s, s) float images (Moisan 2011), float64.

    The image minus the smooth image that carries the jumps between opposite borders.
    """
    flat = np.asarray(images, dtype=np.float64).reshape(-1, *images.shape[-2:])
    return np.stack([_periodic(image) for image in flat]).reshape(images.shape)


def _profile(image: np.ndarray) -> np.ndarray:
    """Return the (s // 2,) profile of one (s, s, 3) uint8 image."""
    size = len(image)
    component = np.abs(_periodic(grey(image))).astype(np.float32)
    # numpy's transform, as in the reference: in float32 its rounding shows in the tenth digit.
    amplitude = np.abs(np.fft.rfft2(component)) / size**2
    radius, counts, sizes = _rings(size)
    sums = np.bincount(radius, weights=amplitude.ravel() * counts)
    profile = (sums / sizes)[: size // 2]
    profile[0] = 0.0
    return profile


def frequency_profile(images: np.ndarray) -> np.ndarray:
    """Return (..., s // 2) mean spectral amplitudes by integer radius of (..., s, s, 3) uint8.

    Grey values 0..255, amplitude over the number of pixels, the zero frequency set to 0. The
    periodic component's magnitude is taken and transformed in float32, as the reference does; it
    differs from the component itself only where that overshoots below 0.
    """
    return over_images(_profile, images)


def freq_distance(predictions: np.ndarray, references: np.ndarray) -> np.ndarray:
    """Return FREQ (...) of pairs of (..., s, s, 3) uint8 sRGB images; 0 is best.

    The mean absolute difference of their frequency profiles.
    """
    first, second = frequency_profile(np.stack([predictions, references]))
    return np.abs(first - second).mean(axis=-1)
