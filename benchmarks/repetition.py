"""Measures of how much a whole surface (not a tile) repeats itself, and of its sharpness."""

from __future__ import annotations

import cv2
import numpy as np

#: Smallest lag in metres that counts as repetition: near points are alike in every texture.
NEAREST_M = 0.25
#: Variations over more metres than this are light and wear; they are removed.
SLOW_M = 0.5
#: Lowest frequency of fine detail, which is visible from near, in cycles per metre.
FINE = 32.0


def repetition(image: np.ndarray, px_per_m: float, run_m: tuple[float, float] = (0, 0)) -> float:
    """Return the highest normalised autocorrelation of a surface at a lag beyond `NEAREST_M`.

    It is 1 for an exact repetition, and near 1 for a grid of equal tiles with any content. Lags go
    up to half of the image's sides.

    Parameters
    ----------
    image : (h, w, 3) uint8
        sRGB.
    px_per_m : float
    run_m : (float, float)
        Lags up to these along x and down, metres, are left out: a board is like itself.
    """
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    values = grey - cv2.GaussianBlur(grey, (0, 0), SLOW_M * px_per_m / 2)
    height, width = values.shape
    shape = (2 * height, 2 * width)
    spectrum = np.fft.rfft2(values, shape)
    product = np.fft.irfft2(np.abs(spectrum) ** 2, shape)
    weight = np.fft.rfft2(np.ones_like(values), shape)
    square = np.fft.rfft2(values**2, shape)
    energy = np.fft.irfft2(square.conj() * weight, shape)
    back = np.roll(energy[::-1, ::-1], (1, 1), (0, 1))
    score = product / np.sqrt(np.maximum(energy * back, 1e-6))
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    lag = np.hypot(rows[:, None], columns[None, :])
    used = (rows[:, None] <= height // 2) & (columns[None, :] <= width // 2)
    used &= lag >= NEAREST_M * px_per_m
    used &= (rows[:, None] > run_m[1] * px_per_m) | (columns[None, :] > run_m[0] * px_per_m)
    return float(np.clip(score[used].max(), -1.0, 1.0)) if used.any() else 0.0


def fine_power(image: np.ndarray, px_per_m: float, most: float = np.inf) -> float:
    """Return the power of a surface's grey values from `FINE` to `most` cycles per metre.

    It is in squared sRGB levels, with a Hann window; NaN if the image resolves no such detail.
    """
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float64)
    window = np.outer(*(np.hanning(n + 2)[1:-1] for n in grey.shape))
    grey = (grey - np.average(grey, weights=window)) * window
    power = np.abs(np.fft.fft2(grey)) ** 2 / (grey.size * (window**2).sum())
    frequencies = [np.fft.fftfreq(n, 1 / px_per_m) for n in grey.shape]
    radius = np.hypot(frequencies[0][:, None], frequencies[1][None, :])
    used = (radius >= FINE) & (radius < min(most, px_per_m / 2))
    return float(power[used].sum()) if used.any() else float("nan")
