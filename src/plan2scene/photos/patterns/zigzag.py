"""Find herringbone and chevron: planks in columns that slant to alternate sides.

Both repeat along their columns and across them, and each column has only columns of the other slant
beside it. Chevron has a straight joint between its columns, herringbone has none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import itemgetter

import cv2
import numpy as np
from scipy.ndimage import maximum_filter, maximum_filter1d

from plan2scene.photos.patterns.bonds import Zigzag
from plan2scene.photos.patterns.joints import (
    DISTANCES,
    JOINTS,
    Overlap,
    Upright,
    across,
    evened,
    kept_along,
    lines,
    upright,
)
from plan2scene.photos.patterns.views import FloorView


@dataclass(frozen=True)
class ZigzagSettings:
    """Constants chosen on procedural herringbone, chevron, basket, planks and tiles.

    Those of columns were chosen on 43 synthetic homes and the demo.
    """

    width_m: tuple[float, float] = (0.04, 0.2)  #: range of the planks' widths that are tried
    ratio: tuple[float, float] = (2.5, 9.0)  #: range of length over width that is tried
    spine: float = 0.55  #: least score of the joints along the columns of a chevron
    fit: float = 0.02  #: largest change tried of angle (radians) and width; twice that of length
    period_m: tuple[float, float] = (0.2, 1.6)  #: range of periods across the columns
    of_extent: float = 0.7  #: largest period, share of the extent that is seen across the columns
    least: float = 0.03  #: least `Slants.clear` of a view that shows columns
    near_m: float = 0.045  #: side of the square over which the direction of lines is averaged
    coherent: float = 0.2  #: share of the mean gradient energy that is added to the local one
    same_period: float = 0.1  #: largest log ratio of the periods of planks and of their columns
    slant_deg: tuple[float, float] = (35.0, 62.0)  #: range of slants; others are measured wrongly
    noise: float = -0.15  #: lower limit of a view's score: less tells nothing of a plank's width
    usual_ratio: float = 5.3  #: usual length over width
    unusual: float = 0.15  #: score subtracted at e times the usual ratio (quadratic in the log)
    square_deg: float = 6.0  #: a slant farther than this from 45 degrees is that of a chevron


ZIGZAG = ZigzagSettings()
_STEP = 0.02  #: log ratio of the widths and of the ratios that are tried
_WIDTHS = np.exp(np.arange(np.log(ZIGZAG.width_m[0]), np.log(ZIGZAG.width_m[1]), _STEP))
_RATIOS = np.exp(np.arange(np.log(ZIGZAG.ratio[0]), np.log(ZIGZAG.ratio[1]), _STEP))
_PERIODS = np.exp(np.arange(np.log(ZIGZAG.period_m[0]), np.log(ZIGZAG.period_m[1]), 0.05))
_ANGLES = np.arange(0.0, 180.0, 3.0)


@dataclass(frozen=True, eq=False)
class Slants:
    """The slanting planks of one view, in columns of one direction."""

    view: FloorView
    columns_deg: float  #: from +x of the image towards +y (down), [0, 180)
    slant_deg: float  #: angle between planks and columns
    clear: float  #: how clearly lines slant to alternate sides from column to column, 0..0.64
    #: (n, m) float: how clearly planks of each of `_WIDTHS` and `_RATIOS` (length over width)
    #: repeat, -2..1; -2 where these do not fit the width of the columns
    scores: np.ndarray

    @property
    def columns(self) -> Upright:
        """The view turned so that columns run along x."""
        return upright(*evened(self.view.image, self.view.mask), self.columns_deg)


def find_zigzag(
    views: Sequence[FloorView], weights: np.ndarray, same_size: float
) -> tuple[Zigzag, float, list[tuple[Slants, float, float]]] | None:
    """Return the herringbone or chevron of views, how clear it is (0..0.64), and each view's part.

    A view's part is its slants, the planks' width there (metres) and how clear they are. Views have
    `weights` (n,); their scales may differ by the log ratio `same_size`. None if no view shows any.
    """
    weighted_slants = [
        (one, weight)
        for one, weight in ((slants(view), w) for view, w in zip(views, weights, strict=True))
        if one is not None
    ]
    if not weighted_slants:
        return None
    reach = 2 * round(same_size / _STEP) + 1
    wide = np.array([maximum_filter1d(one.scores, reach, axis=0) for one, _ in weighted_slants])
    worth = np.array([weight * one.clear for one, weight in weighted_slants])
    evidence = np.where(wide > -2.0, np.maximum(wide, ZIGZAG.noise), -2.0)
    pooled = np.tensordot(worth / worth.sum(), maximum_filter1d(evidence, 3, axis=2), 1)
    pooled -= ZIGZAG.unusual * np.log(_RATIOS / ZIGZAG.usual_ratio) ** 2
    k, j = np.unravel_index(int(pooled.argmax()), pooled.shape)
    rows = slice(max(k - reach // 2, 0), k + reach // 2 + 1)
    columns = slice(max(j - 1, 0), j + 2)
    read = []
    for one, weight in weighted_slants:
        line = one.scores[rows, columns].max(axis=1)
        if line.max() > -2.0:  # its columns are as wide as those of the other views
            read.append((one, float(_WIDTHS[rows][line.argmax()]), weight))
    clear = sum(one.clear * weight for one, _, weight in read) / max(weights.sum(), 1.0)
    slant = max(read, key=lambda item: item[0].clear * item[2])[0].slant_deg
    spine = 0.0
    for one, width, weight in read:
        at = width * _RATIOS[j] * np.sin(np.radians(one.slant_deg))
        near = np.abs(np.log(DISTANCES / at)) <= 0.05
        joints = across(one.columns)
        along = max((float(joints[name][near].max()) for name in ("dark", "light")), default=0.0)
        spine += one.clear * weight * along
    spine /= sum(one.clear * weight for one, _, weight in read)
    chevron = spine >= ZIGZAG.spine or abs(slant - 45.0) > ZIGZAG.square_deg
    zigzag = Zigzag(
        "chevron" if chevron else "herringbone",
        float(_WIDTHS[k]),
        float(_WIDTHS[k] * _RATIOS[j]),
        round(slant, 1) if chevron else 45.0,
    )
    return zigzag, float(clear), [(one, width, one.clear) for one, width, _ in read]


@lru_cache(maxsize=64)  # a view is needed twice: for its material and for its room
def slants(view: FloorView) -> Slants | None:
    """Return the slanting planks that a view shows in columns; None if there are none."""
    contrast, valid = evened(view.image, view.mask)
    alternation = _alternating(contrast, valid)
    if alternation is None or alternation[0] < ZIGZAG.least:
        return None
    clear, angle, period_m, ways = alternation
    near = np.arange(-9.0, 9.5, JOINTS.step_deg / 6)
    first, second = (way + near[np.argmax(kept_along(contrast, valid, way + near))] for way in ways)
    columns = (first + second) / 2
    columns += 90.0 * round((angle - columns) / 90.0)
    slant = abs((first - columns + 90.0) % 180.0 - 90.0)
    if not ZIGZAG.slant_deg[0] <= slant <= ZIGZAG.slant_deg[1]:
        columns, slant = angle, 45.0
        first, second = columns + slant, columns - slant
    along, alike = JOINTS.along_m * JOINTS.px_per_m, []
    for angle in (first, second):
        turned = upright(contrast, valid, angle)
        counts = Overlap(turned.valid)
        shifts = [counts.alike(line).alike for _, line in lines(turned, along, down=True)]
        alike.append([cv2.dilate(np.nan_to_num(a, nan=-1.0), np.ones((3, 3))) for a in shifts])
    scores = np.max(
        [
            np.minimum(_repeats(a, columns - first, slant), _repeats(b, columns - second, slant))
            for a, b in zip(*alike, strict=True)
        ],
        axis=0,
    )
    periods = 2 * _WIDTHS[:, None] * _RATIOS * np.sin(np.radians(slant))
    scores = np.where(np.abs(np.log(periods / period_m)) <= ZIGZAG.same_period, scores, -2.0)
    if scores.max() == -2.0:
        return None
    return Slants(view, columns % 180.0, slant, clear, scores)


#: Step in pixels at which the direction of lines is sampled.
_EACH_PX = 4


def _line_tensor(contrast: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction of lines (h, w) complex at every `_EACH_PX` pixels, and what is seen.

    It is the gradient's structure tensor: the argument is twice the gradient's angle, the modulus
    below 1, and largest where all lines nearby have one direction.
    """
    smooth = cv2.GaussianBlur(contrast, (0, 0), JOINTS.line_px)
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    seen = cv2.erode(valid.astype(np.uint8), np.ones((7, 7), np.uint8)).astype(np.float32)
    side = round(ZIGZAG.near_m * JOINTS.px_per_m)
    energy, real, imaginary = (
        cv2.blur(part * seen, (side, side)) for part in (gx**2 + gy**2, gx**2 - gy**2, 2 * gx * gy)
    )
    mean_energy = float((energy * seen).sum() / max(float(seen.sum()), 1.0))
    tensor = (real + 1j * imaginary) / (energy + max(ZIGZAG.coherent * mean_energy, 1e-9)) * seen
    return tensor[::_EACH_PX, ::_EACH_PX], seen[::_EACH_PX, ::_EACH_PX]


def _alternating(
    contrast: np.ndarray, valid: np.ndarray
) -> tuple[float, float, float, list[float]] | None:
    """Return the columns in which a view's lines slant to alternate sides; None if too little seen.

    These are how clearly they do, 0..0.64; the columns' direction (degrees) and period (metres);
    and the directions of the lines of both slants (degrees). Columns make the direction of lines a
    wave across them, and only across them. A basket weave has waves in two directions, and the
    lines of bricks have one direction nearly everywhere.
    """
    tensor, seen = _line_tensor(contrast, valid)
    rows, columns = np.nonzero(seen)
    if len(rows) < 100:
        return None
    mean = tensor.sum() / seen.sum()
    scale = JOINTS.px_per_m / _EACH_PX
    y, x = (np.arange(n) / scale for n in tensor.shape)
    angles, half = np.radians(_ANGLES), len(_ANGLES)
    turns = np.concatenate([angles, angles + np.pi])[:, None] + np.pi / 2  # across, both ways
    waves_x, waves_y = (2 * np.pi * f(turns) / _PERIODS for f in (np.cos, np.sin))
    part = np.exp(-1j * waves_x.ravel()[:, None] * x) @ (tensor - mean * seen).T
    whole = (part * np.exp(-1j * waves_y.ravel()[:, None] * y)).sum(axis=1) / seen.sum()
    there, back = whole.reshape(2, half, -1)
    turned = np.exp(-2j * angles)[:, None]
    sideways = (there * turned - np.conj(back * turned)) / 2j
    across_m = (np.cos(angles)[:, None] * rows - np.sin(angles)[:, None] * columns) / scale
    extent = np.ptp(across_m, axis=1)
    sideways[ZIGZAG.of_extent * extent[:, None] < _PERIODS] = 0.0
    strength = np.abs(sideways)
    near = maximum_filter(strength, (5, 5), mode=("wrap", "nearest"))  # photos shear a little
    one_way = strength - np.roll(near, half // 2, axis=0)
    k, j = divmod(int(one_way.argmax()), one_way.shape[1])
    wave = np.cos(2 * np.pi * across_m[k] / _PERIODS[j] + np.angle(sideways[k, j]))
    ways = [
        float(np.degrees(np.angle(tensor[rows, columns] @ np.maximum(sign * wave, 0.0))) / 2 + 90.0)
        for sign in (1.0, -1.0)
    ]
    constant = 0.5 * abs((mean * turned[k, 0]).imag)
    clear = float(min(one_way[k, j], strength[k, j] - constant))
    return clear, float(_ANGLES[k]), float(_PERIODS[j]), ways


def _repeats(alike: np.ndarray, columns_deg: float, slant_deg: float) -> np.ndarray:
    """Return how clearly (n, m) lines along x repeat like the planks of one slant.

    `alike` (h, w) is the autocorrelation in steps of two pixels, negative shifts at the end;
    `columns_deg` is the angle between the columns and the lines.
    """
    width, ratio = _WIDTHS[:, None], _RATIOS[None, :]
    sine = np.sin(np.radians(slant_deg))
    turn = np.radians(columns_deg)
    u, v = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    step, across = width / sine + 0 * ratio, 2 * width * ratio * sine
    scale = JOINTS.px_per_m / 2

    def at(along: np.ndarray | float, over: np.ndarray | float) -> np.ndarray:
        x, y = ((along * u[k] + over * v[k]) * scale + 0 * step for k in (0, 1))
        return cv2.remap(
            alike,
            np.mod(x, alike.shape[1]).astype(np.float32),
            np.mod(y, alike.shape[0]).astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_WRAP,
        )

    def mean(
        along: float, over: np.ndarray | float, reach: range, *, mirrored: bool = False
    ) -> np.ndarray:
        way = (np.cos(2 * turn), -np.sin(2 * turn)) if mirrored else (1.0, 0.0)
        shifts = [(k + along) * step for k in reach]
        return np.mean([at(way[0] * shift, way[1] * shift + over) for shift in shifts], axis=0)

    beside, back = range(-3, 4), range(-4, 4)
    same = *(at(k * step, 0.0) for k in range(1, 5)), mean(0.0, across, beside)
    length = width * ratio
    lengthwise = (length * np.cos(turn), -length * np.sin(turn))
    other = [
        mean(0.5, 0.0, range(1, 4)),
        mean(0.5, across, back),
        mean(0.0, across / 2, beside),
        np.mean([at(lengthwise[0] + k * step, lengthwise[1]) for k in beside], axis=0),
        # The same shifts, mirrored to the other slant: there a basket weave repeats as well.
        mean(0.0, 0.0, range(1, 5), mirrored=True),
    ]
    return np.asarray(np.min(same, axis=0) - np.max(other, axis=0))


def fitted(zigzag: Zigzag, view: Upright) -> tuple[Zigzag, np.ndarray]:
    """Fit a pattern to a view turned to its columns; return its sizes there and its place.

    The place is (h, w, 2), metres of each pixel along the columns and across them, as
    :meth:`Zigzag.planks` takes them.
    """
    scale = JOINTS.px_per_m
    rows, columns = (at[::4] for at in np.nonzero(view.valid))
    value = cv2.GaussianBlur(view.contrast, (0, 0), 1.0)[rows, columns]
    middle = np.array([columns.mean(), rows.mean()])
    places = (np.stack([columns, rows], axis=1) - middle) / scale
    beside = np.linspace(-ZIGZAG.fit, ZIGZAG.fit, 9)

    def fit(
        turn: float, wide: float, long: float
    ) -> tuple[float, tuple[float, float], Zigzag, np.ndarray]:
        sized = replace(zigzag, width_m=zigzag.width_m * wide, length_m=zigzag.length_m * long)
        worth, shift = _shifted(sized, _turned(places, turn), value)
        return worth, (turn, wide), sized, shift

    fits = [fit(turn, 1.0 + wide, 1.0) for turn in beside for wide in beside]
    _, shape, *_ = max(fits, key=itemgetter(0))
    fits += [fit(*shape, 1.0 + long) for long in 2 * beside]
    _, (turn, _), sized, shift = max(fits, key=itemgetter(0))
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in view.valid.shape[::-1])), axis=-1)
    return sized, _turned((grid - middle) / scale, turn) + shift


def _turned(places: np.ndarray, angle: float) -> np.ndarray:
    """Return places (..., 2) rotated back by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(places @ np.array([[cosine, -sine], [sine, cosine]]))


def _shifted(zigzag: Zigzag, places: np.ndarray, value: np.ndarray) -> tuple[float, np.ndarray]:
    """Return how well a pattern's joints fit contrast (n,) at places (n, 2), and the best shift."""
    period = np.array(zigzag.period_m)
    bins = np.maximum(np.round(period * JOINTS.px_per_m), 1).astype(int)
    cell = np.floor(places / period % 1.0 * bins).astype(int) % bins
    flat = cell[:, 0] * bins[1] + cell[:, 1]
    size = int(bins.prod())
    mean = np.bincount(flat, value, size) / np.maximum(np.bincount(flat, minlength=size), 1)
    at = np.stack(np.meshgrid(*((np.arange(n) + 0.5) / n for n in bins), indexing="ij"), axis=-1)
    border = zigzag.planks(*(at.reshape(-1, 2) * period).T)[3]
    joint = (border < 1.0 / JOINTS.px_per_m).astype(np.float64)
    joint -= joint.mean()
    both = (np.fft.rfft2(part.reshape(bins)) for part in (joint, mean - mean.mean()))
    alike = np.abs(np.fft.irfft2(next(both) * np.conj(next(both)), tuple(bins)))
    shift = np.unravel_index(int(alike.argmax()), alike.shape) / bins * period
    return float(alike.max() / max(np.linalg.norm(joint), 1e-9)), shift
