"""Seam correction: make a texture tile by resynthesising its borders from its own patches.

For each direction that does not tile, the image is rolled by half its side, so that its seam lies
in the middle. A band over the seam is replaced by the band of the same texture that fits best on
both sides. Low frequencies of the misfit are spread linearly over the band, and the two joints
follow minimum-error cuts (Efros and Freeman 2001). If the other direction already tiles, the band
may be shifted along it and its cuts close on themselves, so the second repair does not undo the
first. Deterministic: the same image gives the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from plan2scene.textures.quilting import cheapest_paths


@dataclass(frozen=True)
class SeamSettings:
    """How seams are found and corrected. Chosen on the embedded procedural materials."""

    #: A direction already tiles if its step across the wrap edge is at most this times the usual.
    tiling_ratio: float = 1.15
    #: band, overlap: Width of the resynthesised band, and of each joint, as shares of the side.
    band: float = 0.25
    overlap: float = 0.09
    candidates: int = 12  #: number of bands, those of least overlap error, whose cuts are computed
    #: Least usual step, grey levels: the noise of a flatter image must not look like a seam.
    flat_step: float = 0.5


_S = SeamSettings()


def _steps(image: np.ndarray, axis: int) -> tuple[float, np.ndarray]:
    """Return the mean absolute steps across the wrap edge, and between lines inside, (n - 1,)."""
    values = np.moveaxis(image.astype(np.float64), axis, 0)
    interior = np.abs(np.diff(values, axis=0)).mean(axis=(1, 2))
    return float(np.abs(values[0] - values[-1]).mean()), interior


def _tiles(image: np.ndarray, axis: int) -> bool:
    """Tell whether the step across the wrap edge is no larger than elsewhere or than beside it.

    The steps beside it count because a regular pattern may be steep at the border.
    """
    across, interior = _steps(image, axis)
    usual_step = max(interior.mean(), (interior[0] + interior[-1]) / 2, _S.flat_step)
    return bool(across <= _S.tiling_ratio * usual_step)


def wrap_ratio(image: np.ndarray) -> float:
    """Return how much a (h, w, 3) uint8 image jumps where it wraps; about 1 when it tiles.

    Mean absolute difference between opposite borders over that of neighbouring interior pixels
    (at least half a grey level), the larger of both directions.
    """
    steps = (_steps(image, axis) for axis in (0, 1))
    return max(float(across / max(inside.mean(), _S.flat_step)) for across, inside in steps)


def make_seamless(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a tiling version of a texture and the pixels (h, w) bool that changed.

    The texture is (h, w, 3) uint8 sRGB, at least 32 px on each side; where it already tiles, the
    image itself is returned.
    """
    result = image
    tiles = {axis: _tiles(result, axis) for axis in (0, 1)}
    for axis in (1, 0):
        if tiles[axis]:
            continue
        turned = result if axis == 1 else result.transpose(1, 0, 2)
        repaired = _repair_columns(turned, closed=tiles[1 - axis])
        result = repaired if axis == 1 else repaired.transpose(1, 0, 2)
        tiles[axis] = True
    result = np.ascontiguousarray(result)
    return result, (result != image).any(axis=2)


def with_calm_border(image: np.ndarray) -> np.ndarray:
    """Return a tiling (h, w, 3) uint8 texture rolled so that its border lies where it is calm.

    Rolling does not change a texture that repeats. It moves a pattern's joint away from the border,
    where it would show in renderers that do not filter across the border or that cut the tile. An
    axis whose border is no steeper than usual is not rolled.
    """
    for axis in (0, 1):
        across, interior = _steps(image, axis)
        if across > max(interior.mean(), _S.flat_step):
            steps = np.r_[across, interior]  # before each line
            around = (np.roll(steps, 1) + 2.0 * steps + np.roll(steps, -1)) / 4.0
            image = np.roll(image, -int(around.argmin()), axis=axis)
    return np.ascontiguousarray(image)


def _repair_columns(image: np.ndarray, *, closed: bool) -> np.ndarray:
    """Return (h, w, 3) uint8 `image` with its last column leading into its first.

    `closed`: the image already tiles from bottom to top and has to stay so.
    """
    width = image.shape[1]
    band, overlap = max(8, round(_S.band * width)), max(3, round(_S.overlap * width))
    values = image.astype(np.float64)
    start = width // 2 - band // 2
    rolled = np.roll(values, width // 2, axis=1)
    target = rolled[:, start : start + band]
    columns, shifts = _best_bands(values, target, overlap, closed)
    sources = np.stack(
        [np.roll(values[:, x : x + band], s, axis=0) for x, s in zip(columns, shifts, strict=True)]
    )
    sources = sources + _misfit(target, sources, overlap, closed)
    error = ((target - sources) ** 2).sum(axis=-1)
    along = error.swapaxes(0, 1)  # (h, n, band)
    left, left_cost = cheapest_paths(along[:, :, :overlap], closed=closed)
    right, right_cost = cheapest_paths(along[:, :, band - overlap :][:, :, ::-1], closed=closed)
    best = int(np.argmin(left_cost + right_cost))
    alpha = _band_weight(left[:, best], right[:, best], band)[..., None]
    rolled[:, start : start + band] = alpha * sources[best] + (1.0 - alpha) * target
    return np.roll(np.clip(np.rint(rolled), 0, 255).astype(np.uint8), -(width // 2), axis=1)


def _best_bands(
    values: np.ndarray, target: np.ndarray, overlap: int, closed: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return columns and row shifts of the bands of `values` that fit `target`'s overlaps best.

    The squared differences of all row shifts come from one circular correlation from top to bottom;
    only shift 0 counts if the image does not tile in that direction (not `closed`).
    """
    height, width = values.shape[:2]
    band = target.shape[1]
    spectrum = np.fft.rfft(values, axis=0)
    energy = (values**2).sum(axis=(0, 2))
    offsets = np.r_[0:overlap, band - overlap : band]
    target_spectrum = np.fft.rfft(target[:, offsets], axis=0)
    columns = np.arange(width - band + 1)
    index = columns[:, None] + offsets
    product = np.einsum("fxoc,foc->fx", spectrum[:, index].conj(), target_spectrum, optimize=True)
    correlation = np.fft.irfft(product, n=height, axis=0).T  # (columns, shifts)
    error = energy[index].sum(axis=1)[:, None] - 2.0 * correlation
    if not closed:
        error = error[:, :1]
    order = np.argsort(error, axis=None, kind="stable")[: _S.candidates]
    return columns[order // error.shape[1]], order % error.shape[1]


def _misfit(target: np.ndarray, sources: np.ndarray, overlap: int, closed: bool) -> np.ndarray:
    """Return (n, h, band, 3): the low-frequency misfit at both joints, spread over the band."""
    height, band = target.shape[:2]
    difference = target - sources
    mode = "wrap" if closed else "nearest"
    left, right = (
        gaussian_filter1d(part.mean(axis=2), height / 16, axis=1, mode=mode)[:, :, None]
        for part in (difference[:, :, :overlap], difference[:, :, band - overlap :])
    )
    position = (np.arange(band) + 0.5 - overlap / 2) / (band - overlap)
    share = np.clip(position, 0.0, 1.0)[None, None, :, None]
    return (1.0 - share) * left + share * right


def _band_weight(left: np.ndarray, right: np.ndarray, band: int) -> np.ndarray:
    """Return the (h, band) share of the source: 1 between the cuts, softened by a pixel."""
    column = np.arange(band)
    inside = (column > left[:, None]) & (column < band - 1 - right[:, None])
    soft = inside.astype(np.float64)
    soft[:, 1:-1] = (soft[:, :-2] + 2.0 * soft[:, 1:-1] + soft[:, 2:]) / 4.0
    return soft
