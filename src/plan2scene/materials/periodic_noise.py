"""Periodic noise and filters: everything here wraps around, so that textures tile."""

from __future__ import annotations

import cv2
import numpy as np
from scipy import fft


def spectral_noise(
    rng: np.random.Generator,
    size: int,
    beta: float,
    *,
    low: float = 1.0,
    high: float | None = None,
    stretch: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """Return periodic Gaussian noise (size, size) float32, mean 0, deviation 1; [row y, column x].

    Power falls as frequency ** -`beta` (0 white, 2 cloudy) between `low` and `high` cycles per
    tile and fades out beyond them. `stretch` elongates features along (x, y).
    """
    spectrum = fft.rfft2(rng.standard_normal((size, size), dtype=np.float32))
    fx = np.fft.rfftfreq(size, 1.0 / size).astype(np.float32) * np.float32(stretch[0])
    fy = np.fft.fftfreq(size, 1.0 / size).astype(np.float32)[:, None] * np.float32(stretch[1])
    squared = fx * fx + fy * fy
    squared[0, 0] = 1.0
    gain = squared ** np.float32(-beta / 4.0) * (1.0 - np.exp(-squared / np.float32(low * low)))
    if high is not None:
        gain *= np.exp(-squared / np.float32(high * high))
    gain[0, 0] = 0.0
    noise = fft.irfft2(spectrum * gain, s=(size, size)).astype(np.float32)
    return noise / np.float32(noise.std() + 1e-12)


def blur(image: np.ndarray, sigma: float) -> np.ndarray:
    """Return `image` (h, w[, c]) blurred on the torus; `sigma` in pixels."""
    pad = int(np.ceil(3 * sigma))
    wide = cv2.copyMakeBorder(image, pad, pad, pad, pad, cv2.BORDER_WRAP)
    return cv2.GaussianBlur(wide, (0, 0), sigma)[pad:-pad, pad:-pad]


def sample(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return `image` (h, w[, c]) float32 at pixel positions (x, y), bilinear, on the torus."""
    height, width = image.shape[:2]
    wide = cv2.copyMakeBorder(image, 0, 1, 0, 1, cv2.BORDER_WRAP)
    map_x = np.mod(x, width).astype(np.float32)
    map_y = np.mod(y, height).astype(np.float32)
    return cv2.remap(wide, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def warp(image: np.ndarray, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """Return `image` displaced by (dx, dy) pixels on the torus."""
    height, width = image.shape[:2]
    ys, xs = np.mgrid[0:height, 0:width].astype(np.float32)
    return sample(image, xs + dx, ys + dy)


def scatter(
    rng: np.random.Generator,
    size: int,
    count: int,
    radius: tuple[float, float],
    *,
    corners: tuple[int, int] = (4, 8),
    elongation: float = 1.6,
) -> tuple[np.ndarray, np.ndarray]:
    """Return `count` random polygons on the torus: coverage (float32), top index (int32).

    Both are (size, size): coverage is 1 inside a chip, 0 outside, antialiased; the index is that of
    the chip on top (later ones cover earlier ones), -1 outside. `radius` is the range of radii in
    pixels; small ones are more frequent.
    """
    factor = 2
    index = np.full((size * factor, size * factor), -1, dtype=np.int32)
    centres = rng.uniform(0, size, (count, 2))
    radii = radius[0] + (radius[1] - radius[0]) * rng.random(count) ** 2.0
    for k in range(count):
        n = int(rng.integers(corners[0], corners[1] + 1))
        angle = np.sort(rng.uniform(0, 2 * np.pi, n))
        ring = np.stack([np.cos(angle), np.sin(angle)], 1) * rng.uniform(0.75, 1.15, (n, 1))
        turn = rng.uniform(0, np.pi)
        ring[:, 0] *= rng.uniform(1.0, elongation)
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        ring = ring @ rotation.T * radii[k] + centres[k]
        for shift in _wraps(ring, size):
            points = np.round((ring + shift) * factor).astype(np.int32)
            cv2.fillConvexPoly(index, cv2.convexHull(points), k)
    coverage = cv2.resize((index >= 0).astype(np.float32), (size, size), None, 0, 0, cv2.INTER_AREA)
    return coverage, np.ascontiguousarray(index[::factor, ::factor])


def _wraps(ring: np.ndarray, size: int) -> list[np.ndarray]:
    """Return the shifts by whole tiles that bring a ring's copies into view."""
    low, high = ring.min(0), ring.max(0)
    shifts = [
        [s for s in (-size, 0, size) if high[axis] + s >= 0 and low[axis] + s <= size]
        for axis in (0, 1)
    ]
    return [np.array([sx, sy], dtype=float) for sx in shifts[0] for sy in shifts[1]]
