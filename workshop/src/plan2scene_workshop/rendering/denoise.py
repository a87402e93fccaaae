"""Denoises renderings with few samples: it filters the light and keeps the sharp textures.

Radiance is divided by the albedo, the quotient is filtered by an edge-avoiding a-trous wavelet
(Dammertz et al. 2010) guided by normals, positions and brightness, scaled up along the edges of
a full-size guide, and multiplied by the full-size albedo.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
#: Pixels with a smaller albedo (emitters, black) are not divided by it.
MIN_ALBEDO = 0.02
_LEVELS = 5
_KERNEL = (3 / 8, 1 / 4, 1 / 16)


def demodulate(radiance: Image, albedo: Image) -> tuple[Image, NDArray[np.bool_]]:
    """Return irradiance / pi (h, w, 3) and the mask of pixels that reflect light at all."""
    lit = albedo.max(-1) > MIN_ALBEDO
    quotient = radiance / np.maximum(albedo, MIN_ALBEDO)
    return np.where(lit[..., None], quotient, radiance).astype(np.float32), lit


def clamp_fireflies(light: Image, lit: NDArray[np.bool_]) -> Image:
    """Return `light` with pixels far above their neighbourhood's median reduced to 2.5 x it."""
    grey = light.mean(-1)
    median = cv2.medianBlur(np.log1p(grey).astype(np.float32), 5)
    limit = 2.5 * np.expm1(median) + 1e-3
    scale = np.where(lit & (grey > limit), limit / np.maximum(grey, 1e-6), 1.0)
    return (light * scale[..., None]).astype(np.float32)


def fill_dark(light: Image, lit: NDArray[np.bool_]) -> Image:
    """Return `light` with dark pixels (few paths reached them) set to the neighbours' median."""
    median = cv2.medianBlur(light, 5)
    dark = lit & (light.mean(-1) < 0.35 * median.mean(-1))
    return np.where(dark[..., None], median, light).astype(np.float32)


def filter_light(light: Image, normal: Image, position: Image, groups: Image) -> Image:
    """Return `light` (h, w, 3) smoothed within surfaces.

    Parameters
    ----------
    normal, position : (h, w, 3) float32
        World normals and metres.
    groups : (h, w) float32
        Pixels of different values never mix (emitters against surfaces).
    """
    grey: Image = np.log(np.maximum(light.mean(-1), 1e-4)).astype(np.float32)
    noise = _noise_level(grey)
    height, width = grey.shape
    for level in range(_LEVELS):
        step = 2**level
        total = light * np.float32(_KERNEL[0] ** 2)
        weights = np.full((height, width), _KERNEL[0] ** 2, np.float32)
        tolerance = np.float32(1.0 / (3.0 * noise * 0.6**level + 0.04))
        smooth = cv2.GaussianBlur(grey, (0, 0), 1.2)
        for dy, dx in _offsets():
            kernel = np.float32(_KERNEL[abs(dy)] * _KERNEL[abs(dx)])
            a, b = _pair(height, width, dy * step, dx * step)
            if a is None or b is None:
                continue
            delta = position[a] - position[b]
            off_plane = np.abs((delta * normal[a]).sum(-1))
            facing = np.maximum((normal[a] * normal[b]).sum(-1), 0) ** 32
            bright = np.abs(smooth[a] - smooth[b]) * tolerance
            weight = kernel * facing * np.exp(-off_plane / 0.02 - bright)
            weight *= groups[a] == groups[b]
            total[a] += light[b] * weight[..., None]
            weights[a] += weight
            total[b] += light[a] * weight[..., None]
            weights[b] += weight
        light = (total / weights[..., None]).astype(np.float32)
        grey = np.log(np.maximum(light.mean(-1), 1e-4))
    return light


def _noise_level(grey: Image) -> float:
    """Return a robust standard deviation of the pixel noise in log brightness."""
    residual = grey - cv2.GaussianBlur(grey, (0, 0), 1.5)
    return float(np.median(np.abs(residual)) * 1.48)


def _offsets() -> list[tuple[int, int]]:
    """Return half of the 5 x 5 neighbourhood; the other half follows by symmetry."""
    return [(dy, dx) for dy in range(3) for dx in range(-2, 3) if dy > 0 or dx > 0]


def _pair(
    height: int, width: int, dy: int, dx: int
) -> tuple[tuple[slice, slice] | None, tuple[slice, slice] | None]:
    """Return slices of pixels and of their neighbours at offset (dy, dx), both in the image."""
    if dy >= height or abs(dx) >= width:
        return None, None
    rows, moved_rows = slice(0, height - dy), slice(dy, height)
    columns = slice(max(0, -dx), width - max(0, dx))
    moved_columns = slice(max(0, dx), width - max(0, -dx))
    return (rows, columns), (moved_rows, moved_columns)


def upsample(light: Image, small: tuple[Image, Image], full: tuple[Image, Image]) -> Image:
    """Return `light` upsampled to the full size with bilinear weights times guide agreement.

    `small` and `full` are the guides, pairs (normal, position), at the two sizes.
    """
    height, width = full[0].shape[:2]
    h, w = light.shape[:2]
    y = (np.arange(height, dtype=np.float32) + 0.5) * h / height - 0.5
    x = (np.arange(width, dtype=np.float32) + 0.5) * w / width - 0.5
    y0, x0 = np.floor(y).astype(int), np.floor(x).astype(int)
    total = np.zeros((height, width, 3), np.float32)
    weights = np.zeros((height, width), np.float32)
    for dy in (0, 1):
        rows = np.clip(y0 + dy, 0, h - 1)
        wy = 1 - np.abs(y - (y0 + dy))
        for dx in (0, 1):
            columns = np.clip(x0 + dx, 0, w - 1)
            wx = 1 - np.abs(x - (x0 + dx))
            pick = np.ix_(rows, columns)
            delta = small[1][pick] - full[1]
            off_plane = np.abs((delta * full[0]).sum(-1))
            facing = np.maximum((small[0][pick] * full[0]).sum(-1), 0) ** 8
            agreement = facing * np.exp(-off_plane / 0.02)
            weight = (wy[:, None] * wx[None] + 1e-3) * (agreement + 1e-4)
            total += light[pick] * weight[..., None]
            weights += weight
    return total / weights[..., None]
