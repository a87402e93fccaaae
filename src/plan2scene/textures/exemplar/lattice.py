"""Orientation and period of a regular pattern: tiles, bricks, planks.

Joints and grain concentrate a crop's spectrum on two perpendicular lines, which give the angle;
along them the normalised autocorrelation peaks at the periods. A period counts where several
crops of the surface agree on it. Either direction may have one without the other (planks of one
width and random lengths).
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

_STEP_DEG = 0.25
_SPECTRUM = 256  # side of the padded spectrum
_BANDS = (8, 90)  # radii of it that hold patterns
_COARSE = 5  # least radius for a checkerboard, whose first frequencies are low
_LEAST_PEAK = 0.25  # autocorrelation that a period needs, over the root of the overlap's share
_LEAST_RISE = 0.15  # and its rise over the valley before it
_ACROSS = 0.1  # autocorrelation that is left of a period without the lines along its direction
_SHARE_OF_BEST = 0.8  # the smallest lag this near to the best one is the period
_DIAGONAL = 0.85  # share of the upright pattern's peaks that a diagonal one needs
_SQUARE = 0.08  # log ratio of the sides of square tiles
_SHORTEST = 5.0  # px
_LONGEST = 0.8  # of the side


@dataclass(frozen=True)
class CropLattice:
    """A crop's pattern.

    Attributes
    ----------
    angle_deg : float
        Turn of its axes from the crop's, x towards y (down), within 45 degrees.
    clear : bool
        Whether the angle stands out.
    periods : (float, float)
        Along its x and y axes, in crop pixels; NaN where there is none, and where no angle stands
        out.
    peaks : (float, float)
        Autocorrelation at the periods, 0 where there is none.
    """

    angle_deg: float
    clear: bool
    periods: tuple[float, float]
    peaks: tuple[float, float]


def find_lattice(luma: np.ndarray, mask: np.ndarray) -> CropLattice:
    """Return orientation and periods of one crop.

    Parameters
    ----------
    luma : (s, s) float
        Grey or log grey values under even light.
    mask : (s, s) bool
        Pixels to leave out.
    """
    weight = (~mask).astype(np.float64)
    values = _band(luma, weight)
    power = _spectrum(values, weight)
    angle, clear = _orientation(power, _BANDS[0])
    if clear:
        return _lattice(values, weight, angle)
    # Without its first frequencies a checkerboard of two colours seems to lie at atan(1/3).
    other, clear = _orientation(power, _COARSE)
    if clear:
        coarse = _lattice(values, weight, other)
        if np.isfinite(coarse.periods).all():
            return coarse
    return CropLattice(angle, False, (float("nan"), float("nan")), (0.0, 0.0))


def _lattice(values: np.ndarray, weight: np.ndarray, angle: float) -> CropLattice:
    """Return the lattice of a pattern whose axes are clearly turned by `angle` degrees."""
    periods, peaks = _periods(*_turned(values, weight, angle))
    if abs(angle) > 22.5 and abs(np.log(periods[0] / periods[1])) < _SQUARE:  # False for NaN
        # Square tiles laid diagonally repeat along the crop's axes, too: they stay so.
        less = angle - 45.0 if angle > 0 else angle + 45.0
        others, heights = _periods(*_turned(values, weight, less))
        if max(others) < 1.6 * max(periods) and sum(heights) >= _DIAGONAL * sum(peaks):
            angle, periods, peaks = less, others, heights
    return CropLattice(angle, True, periods, peaks)


def agreed_periods(
    lattices: list[CropLattice], sides: np.ndarray, size: int, tolerance: float
) -> tuple[float, float]:
    """Return the periods in sides of the tile that most crops agree on; NaN where they do not.

    Parameters
    ----------
    sides : (n,) float
        Sides of the crops in sides of the tile.
    size : int
        Side of a crop in pixels.
    tolerance : float
        Log ratio within which periods agree.
    """
    agreed = []
    for axis in (0, 1):
        periods = np.array([lattice.periods[axis] for lattice in lattices]) * sides / size
        known = periods[np.isfinite(periods)]
        period = float("nan")
        if len(known):
            apart = np.abs(np.log(known[:, None] / known[None, :]))
            closeness = np.exp(-((apart / tolerance) ** 2)).sum(axis=1)
            near = known[apart[int(closeness.argmax())] < tolerance]
            # Crops that are too small for a period have no say on it; those that are not two
            # periods large show a joint twice by chance.
            large = sides[_LONGEST * sides > np.median(near)]
            voters = float(np.minimum(large / np.median(near) - 1.0, 1.0).sum())
            if len(near) >= max(voters, 2 if len(periods) > 2 else 1) / 2:
                period = float(np.median(near))
        agreed.append(period)
    return agreed[0], agreed[1]


def whole_periods(
    periods: tuple[float, float], most: float = 1.35
) -> tuple[int, int, float, float]:
    """Return how many periods to cut and the cut's sides, both in sides of the tile.

    The cut is nearly square and nearly the tile, where the periods allow; a direction without
    period is cut as the other one, and counts 0.
    """
    known = [p for p in periods if np.isfinite(p) and p <= most]
    if not known:
        return 0, 0, 1.0, 1.0
    if len(known) == 1:
        count = max(1, round(1.0 / known[0]))
        side = count * known[0]
        along = np.isfinite(periods[0]) and periods[0] <= most
        return (count, 0, side, side) if along else (0, count, side, side)
    options = []
    for columns in range(1, max(2, round(most / periods[0])) + 1):
        for rows in range(1, max(2, round(most / periods[1])) + 1):
            wide, high = columns * periods[0], rows * periods[1]
            uneven = abs(np.log(wide / high))
            away = abs(np.log(np.sqrt(wide * high)))
            options.append((2.0 * uneven + away, columns, rows, wide, high))
    _, columns, rows, wide, high = min(options)
    return columns, rows, wide, high


def _band(luma: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the values less their slow part, of unit variance, 0 where `weight` is."""
    sigma = luma.shape[0] / 10
    slow = cv2.GaussianBlur(luma * weight, (0, 0), sigma)
    slow /= np.maximum(cv2.GaussianBlur(weight, (0, 0), sigma), 1e-3)
    values = (luma - slow) * weight
    spread = np.sqrt((values**2).sum() / max(weight.sum(), 1.0))
    return np.clip(values / max(spread, 1e-6), -4.0, 4.0)


def _spectrum(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the amplitudes (_SPECTRUM, _SPECTRUM) float32 of the windowed values, 0 amid them."""
    window = np.hanning(values.shape[0] + 2)[1:-1]
    spectrum = np.fft.fft2(values * weight * np.outer(window, window), (_SPECTRUM, _SPECTRUM))
    return np.fft.fftshift(np.abs(spectrum)).astype(np.float32)


def _orientation(power: np.ndarray, least: int) -> tuple[float, bool]:
    """Return the angle in degrees of the lines that hold the spectrum, and whether it is clear.

    `least` is the smallest radius of the spectrum that counts.
    """
    angles = np.arange(-45.0, 135.0, _STEP_DEG)
    radii = np.arange(least, _BANDS[1], dtype=np.float64)
    radians = np.radians(angles)[:, None]
    x = (_SPECTRUM // 2 + radii * np.cos(radians)).astype(np.float32)
    y = (_SPECTRUM // 2 + radii * np.sin(radians)).astype(np.float32)
    polar = cv2.remap(power, x, y, cv2.INTER_LINEAR).astype(np.float64)
    energy = (polar**2).sum(axis=1)
    half = len(angles) // 2
    folded = energy[:half] + energy[half:]
    smooth = np.convolve(np.r_[folded[-8:], folded, folded[:8]], np.hanning(11)[1:-1], "same")[8:-8]
    top = int(smooth.argmax())
    around = np.arange(top - 6, top + 7)
    local = np.maximum(smooth[around % half] - 0.5 * smooth[top], 0.0)
    centre = float((local * around).sum() / local.sum())
    angle = (angles[0] + centre * _STEP_DEG + 45.0) % 90.0 - 45.0
    return angle, bool(smooth[top] > 2.0 * np.median(smooth))


def _turned(values: np.ndarray, weight: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return values and weight with the pattern's axes along the image's."""
    middle = (values.shape[0] - 1) / 2
    matrix = cv2.getRotationMatrix2D((middle, middle), angle, 1.0)
    size = values.shape
    turned = cv2.warpAffine(values, matrix, size, flags=cv2.INTER_CUBIC)
    valid = cv2.warpAffine(weight, matrix, size, flags=cv2.INTER_LINEAR)
    return turned, (valid > 0.99).astype(np.float64)


def _periods(
    values: np.ndarray, weight: np.ndarray
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the periods in pixels along x and y (NaN for none) and their autocorrelations.

    A line along a direction is like itself at every lag of it: what repeats there without such
    lines, too, is a period.
    """
    spectrum, overlap = _overlap(weight)
    score = _autocorrelation(values, weight, spectrum, overlap)
    least = _LEAST_PEAK / np.sqrt(np.maximum(overlap / weight.sum(), 0.01))
    found = []
    for axis in (1, 0):
        period, peak = _first_period(_along(score, axis), _along(least, axis, width=1))
        if np.isfinite(period):
            share = np.maximum(weight.sum(axis=axis, keepdims=True), 1.0)
            lines = (values * weight).sum(axis=axis, keepdims=True) / share
            without = _autocorrelation(values - lines, weight, spectrum, overlap)
            lag = round(period)
            if _along(without, axis)[lag - 1 : lag + 2].max() < _ACROSS:
                period, peak = float("nan"), 0.0
        found.append((period, peak))
    (x, at_x), (y, at_y) = found
    return (x, y), (at_x, at_y)


def _along(score: np.ndarray, axis: int, width: int = 3) -> np.ndarray:
    """Return a curve over lags 0.. along an axis (1: x), the best of `width` lags across it."""
    near = np.r_[0, 1, -1][:width]
    longest = int(_LONGEST * len(score) / 2)
    return np.asarray(np.take(score, near, axis=1 - axis).max(axis=1 - axis))[: longest + 1]


def _overlap(weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectrum of weights (s, s), and their overlap at each lag (2 s, 2 s)."""
    shape = (2 * weight.shape[0],) * 2
    spectrum = np.fft.rfft2(weight, shape)
    return spectrum, np.fft.irfft2(np.abs(spectrum) ** 2, shape)


def _autocorrelation(
    values: np.ndarray, weight: np.ndarray, spectrum: np.ndarray, overlap: np.ndarray
) -> np.ndarray:
    """Return the normalised autocorrelation at all lags (2 s, 2 s) of values (s, s).

    `spectrum` and `overlap` are the weights' of :func:`_overlap`.
    """
    side = values.shape[0]
    shape = (2 * side, 2 * side)
    f_values = np.fft.rfft2(values * weight, shape)
    f_square = np.fft.rfft2(values**2 * weight, shape)
    product = np.fft.irfft2(np.abs(f_values) ** 2, shape)
    energy = np.fft.irfft2(f_square.conj() * spectrum, shape)
    there, back = energy, np.roll(energy[::-1, ::-1], (1, 1), (0, 1))
    score = product / np.sqrt(np.maximum(there * back, 1e-9))
    return np.where(overlap > 0.08 * side**2, score, -1.0)


def _first_period(curve: np.ndarray, least: np.ndarray) -> tuple[float, float]:
    """Return the period of an autocorrelation curve over lags 0.., and its height there.

    `least`: the height that a period needs at each lag.
    """
    lags = np.arange(1, len(curve) - 1)
    tops = lags[(curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:]) & (lags >= _SHORTEST)]
    valley = np.minimum.accumulate(curve)
    tops = tops[(curve[tops] > least[tops]) & (curve[tops] - valley[tops] > _LEAST_RISE)]
    if not len(tops):
        return float("nan"), 0.0
    first = int(tops[curve[tops] >= _SHARE_OF_BEST * curve[tops].max()][0])
    period = _summit(curve, first)
    multiple = 2
    while multiple * period < len(curve) - 2:
        near = tops[np.abs(tops - multiple * period) < max(1.5, 0.12 * period)]
        if not len(near):
            break
        period = _summit(curve, int(near[curve[near].argmax()])) / multiple
        multiple += 1
    return period, float(curve[first])


def _summit(curve: np.ndarray, lag: int) -> float:
    """Return the sub-pixel place of a local maximum (parabola through three lags)."""
    before, at, after = curve[lag - 1 : lag + 2]
    bend = before - 2.0 * at + after
    return lag + (0.5 * (before - after) / bend if bend < 0 else 0.0)
