"""Direction and period of a pattern: tiles, bricks, planks; crops straightened by them.

Joints and grain concentrate a crop's spectrum on two perpendicular lines, which give the angle;
along them the normalised autocorrelation peaks at the periods. A period counts if several crops of
the surface agree on it. One direction may have a period without the other (planks of one width and
random lengths). Crops are then brought to one scale and orientation, so that whole periods fill the
tile.

A photo's frame is known up to quarter turns, so the same floor runs along x in one crop and along
y in the next. Planks, boards and grain vary much more across their length than along it: this tells
which crops have to be turned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.paint.shading import log_luma, surroundings
from plan2scene.textures.exemplar.settings import EXEMPLAR
from plan2scene.textures.quilting import Source


@dataclass(frozen=True)
class CropLattice:
    """Orientation and periods of the pattern in one crop."""

    angle_deg: float  #: from the crop's axes to the pattern's, x towards y (down), -45 to 45
    clear: bool  #: whether the spectrum shows the angle clearly
    periods: tuple[float, float]  #: along its axes, crop pixels; NaN: none, or no clear angle


_NO_PERIODS = (float("nan"), float("nan"))


def find_lattice(luma: np.ndarray, mask: np.ndarray) -> CropLattice:
    """Return orientation and periods of one crop.

    `luma` (s, s) are grey or log grey values under even light, `mask` bool the pixels to leave out.
    """
    weight = (~mask).astype(np.float64)
    values = _band(luma, weight)
    power = _spectrum(values, weight)
    angle, clear = _orientation(power, EXEMPLAR.bands[0])
    if clear:
        return _lattice(values, weight, angle)
    # Without its first frequencies a checkerboard of two colours seems to lie at atan(1/3).
    other, clear = _orientation(power, EXEMPLAR.coarse)
    if clear:
        coarse = _lattice(values, weight, other)
        if np.isfinite(coarse.periods).all():
            return coarse
    return CropLattice(angle, False, _NO_PERIODS)


def _lattice(values: np.ndarray, weight: np.ndarray, angle: float) -> CropLattice:
    """Return the lattice of a pattern whose axes are clearly turned by `angle` degrees."""
    periods, peaks = _periods(*_turned(values, weight, angle))
    if (
        abs(angle) > 22.5 and abs(np.log(periods[0] / periods[1])) < EXEMPLAR.square
    ):  # False for NaN
        # Square tiles laid diagonally also repeat along the crop's axes: they stay diagonal.
        less = angle - 45.0 if angle > 0 else angle + 45.0
        others, heights = _periods(*_turned(values, weight, less))
        if max(others) < 1.6 * max(periods) and sum(heights) >= EXEMPLAR.diagonal * sum(peaks):
            angle, periods = less, others
    return CropLattice(angle, True, periods)


def agreed_periods(
    lattices: list[CropLattice], sides: np.ndarray, size: int, tolerance: float
) -> tuple[float, float]:
    """Return the periods, over the tile's side, that most crops agree on; NaN where they do not.

    `sides` (n,) are the crops' sides over the tile's side, `size` is a crop's side in pixels,
    `tolerance` the log ratio within which periods agree.
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
            # Crops that are too small for a period have no vote on it. Crops smaller than two
            # periods show a joint twice only by chance, so they have part of a vote.
            large = sides[EXEMPLAR.longest * sides > np.median(near)]
            voters = float(np.minimum(large / np.median(near) - 1.0, 1.0).sum())
            if len(near) >= max(voters, 2 if len(periods) > 2 else 1) / 2:
                period = float(np.median(near))
        agreed.append(period)
    return agreed[0], agreed[1]


@dataclass(frozen=True)
class Cut:
    """The part of a surface's pattern that the tile shows."""

    columns: int  #: number of whole periods along x; 0 where x has no period
    rows: int  #: the same along y
    wide: float  #: width over the side of the tile that was asked for
    high: float  #: height over the same


def whole_periods(periods: tuple[float, float], most: float = 1.35) -> Cut:
    """Return the cut that is as square and as near to the tile's size as whole periods allow.

    A direction without a period (or with one longer than `most`) has count 0 and the other
    direction's side.
    """
    x, y = (p if p <= most else 0.0 for p in periods)  # also 0 for NaN
    if not (x and y):
        period = x or y
        count = max(1, round(1.0 / period)) if period else 0
        side = count * period or 1.0
        return Cut(count if x else 0, count if y else 0, side, side)
    options = []
    for columns in range(1, max(2, round(most / x)) + 1):
        for rows in range(1, max(2, round(most / y)) + 1):
            wide, high = columns * x, rows * y
            uneven = abs(np.log(wide / high))
            away = abs(np.log(np.sqrt(wide * high)))
            options.append((2.0 * uneven + away, columns, rows, wide, high))
    return Cut(*min(options)[1:])


def _band(luma: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the values minus their slow part, scaled to unit variance; 0 where `weight` is 0."""
    values = (luma - surroundings(luma, weight)) * weight
    spread = np.sqrt((values**2).sum() / max(weight.sum(), 1.0))
    return np.clip(values / max(spread, 1e-6), -4.0, 4.0)


def _spectrum(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the amplitudes (n, n) float32 of the windowed values, frequency 0 in the middle."""
    window = np.hanning(values.shape[0] + 2)[1:-1]
    spectrum = np.fft.fft2(
        values * weight * np.outer(window, window), (EXEMPLAR.spectrum_px, EXEMPLAR.spectrum_px)
    )
    return np.fft.fftshift(np.abs(spectrum)).astype(np.float32)


def _orientation(power: np.ndarray, least: int) -> tuple[float, bool]:
    """Return the angle of the two perpendicular lines with most energy, and whether it is clear.

    The angle is in degrees. `least` is the smallest radius of the spectrum that counts.
    """
    angles = np.arange(-45.0, 135.0, EXEMPLAR.step_deg)
    radii = np.arange(least, EXEMPLAR.bands[1], dtype=np.float64)
    radians = np.radians(angles)[:, None]
    x = (EXEMPLAR.spectrum_px // 2 + radii * np.cos(radians)).astype(np.float32)
    y = (EXEMPLAR.spectrum_px // 2 + radii * np.sin(radians)).astype(np.float32)
    polar = cv2.remap(power, x, y, cv2.INTER_LINEAR).astype(np.float64)
    energy = (polar**2).sum(axis=1)
    half = len(angles) // 2
    folded = energy[:half] + energy[half:]
    smooth = np.convolve(np.r_[folded[-8:], folded, folded[:8]], np.hanning(11)[1:-1], "same")[8:-8]
    top = int(smooth.argmax())
    around = np.arange(top - 6, top + 7)
    local = np.maximum(smooth[around % half] - 0.5 * smooth[top], 0.0)
    centre = float((local * around).sum() / local.sum())
    angle = (angles[0] + centre * EXEMPLAR.step_deg + 45.0) % 90.0 - 45.0
    return angle, bool(smooth[top] > 2.0 * np.median(smooth))


def _turned(values: np.ndarray, weight: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return values and weight, rotated so that the pattern's axes lie along the image's."""
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

    A straight line correlates with itself at every lag along its direction. So a period counts only
    if the correlation remains after such lines are subtracted.
    """
    spectrum, overlap = _overlap(weight)
    score = _autocorrelation(values, weight, spectrum, overlap)
    least = EXEMPLAR.least_peak / np.sqrt(np.maximum(overlap / weight.sum(), 0.01))
    by_axis = []
    for axis in (1, 0):
        period, peak = _first_period(_along(score, axis), _along(least, axis, width=1))
        if np.isfinite(period):
            share = np.maximum(weight.sum(axis=axis, keepdims=True), 1.0)
            lines = (values * weight).sum(axis=axis, keepdims=True) / share
            without = _autocorrelation(values - lines, weight, spectrum, overlap)
            lag = round(period)
            if _along(without, axis)[lag - 1 : lag + 2].max() < EXEMPLAR.across:
                period, peak = float("nan"), 0.0
        by_axis.append((period, peak))
    (x, at_x), (y, at_y) = by_axis
    return (x, y), (at_x, at_y)


def _along(score: np.ndarray, axis: int, width: int = 3) -> np.ndarray:
    """Return a curve over lags 0.. along an axis (1: x), the maximum of `width` lags across it."""
    near = np.r_[0, 1, -1][:width]
    longest = int(EXEMPLAR.longest * len(score) / 2)
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

    `spectrum` and `overlap` are what :func:`_overlap` returns for the weights.
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
    tops = lags[
        (curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:]) & (lags >= EXEMPLAR.shortest_px)
    ]
    valley = np.minimum.accumulate(curve)
    tops = tops[(curve[tops] > least[tops]) & (curve[tops] - valley[tops] > EXEMPLAR.least_rise)]
    if not len(tops):
        return float("nan"), 0.0
    first = int(tops[curve[tops] >= EXEMPLAR.share_of_best * curve[tops].max()][0])
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


def find_pattern(
    flat: np.ndarray, masks: np.ndarray, sides: np.ndarray, *, known: bool
) -> tuple[list[CropLattice], Cut, np.ndarray]:
    """Return the crops' lattices, the cut, and which crops show its pattern, (n,) bool.

    `flat` (n, s, s, 3) are crops under even light, `masks` (n, s, s) bool their spoiled pixels,
    `sides` (n,) their sides over that of the tile asked for. `known`: whether all scales are known.
    """
    lattices = [find_lattice(log_luma(i), m) for i, m in zip(flat, masks, strict=True)]
    lattices = _usual_turns(lattices)
    size = flat.shape[1]
    tolerance = EXEMPLAR.same_period if known else EXEMPLAR.alike_period
    periods = agreed_periods(lattices, sides, size, tolerance)
    cut = whole_periods(periods)
    fits = np.ones(len(lattices), dtype=bool)
    checked = []
    for k, lattice in enumerate(lattices):
        crop_periods = [
            p
            if np.isfinite(period) and abs(np.log(p * sides[k] / size / period)) < tolerance
            # a crop without the period is scaled by its metres
            else period * size / sides[k]
            for p, period in zip(lattice.periods, periods, strict=True)
        ]
        fits[k] = all(
            not np.isfinite(period)
            or p == lattice.periods[axis]
            # a crop smaller than two periods shows a joint twice only by chance
            or (not np.isfinite(lattice.periods[axis]) and known and sides[k] < 2.0 * period)
            for axis, (p, period) in enumerate(zip(crop_periods, periods, strict=True))
        )
        checked.append(replace(lattice, periods=(crop_periods[0], crop_periods[1])))
    if fits.sum() < EXEMPLAR.enough_periods:
        fits[:] = True
    return checked, cut, fits


def _usual_turns(lattices: list[CropLattice]) -> list[CropLattice]:
    """Return the lattices turned to the usual angle; unclear and odd angles are replaced by it.

    Angles are known up to quarter turns. A lattice that is nearer after a quarter turn is turned,
    and its axes are exchanged. The usual angle is 0 if fewer than half of the crops have a clear
    one.
    """
    quarters = np.radians([4.0 * lattice.angle_deg for lattice in lattices if lattice.clear])
    usual_angle = 0.0
    if 2 * len(quarters) >= len(lattices):
        usual_angle = float(np.degrees(np.angle(np.exp(1j * quarters).mean())) / 4.0)
    result = []
    for lattice in lattices:
        away = (lattice.angle_deg - usual_angle + 45.0) % 90.0 - 45.0
        if not lattice.clear or abs(away) > EXEMPLAR.odd_turn_deg:
            result.append(replace(lattice, angle_deg=usual_angle, periods=_NO_PERIODS))
        elif abs(usual_angle + away - lattice.angle_deg) > 1.0:
            periods = lattice.periods[::-1]
            result.append(replace(lattice, periods=periods, angle_deg=usual_angle + away))
        else:
            result.append(lattice)
    return result


def straightened(
    image: np.ndarray, mask: np.ndarray, side: float, lattice: CropLattice, cut: Cut, size: int
) -> Source:
    """Return a crop (s, s, 3) float turned and scaled to a tile of `size` px that shows the cut.

    `mask` are its spoiled pixels, `side` is its side over that of the tile asked for.
    """
    px = image.shape[0]
    steps = []  # crop pixels per tile pixel
    for count, extent, period in zip(
        (cut.columns, cut.rows), (cut.wide, cut.high), lattice.periods, strict=True
    ):
        steps.append(count * period / size if count else extent * px / (side * size))
    turn = np.radians(lattice.angle_deg)
    x_axis = steps[0] * np.array([np.cos(turn), np.sin(turn)])
    y_axis = steps[1] * np.array([-np.sin(turn), np.cos(turn)])
    matrix = np.stack([x_axis, y_axis], axis=1)  # tile offset -> crop offset
    middle = (px - 1) / 2
    corners = np.linalg.inv(matrix) @ (middle * np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]))
    out = [min(size, max(8, 2 * int(np.floor(np.abs(corners[axis]).max())))) for axis in (0, 1)]
    centre = np.array([(n - 1) / 2 for n in out])
    affine = np.column_stack([matrix, middle - matrix @ centre])
    flags = cv2.WARP_INVERSE_MAP
    size_xy = (out[0], out[1])
    if max(steps) > 1.6:
        image = cv2.GaussianBlur(image, (0, 0), 0.4 * float(np.sqrt(max(steps) ** 2 - 1.0)))
    warped = cv2.warpAffine(
        image.astype(np.float32), affine, size_xy, flags=flags | cv2.INTER_CUBIC
    )
    inside = (~mask).astype(np.float32)
    inside[[0, -1]] = inside[:, [0, -1]] = 0.0
    valid = cv2.warpAffine(inside, affine, size_xy, flags=flags | cv2.INTER_LINEAR) > 0.99
    valid[[0, -1]] = valid[:, [0, -1]] = False  # its borders do not join each other
    return Source(np.clip(warped, 0.0, 1.0), valid)


def grain(luma: np.ndarray, mask: np.ndarray) -> float:
    """Return the grain of a crop: 1 for a pattern along x, -1 along y, 0 for neither.

    The structure tensor's energies along both axes: (Jyy - Jxx) / (Jxx + Jyy). `luma` (s, s) are
    log grey values, `mask` bool the pixels to leave out.
    """
    band = pattern_band(luma)
    used = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
    across, down = (cv2.Sobel(band, cv2.CV_64F, dx, 1 - dx)[used] for dx in (1, 0))
    energy = float((across**2).sum() + (down**2).sum())
    return float((down**2).sum() - (across**2).sum()) / energy if energy > 0 else 0.0


def directed(grains: np.ndarray) -> bool:
    """Return whether most crops, given their grains (n,), have a direction, as planks do."""
    return bool((np.abs(grains) >= EXEMPLAR.clear).sum() >= EXEMPLAR.directed * len(grains))


def quarter_turns(grains: np.ndarray) -> np.ndarray:
    """Return which crops have to be turned by 90 degrees to run as most do, (n,) bool.

    All are False where too few crops have a direction.
    """
    clear = np.abs(grains) >= EXEMPLAR.clear
    if not directed(grains):
        return np.zeros(len(grains), dtype=bool)
    usual = np.sign(grains[clear].sum()) or 1.0
    return np.asarray(clear & (np.sign(grains) != usual))


def faintness(luma: np.ndarray, masks: np.ndarray, grains: np.ndarray) -> np.ndarray:
    """Return the log ratio (n,) of the better crops' contrast to each crop's, at least 0.

    It is 0 for the quarter with the strongest contrast: glare hides the planks of the others. It is
    0 for all crops of a surface without a direction, where contrast comes from objects, not the
    pattern. `luma` (n, s, s) are log grey values, `masks` (n, s, s) as in :func:`grain`.
    """
    if not directed(grains):
        return np.zeros(len(grains))
    band = [pattern_band(one)[~mask].std() for one, mask in zip(luma, masks, strict=True)]
    contrast = np.maximum(np.nan_to_num(band), 1e-4)
    return np.maximum(np.log(np.percentile(contrast, 75) / contrast), 0.0)


def pattern_band(luma: np.ndarray) -> np.ndarray:
    """Return log grey values (s, s), band-passed to the scales of a pattern."""
    values = luma.astype(np.float64)
    return cv2.GaussianBlur(values, (0, 0), EXEMPLAR.fine) - cv2.GaussianBlur(
        values, (0, 0), EXEMPLAR.slow
    )


def grains_of(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return the :func:`grain` (n,) of crops (n, s, s)."""
    return np.array([grain(one, mask) for one, mask in zip(luma, masks, strict=True)])


def one_way(
    flat: np.ndarray, masks: np.ndarray, grains: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return crops (n, s, s, 3) and masks (n, s, s) that run one way, and which were turned."""
    turned = quarter_turns(grains)
    flat, masks = flat.copy(), masks.copy()
    flat[turned] = np.rot90(flat[turned], axes=(1, 2))
    masks[turned] = np.rot90(masks[turned], axes=(1, 2))
    return flat, masks, turned
