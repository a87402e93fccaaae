"""FREQ: difference of radial amplitude spectra (paper section 5)."""

from __future__ import annotations

from functools import cache

import numpy as np

from plan2scene.metrics.images import grey


@cache
def _laplace(size: int) -> np.ndarray:
    """Return (size, size) eigenvalues of the periodic Laplacian, 1 at the zero frequency."""
    wave = 2.0 * np.cos(2.0 * np.pi * np.arange(size) / size)
    values = wave[:, None] + wave[None, :] - 4.0
    values[0, 0] = 1.0
    return values


@cache
def _radius(size: int) -> np.ndarray:
    """Return (size * size) integer radii of the shifted spectrum, `size // 2` beyond the circle."""
    offset = np.arange(size) - size // 2
    radius = np.hypot(offset[:, None], offset[None, :]).astype(np.int64)
    return np.minimum(radius, size // 2).ravel()


def periodic_component(images: np.ndarray) -> np.ndarray:
    """Return the periodic component of (..., s, s) float images (Moisan 2011), float64.

    The image minus the smooth image that carries the jumps between opposite borders.
    """
    jumps = np.zeros_like(images)
    rows = images[..., -1, :] - images[..., 0, :]
    columns = images[..., :, -1] - images[..., :, 0]
    jumps[..., 0, :] += rows
    jumps[..., -1, :] -= rows
    jumps[..., :, 0] += columns
    jumps[..., :, -1] -= columns
    smooth = np.fft.fft2(jumps) / _laplace(images.shape[-1])
    smooth[..., 0, 0] = 0.0
    return np.fft.ifft2(np.fft.fft2(images) - smooth).real


def frequency_profile(images: np.ndarray) -> np.ndarray:
    """Return (..., s // 2) mean spectral amplitudes by integer radius of (..., s, s, 3) uint8.

    Grey values 0..255, amplitude over the number of pixels, the zero frequency set to 0. The
    periodic component's magnitude is taken and transformed in float32, as the reference does; it
    differs from the component itself only where that overshoots below 0.
    """
    luma = grey(images)
    size = luma.shape[-1]
    component = np.abs(periodic_component(luma)).astype(np.float32)
    amplitude = np.abs(np.fft.fftshift(np.fft.fft2(component), axes=(-2, -1))) / size**2
    radius, half = _radius(size), size // 2
    counts = np.bincount(radius)
    flat = amplitude.reshape(-1, size * size)
    sums = np.stack([np.bincount(radius, weights=row) for row in flat])
    profile = (sums / counts)[:, :half]
    profile[:, 0] = 0.0
    return profile.reshape(*luma.shape[:-2], half)


def freq_distance(prediction: np.ndarray, reference: np.ndarray) -> float:
    """Return FREQ, the mean absolute difference of two images' frequency profiles; 0 is best.

    Both (s, s, 3) uint8 sRGB of one size.
    """
    if prediction.shape != reference.shape:
        raise ValueError(f"expected equal shapes, found {prediction.shape}, {reference.shape}")
    profiles = frequency_profile(np.stack([prediction, reference]))
    return float(np.abs(profiles[0] - profiles[1]).mean())
