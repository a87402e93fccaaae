"""Find the joints of a floor that is seen straight on: their direction and their distance.

The direction is the one along which the image, averaged over strips, keeps most of its contrast.
The distances are periods of the autocorrelation of lines. A line is darker or lighter than what is
beside it, or a step between boards of different tone. Lines that do not repeat are ignored.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy import fft

from plan2scene.paint.shading import log_luma
from plan2scene.photos.patterns.bonds import PX_PER_M


@dataclass(frozen=True)
class JointSettings:
    """Constants chosen on renderings of procedural materials and by looking at real floors."""

    px_per_m: float = PX_PER_M  #: resolution of the images that are searched
    slow_m: float = 0.06  #: sigma of the local mean that is subtracted: it is light, not joints
    near_m: float = 0.2  #: sigma of the neighbourhood whose contrast normalises a pixel
    most: float = 3.0  #: limit of the normalised contrast
    rim_m: float = 0.025  #: margin left out at the mask's border, where objects cast shadows
    step_deg: float = 3.0  #: step of the directions tried at first; later a sixth of it
    strip_m: float = 0.4  #: length of the strips that are averaged along a direction
    line_px: float = 1.2  #: sigma of the blur across a joint
    along_m: float = 0.04  #: sigma of the blur along a joint
    loose_px: float = 1.6  #: sigma of the blur that tolerates a joint off its place
    band_m: float = 0.12  #: likeness is averaged over shifts along the joints up to this, each way
    shortest_m: float = 0.04  #: least distance of joints
    longest_m: float = 1.6  #: largest distance of joints
    of_extent: float = 0.75  #: largest period, share of the extent that is seen
    least_overlap: float = 0.08  #: least overlap of a shift, share of the seen pixels
    least_px_per_m: float = 80.0  #: least resolution of a photo: with less, joints are not seen
    least_m: float = 0.5  #: least area of a view, as the side of a square
    single: float = 0.6  #: factor of the score of a period that is seen only once
    periods: float = 3.0  #: periods beyond the first from which on a score counts in full
    of_row: float = 0.12  #: sigma of the blur along a row's end joints, share of the row's width
    same_row: float = 0.12  #: largest shift down within one row, share of the row's width


JOINTS = JointSettings()


#: Distances that are tried, metres, each 1 % more than the one before.
DISTANCES = np.exp(np.arange(np.log(JOINTS.shortest_m), np.log(JOINTS.longest_m), 0.01))


@dataclass(frozen=True, eq=False)
class Upright:
    """An image rotated so that its joints run along x, cropped to what is seen.

    `contrast` (h, w) float32 are normalised log grey values, 0 where not `valid` (h, w) bool;
    `turn` (2, 3) is the affine map from pixels (x, y) of the image to it.
    """

    contrast: np.ndarray
    valid: np.ndarray
    turn: np.ndarray


@dataclass(frozen=True, eq=False)
class Direction:
    """Lines of a view that run in one direction."""

    angle_deg: float  #: from +x of the image towards +y (down), [0, 180)
    view: Upright
    kept: float  #: energy of the contrast that is left when averaged along the lines

    @cached_property
    def lines(self) -> dict[str, np.ndarray]:
        """How clearly lines repeat (n,) at each of `DISTANCES`, 0..2, by kind of line."""
        return across(self.view)

    @cached_property
    def scores(self) -> np.ndarray:
        """The same (n,) for the clearest kind of line at each distance."""
        return np.asarray(np.max(list(self.lines.values()), axis=0))

    def near(self, distance: float, within: float) -> tuple[float, float]:
        """Return the best distance within a log ratio `within` of `distance`, and its score."""
        part = np.abs(np.log(DISTANCES / distance)) <= within
        k = int(np.where(part, self.scores, -1.0).argmax())
        return refined(self.scores, k), float(self.scores[k])


def refined(scores: np.ndarray, k: int) -> float:
    """Return the distance of a peak of scores at index `k`, refined with a parabola."""
    if not 0 < k < len(scores) - 1:
        return float(DISTANCES[k])
    before, peak, after = scores[k - 1 : k + 2]
    bend = before - 2 * peak + after
    shift = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(DISTANCES[k] * np.exp(0.01 * np.clip(shift, -0.5, 0.5)))


def evened(image: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the normalised fine contrast (h, w) float32 of an image, and where it is valid.

    `image` (h, w, 3) uint8 sRGB at `JOINTS.px_per_m`; `mask` (h, w) bool is the floor.
    """
    scale = JOINTS.px_per_m
    luma = log_luma(image / 255.0)
    fine = luma - nearby(luma, mask, JOINTS.slow_m * scale)
    spread = np.sqrt(np.maximum(nearby(fine**2, mask, JOINTS.near_m * scale), 0.0))
    fine = np.clip(fine / np.maximum(spread, 1e-4), -JOINTS.most, JOINTS.most)
    rim = max(1, round(JOINTS.rim_m * scale))
    padded = np.pad(mask.astype(np.uint8), 1)
    valid = cv2.erode(padded, np.ones((2 * rim + 1,) * 2, np.uint8))[1:-1, 1:-1] > 0
    return np.where(valid, fine, 0.0).astype(np.float32), valid


def nearby(values: np.ndarray, mask: np.ndarray, sigma: float) -> np.ndarray:
    """Return the mean (h, w) of the values inside a mask near each pixel."""
    weight = mask.astype(np.float32)
    side = 2 * round(0.86 * sigma) + 1  # two boxes have a Gaussian's spread
    total = (values * weight).astype(np.float32)
    total, weight = (cv2.blur(cv2.blur(a, (side, side)), (side, side)) for a in (total, weight))
    return np.asarray(total / np.maximum(weight, 1e-3))


def directions(contrast: np.ndarray, valid: np.ndarray) -> list[Direction]:
    """Return the two perpendicular directions of a view's lines (:func:`evened`).

    The first is the one along which most contrast is kept. The list is empty if too little is seen.
    """
    if valid.sum() < (JOINTS.least_m * JOINTS.px_per_m) ** 2:
        return []
    angle = direction(contrast, valid)
    found = []
    for turned_by in (angle, (angle + 90.0) % 180.0):
        view = upright(contrast, valid, turned_by)
        found.append(Direction(turned_by, view, _kept(view, JOINTS.px_per_m)))
    return found


def direction(contrast: np.ndarray, valid: np.ndarray) -> float:
    """Return the direction of the lines, degrees in [0, 180)."""
    tried, best = np.arange(0.0, 180.0, JOINTS.step_deg), 0.0
    for part in (3, 2):
        best = float(tried[np.argmax(kept_along(contrast, valid, tried, part=part))])
        tried = best + np.arange(-6, 7) * JOINTS.step_deg / 6
    return best % 180.0


def kept_along(
    contrast: np.ndarray, valid: np.ndarray, angles: np.ndarray, *, part: int = 3
) -> np.ndarray:
    """Return the contrast (n,) that is left when averaged along each of `angles` (n,), degrees.

    The view's sides are first divided by `part`.
    """
    size = (contrast.shape[1] // part or 1, contrast.shape[0] // part or 1)
    small = cv2.resize(contrast, size, interpolation=cv2.INTER_AREA)
    seen = cv2.resize(valid.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    turned = (upright(small, seen, angle) for angle in angles)
    return np.array([_kept(view, JOINTS.px_per_m / part) for view in turned])


def _kept(turned: Upright, px_per_m: float) -> float:
    """Return the mean energy of an image after averaging along x in strips."""
    strip = max(4, round(JOINTS.strip_m * px_per_m))
    height, width = turned.contrast.shape
    count = max(1, width // strip)
    size = (height, count, width // count)
    whole = size[1] * size[2]
    total = turned.contrast[:, :whole].reshape(size).sum(axis=2)
    weight = turned.valid[:, :whole].reshape(size).sum(axis=2)
    enough = weight >= 0.5 * strip
    return float((total[enough] ** 2 / weight[enough]).sum() / max(weight[enough].sum(), 1))


def upright(contrast: np.ndarray, valid: np.ndarray, angle_deg: float) -> Upright:
    """Return an image turned so that lines at `angle_deg` run along x."""
    rows = np.flatnonzero(valid.any(axis=1))
    if not len(rows):
        return Upright(contrast[:1, :1], valid[:1, :1], np.eye(2, 3))
    turn = cv2.getRotationMatrix2D((0.0, 0.0), angle_deg, 1.0)
    first, last = valid[rows].argmax(axis=1), valid[rows, ::-1].argmax(axis=1)
    ends = np.concatenate([first, valid.shape[1] - 1 - last])
    corners = np.stack([ends, np.tile(rows, 2)], axis=1) @ turn[:, :2].T
    low = np.floor(corners.min(axis=0))
    size = np.ceil(corners.max(axis=0) - low).astype(int) + 1
    turn[:, 2] = -low
    shape = (int(size[0]), int(size[1]))
    image = cv2.warpAffine(contrast, turn, shape, flags=cv2.INTER_LINEAR)
    seen = cv2.warpAffine(valid.astype(np.uint8), turn, shape, flags=cv2.INTER_NEAREST) > 0
    return Upright(np.where(seen, image, 0.0).astype(np.float32), seen, turn)


def across(view: Upright) -> dict[str, np.ndarray]:
    """Return how clearly lines along x repeat at each of `DISTANCES`, by kind of line."""
    scale = JOINTS.px_per_m
    band = round(JOINTS.band_m * scale)
    found = {}
    counts = Overlap(view.valid)
    for line, strength in lines(view, JOINTS.along_m * scale, down=True):
        found[line] = repeats(counts.alike(strength).down(band), counts.reach[0])
    return found


def along(view: Upright, row_m: float) -> dict[str, np.ndarray]:
    """Return how clearly lines along y repeat within rows of `row_m`, by kind of line."""
    row = row_m * JOINTS.px_per_m
    counts = Overlap(view.valid)
    found = {}
    for line, strength in lines(view, max(1.5, JOINTS.of_row * row), down=False):
        alike = counts.alike(strength).right(0.0, JOINTS.same_row * row)
        found[line] = repeats(alike, counts.reach[1])
    return found


def run_on(view: Upright, row_m: float, line: str) -> np.ndarray:
    """Return the likeness (100,) of neighbouring joints along x, shifted along by 0, 1 ... cm.

    The likeness half a row before and after is subtracted; NaN where too little is seen. Joints of
    rows continue without a break, those of a herringbone end and start again.
    """
    row = row_m * JOINTS.px_per_m
    strength = dict(lines(view, JOINTS.along_m * JOINTS.px_per_m, down=True))[line]
    shifts = Overlap(view.valid).alike(strength)
    there = shifts.right(row, JOINTS.same_row * row, best=True)
    beside = 0.5 * sum(shifts.right(part * row, 0.0) for part in (0.5, 1.5))
    found = (there - beside)[:: round(JOINTS.px_per_m / 100)][:100]
    return np.pad(found, (0, 100 - len(found)), constant_values=np.nan)


def moved(view: Upright, step_m: float) -> float:
    """Return how alike a floor is to itself, moved by a step down and to a side; at most 1."""
    smooth = cv2.GaussianBlur(view.contrast, (0, 0), JOINTS.loose_px)
    alike = Overlap(view.valid).alike(smooth).alike
    step = round(step_m * JOINTS.px_per_m / 2)
    near = np.arange(step - 1, step + 2)
    ways = [alike[np.ix_(near, way * near)] for way in (1, -1)]
    return float(np.nan_to_num(ways, nan=0.0).max())


def next_row(view: Upright, row_m: float, length_m: float, line: str) -> float:
    """Return the shift of the next row's end joints, as a share (0..1) of the length."""
    row, length = row_m * JOINTS.px_per_m, length_m * JOINTS.px_per_m
    strength = dict(lines(view, max(1.5, JOINTS.of_row * row), down=False))[line]
    profile = Overlap(view.valid).alike(strength).right(row, JOINTS.same_row * row)
    shifts = np.arange(len(profile))
    near = np.isfinite(profile) & (shifts <= 1.5 * length)
    bins = np.round((shifts[near] % length) / length * 24).astype(int) % 24
    total = np.bincount(bins, profile[near], 24) / np.maximum(np.bincount(bins, minlength=24), 1)
    return float(total.argmax() / 24)


def lines(view: Upright, along: float, *, down: bool) -> Iterator[tuple[str, np.ndarray]]:
    """Yield how much each pixel (h, w) lies on a line: ``dark``, ``light`` or a ``step``.

    Lines run along x if `down` (they repeat down the image), else along y; `along` is the sigma in
    pixels of the blur along the lines.
    """
    image = view.contrast if down else view.contrast.T
    smooth = cv2.GaussianBlur(image, (0, 0), sigmaX=along, sigmaY=JOINTS.line_px)
    ridge = cv2.Sobel(smooth, cv2.CV_32F, 0, 2, ksize=3)
    step = np.abs(cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=3))
    for name, values in (
        ("dark", np.maximum(ridge, 0.0)),
        ("light", np.maximum(-ridge, 0.0)),
        ("step", step),
    ):
        loose = cv2.GaussianBlur(values, (0, 0), JOINTS.loose_px)
        yield name, loose if down else loose.T


class Overlap:
    """Autocorrelation of a view's seen pixels; their overlap at each shift is computed only once.

    Images are first reduced to half their sides: lines are blurred by more than that.
    """

    def __init__(self, valid: np.ndarray) -> None:
        self._weight = _halved(valid.astype(np.float32))
        height, width = self._weight.shape
        self._shape = (fft.next_fast_len(2 * height, real=True), fft.next_fast_len(2 * width))
        self._count = self._correlated(self._weight)
        rows, columns = np.nonzero(valid)
        #: Sides of what is seen, pixels, down and right.
        self.reach = (float(np.ptp(rows)), float(np.ptp(columns))) if len(rows) else (0.0, 0.0)

    def alike(self, values: np.ndarray) -> Shifts:
        """Return the autocorrelation of values (h, w), NaN at shifts with too little overlap."""
        weight, count = self._weight, self._count
        small = _halved(values)
        mean = float((small * weight).sum() / max(float(weight.sum()), 1.0))
        total = self._correlated((small - mean) * weight)
        enough = count >= JOINTS.least_overlap * weight.sum()
        alike = np.where(enough, total / np.maximum(count, 1.0), np.nan)
        return Shifts(alike / max(float(alike[0, 0]), 1e-12), self._weight.shape)

    def _correlated(self, values: np.ndarray) -> np.ndarray:
        """Return the sum of the products of values and shifted values, for all shifts."""
        spectrum = np.abs(fft.rfft2(values, self._shape)) ** 2
        return np.asarray(fft.irfft2(spectrum, self._shape))


def _halved(values: np.ndarray) -> np.ndarray:
    """Return an image of half the sides."""
    size = (max(1, values.shape[1] // 2), max(1, values.shape[0] // 2))
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))


@dataclass(frozen=True, eq=False)
class Shifts:
    """How alike an image is to itself when shifted, 1 at no shift.

    `alike` has steps of two pixels, down and right; negative shifts are at the end. It is NaN where
    the overlap is too small. `size` is that of the halved image.
    """

    alike: np.ndarray
    size: tuple[int, ...]

    def down(self, band: int) -> np.ndarray:
        """Return the likeness at shifts down of 0, 1 ... px, averaged over `band` px sideways."""
        sideways = np.arange(-(band // 2), band // 2 + 1)
        return _each_pixel(_mean(self.alike[: self.size[0]][:, sideways], 1))

    def right(self, down: float, loose: float, *, best: bool = False) -> np.ndarray:
        """Return the same for shifts to the right, with shifts down within `loose` px of `down`.

        It is the mean over the shifts down or, if `best`, their best, averaged over right and left.
        """
        rows = np.arange(round((down - loose) / 2), round((down + loose) / 2) + 1)
        part = self.alike[rows]
        if not best:
            return _each_pixel(_mean(part[:, : self.size[1]], 0))
        ways = (part[:, : self.size[1]], part[:, -np.arange(self.size[1])])
        return _each_pixel(np.mean([way.max(axis=0) for way in ways], axis=0))


def _each_pixel(values: np.ndarray) -> np.ndarray:
    """Interpolate values at every second pixel to every pixel."""
    return np.interp(np.arange(2 * len(values) - 1) / 2, np.arange(len(values)), values)


def _mean(values: np.ndarray, axis: int) -> np.ndarray:
    """Return the mean of the finite values along an axis; NaN where there are none."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=axis)
    count = known.sum(axis=axis)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def repeats(profile: np.ndarray, reach: float) -> np.ndarray:
    """Return how clearly a likeness over shifts 0, 1 ... px repeats at each of `DISTANCES`, 0..2.

    At a period and at twice the period the likeness is high, at 0.5 and 1.5 periods it is low. The
    score is smaller if few periods fit into `reach` px.
    """
    unknown = np.nonzero(~np.isfinite(profile))[0]
    last = float(unknown[0] - 1 if len(unknown) else len(profile) - 1)
    at = np.arange(len(profile))
    safe = np.where(np.isfinite(profile), profile, 0.0)

    def value(times: float) -> np.ndarray:
        return np.interp(times * tried, at, safe)

    tried = DISTANCES * JOINTS.px_per_m
    once = value(1.0) - value(0.5)
    twice = np.minimum(value(2.0) - value(1.5), once)
    scores = np.where(2 * tried <= last, 0.5 * (once + twice), JOINTS.single * once)
    scores *= np.clip((reach / tried - 1.0) / JOINTS.periods, 0.0, 1.0)
    return np.where(tried <= min(last, JOINTS.of_extent * reach), np.maximum(scores, 0.0), 0.0)
