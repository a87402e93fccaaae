"""Cut whole planks and tiles out of the photos, and measure the joints between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np

from plan2scene.images import window_counts
from plan2scene.photos.patterns.bonds import Zigzag
from plan2scene.photos.patterns.find import FoundPattern, Reading
from plan2scene.photos.patterns.joints import JOINTS, lines, nearby
from plan2scene.photos.patterns.views import FloorView
from plan2scene.photos.patterns.zigzag import fitted


@dataclass(frozen=True)
class UnitSettings:
    """Constants chosen by looking at units of development homes; what is "usual" is a median."""

    most: int = 60  #: largest number of units of a pattern; the most usual ones are kept
    light_m: float = 0.4  #: sigma of the local mean of a view, which is taken as light
    even_m: float = 0.15  #: sigma of the same within a unit
    tone: float = 2.5  #: limit of the deviation of a unit's tone, times the usual deviation
    odd: float = 1.35  #: limit of a unit's strongest mark, times the usual one: more is an object
    hue_m: float = 0.02  #: sigma of the blur of hue
    hue: float = 0.4  #: share of hue's variation that is kept, within a unit and between units
    crossed: float = 2.5  #: limit of the stripes across a unit, times the usual ones
    stripe_m: float = 0.01  #: sigma of the blur of these stripes
    blot_m: float = 0.02  #: sigma of the blur that leaves blots, such as edges of shadows
    blot: float = 1.6  #: limit of the contrast of blots, times the usual one
    strip_m: float = 0.4  #: length over which a row's borders are taken as straight
    loose: float = 0.12  #: tolerance of a joint's place, share of the distance between joints
    inset_m: float = 0.006  #: margin cut off at a unit's border, for the joint
    longest_m: float = 2.0  #: longest piece that is cut where planks have no known length
    shortest_m: float = 0.45  #: shortest such piece
    burnt: int = 250  #: sRGB level from which on a pixel shows a reflection
    most_gain: float = 1.6  #: largest ratio between the light in a unit and the view's usual light
    sharp: float = 0.55  #: least fine contrast of a unit, share of the units' 80th percentile
    slanting_views: int = 6  #: largest number of views that slanting planks are cut out of
    whole: float = 0.97  #: least share of a slanting plank's area that is seen
    joint_px: int = 4  #: tone is measured up to this distance on both sides of a joint
    depth: float = 0.5  #: assumed difference of a joint from its units, which gives its width
    shown_m: float = 2.4  #: side of the part of a view that is shown to a person
    shown_px_per_m: float = 150.0  #: resolution of that part


UNITS = UnitSettings()
_DRAWN = (255, 0, 160)


@dataclass(frozen=True, eq=False)
class Units:
    """The units and joints that a pattern is laid of."""

    #: list of (h, w, 3) uint8: units at `JOINTS.px_per_m`, length along x, without joints: sRGB
    #: levels divided by the floor's usual ones, times 0.5
    images: list[np.ndarray]
    #: (3,) float: relative difference of sRGB, (units - joint) / units; negative for light joints
    joint: np.ndarray
    joint_m: float  #: width of a joint with this difference
    #: (h, w, 3) uint8: sRGB of a view at `UNITS.shown_px_per_m`, rows along x, with the joints that
    #: were found drawn over it
    shown: np.ndarray


def unlaid(view: FloorView) -> Units:
    """Return the result for a view without a pattern: no units, and a picture of the view."""
    return Units([], np.zeros(3), 0.0, _window(view.image, view.mask))


def cut_units(pattern: FoundPattern, readings: Sequence[Reading]) -> Units:
    """Return the units of a pattern that are seen whole in its views, and their joints."""
    cut, profiles, shown = [], [], None
    views = UNITS.slanting_views if pattern.slant_deg else len(readings)
    for reading in sorted(readings, key=lambda r: -r.weight)[:views]:
        if abs(np.log(reading.width_m / pattern.width_m)) <= 2 * UNITS.loose:
            rows = (_Columns if pattern.slant_deg else _Rows)(pattern, reading)
            shown = rows.drawn() if shown is None else shown
            profiles += rows.profiles()
            cut += list(rows.units())
    joint, joint_m = _joint(profiles)
    if not np.isfinite(pattern.length_m):
        joint = np.maximum(joint, 0.0)  # boards have no grout: a light joint is a reflection
    seen = unlaid(readings[0].view).shown if shown is None else shown
    return Units(_alike(cut), joint, joint_m, seen)


def _window(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return the square part of a view (h, w, 3) with most of its mask (h, w), resized."""
    side = round(UNITS.shown_m * JOINTS.px_per_m)
    height, width = min(side, mask.shape[0]), min(side, mask.shape[1])
    counts = window_counts(mask, height, width)
    top, left = np.unravel_index(int(counts.argmax()), counts.shape)
    part = image[top : top + height, left : left + width]
    scale = UNITS.shown_px_per_m / JOINTS.px_per_m
    return cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def _alike(cut: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return the most usual units (h, w, 3), sharp and showing only floor, evened, as uint8."""
    if not cut:
        return []
    sigma = UNITS.even_m * JOINTS.px_per_m
    slow = [cv2.GaussianBlur(image, (0, 0), sigma) for image in cut]
    flat = [image / np.maximum(light, 0.02) for image, light in zip(cut, slow, strict=True)]
    flat = [_calm(image) for image in flat]
    tones = np.log([np.maximum(np.median(image, axis=(0, 1)), 1e-3) for image in cut])
    away = tones - np.median(tones, axis=0)
    usual_deviation = 1.5 * np.median(np.abs(away))
    tones = np.clip(away, -UNITS.tone * usual_deviation, UNITS.tone * usual_deviation)
    shade = tones.mean(axis=1, keepdims=True)
    tones = shade + UNITS.hue * (tones - shade)  # different hues of units come mostly from light
    grey = [image.mean(axis=2) for image in flat]
    fine = np.array([np.abs(cv2.Laplacian(g, cv2.CV_32F)).mean() for g in grey])
    dark = [np.log(np.maximum(g, 0.02)) for g in grey]
    blots = np.array(
        [cv2.GaussianBlur(g, (0, 0), UNITS.blot_m * JOINTS.px_per_m).std() for g in dark]
    )
    marks = np.array([np.percentile(np.abs(g), 99.5) for g in dark])
    good = (fine >= UNITS.sharp * np.percentile(fine, 80)) & (marks <= UNITS.odd * np.median(marks))
    crossed = [_stripes(g) for g in dark]
    good &= np.array(crossed) <= UNITS.crossed * np.median(crossed)
    good &= blots <= UNITS.blot * np.median(blots)
    good &= (np.abs(away) <= 2 * UNITS.tone * max(usual_deviation, 1e-6)).all(axis=1)
    unusual = np.abs(np.log(blots / np.median(blots)))
    chosen = sorted(sorted(np.flatnonzero(good), key=lambda k: unusual[k])[: UNITS.most])
    flat = _own(flat)
    evened_units = (0.5 * flat[k] * np.exp(tones[k]) for k in chosen)
    return [np.clip(np.rint(255 * image), 0, 255).astype(np.uint8) for image in evened_units]


def _own(units: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Divide units (h, w, 3) by the shading that all share, which comes from nearby joints."""
    ways = [1] if len({unit.shape for unit in units}) > 1 else [1, 0]
    for axis in ways:
        lines = [unit.mean(axis=axis, keepdims=True) for unit in units]
        shared = np.mean([line / line.mean(axis=(0, 1)) for line in lines], axis=0)
        units = [unit / shared for unit in units]
    return list(units)


def _stripes(dark: np.ndarray) -> float:
    """Return the strength of stripes across a unit, from the log grey values (h, w)."""
    line = cv2.GaussianBlur(dark.mean(axis=0)[None], (0, 0), UNITS.stripe_m * JOINTS.px_per_m)
    return float(np.abs(np.diff(line[0], 2)).mean())


def _calm(image: np.ndarray) -> np.ndarray:
    """Reduce the stains of hue in a unit (h, w, 3), which come from coloured light and noise."""
    grey = np.maximum(image.mean(axis=2, keepdims=True), 0.02)
    hue = np.maximum(image / grey, 0.02)
    smooth = cv2.GaussianBlur(hue, (0, 0), UNITS.hue_m * JOINTS.px_per_m)
    usual = np.median(hue, axis=(0, 1))
    return np.asarray(grey * usual * (smooth / usual) ** UNITS.hue)


def _joint(profiles: Sequence[np.ndarray]) -> tuple[np.ndarray, float]:
    """Return `Units.joint` (3,) and `Units.joint_m` from colours across joints."""
    if not profiles:
        return np.zeros(3), 0.0
    median_profile = np.median(profiles, axis=0)
    beside = 0.5 * (median_profile[0] + median_profile[-1])
    total = (1.0 - median_profile / np.maximum(beside, 1e-3)).sum(axis=0) / JOINTS.px_per_m
    width = float(np.abs(total.mean())) / UNITS.depth
    return total / max(width, 1e-6), width


class _Turned:
    """A view rotated so that a pattern's rows or columns run along x, with even light."""

    def __init__(self, pattern: FoundPattern, reading: Reading) -> None:
        view, whole = reading.direction.view, reading.view
        self._pattern = pattern
        size = view.valid.shape[::-1]
        self._valid = view.valid
        colour = cv2.warpAffine(whole.image, view.turn, size, flags=cv2.INTER_LINEAR)
        self._colour = colour
        self._burnt = colour.max(axis=2) >= UNITS.burnt
        self._even, self._gain = _evenly_lit(colour / 255.0, view.valid)


class _Columns(_Turned):
    """The planks of a herringbone or chevron in one view."""

    def __init__(self, pattern: FoundPattern, reading: Reading) -> None:
        super().__init__(pattern, reading)
        ratio = pattern.length_m / pattern.width_m
        sizes = reading.width_m, ratio * reading.width_m, pattern.slant_deg
        fit, places = fitted(Zigzag(pattern.kind, *sizes), reading.direction.view)
        parts = fit.planks(places[..., 0], places[..., 1])
        self._fit, (self._number, self._x, self._y, self._border) = fit, parts

    def units(self) -> Iterator[np.ndarray]:
        """Yield the planks that are seen whole, with even light."""
        scale, fit = JOINTS.px_per_m, self._fit
        good = self._valid & ~self._burnt
        good &= (self._gain < UNITS.most_gain) & (self._gain > 1 / UNITS.most_gain)
        rows, columns = np.nonzero(good)
        numbers = self._number[rows, columns]
        _, which, count = np.unique(numbers, axis=0, return_inverse=True, return_counts=True)
        order = np.argsort(which.ravel(), kind="stable")
        whole = UNITS.whole * fit.width_m * fit.length_m * scale**2
        sides = [round(side * scale) for side in (self._pattern.length_m, self._pattern.width_m)]
        inset = UNITS.inset_m
        for part in np.split(order, np.cumsum(count)[:-1]):
            if len(part) < whole:
                continue
            y, x = rows[part], columns[part]
            # An affine map takes places in the plank to pixels of the view.
            places = np.column_stack([self._x[y, x], self._y[y, x], np.ones(len(part))])
            to_view = np.linalg.lstsq(places, np.column_stack([x, y]), rcond=None)[0].T
            size = np.array([fit.length_m, fit.width_m]) - 2 * inset
            pixels = np.array(
                [[size[0] / sides[0], 0, -size[0] / 2], [0, size[1] / sides[1], -size[1] / 2]]
            )
            turn = to_view @ np.vstack([pixels, [0.0, 0.0, 1.0]])
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            yield cv2.warpAffine(self._even, turn, (sides[0], sides[1]), flags=flags)

    def drawn(self) -> np.ndarray:
        """Return the picture of the view for a person, with the found joints drawn over it."""
        image = self._colour.copy()
        image[self._valid & (self._border < 1.0 / JOINTS.px_per_m)] = _DRAWN
        return _window(image, self._valid)

    def profiles(self) -> list[np.ndarray]:
        """Return the mean colours (2 n + 1, 3) across joints as a list, n = `UNITS.joint_px`."""
        away = (self._fit.width_m / 2 - np.abs(self._y)) * JOINTS.px_per_m
        long = self._valid & (np.abs(self._x) < 0.4 * self._fit.length_m)
        found = [
            self._even[long & (np.floor(away) == k)].mean(axis=0) for k in range(UNITS.joint_px + 1)
        ]
        return [np.array([*found[:0:-1], *found])]


class _Rows(_Turned):
    """The rows of units in one view, straightened."""

    def __init__(self, pattern: FoundPattern, reading: Reading) -> None:
        super().__init__(pattern, reading)
        view = reading.direction.view
        self._width = reading.width_m * JOINTS.px_per_m
        self._scale = pattern.width_m / reading.width_m
        along = JOINTS.along_m * JOINTS.px_per_m
        self._across = dict(lines(view, along, down=True))[pattern.line]
        ends = dict(lines(view, max(1.5, JOINTS.of_row * self._width), down=False))
        self._ends = (
            np.max([ends["dark"], ends["light"]], axis=0)
            if pattern.line == "step"
            else (ends[pattern.line])
        )

    def tracks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield each row: the middles of its strips (n,) and its borders there (n, 2), pixels."""
        strip = round(UNITS.strip_m * JOINTS.px_per_m)
        width = self._valid.shape[1]
        going: list[tuple[list[float], list[np.ndarray]]] = []
        for left in range(0, max(width - strip // 2, 1), strip):
            part = slice(left, min(left + strip, width))
            borders = self._borders(part)
            middle = 0.5 * (part.start + part.stop)
            fresh = []
            for pair in borders:
                match = next(
                    (t for t in going if np.abs(t[1][-1] - pair).max() < 0.25 * self._width), None
                )
                if match is not None and match[0][-1] >= middle - 1.5 * strip:
                    match[0].append(middle)
                    match[1].append(pair)
                    going.remove(match)
                    fresh.append(match)
                else:
                    fresh.append(([middle], [pair]))
            yield from ((np.array(t[0]), np.array(t[1])) for t in going)
            going = fresh
        yield from ((np.array(t[0]), np.array(t[1])) for t in going)

    def _borders(self, part: slice) -> list[np.ndarray]:
        """Return the upper and lower border (2,) of each row within some columns of the view."""
        seen = self._valid[:, part]
        count = seen.sum(axis=1)
        enough = count >= 0.3 * seen.shape[1]
        if enough.sum() < 1.5 * self._width:
            return []
        line = np.where(
            enough, (self._across[:, part] * seen).sum(axis=1) / np.maximum(count, 1), 0.0
        )
        places = comb(line, self._width)
        inside = [y for y in places if 0 <= y < len(enough) and enough[int(y)]]
        pairs = pairwise(inside)
        return [np.array(p) for p in pairs if abs((p[1] - p[0]) / self._width - 1) < 0.2]

    def units(self) -> Iterator[np.ndarray]:
        """Yield the units that are seen whole, with even light."""
        for middles, borders in self.tracks():
            row = self._straight(middles, borders)
            if row is None:
                continue
            image, good, ends = row
            for left, right in self._pieces(good, ends):
                inset = round(UNITS.inset_m * JOINTS.px_per_m)
                piece = image[inset : image.shape[0] - inset, left + inset : right - inset]
                length = self._pattern.length_m * JOINTS.px_per_m
                wide = round(length) if np.isfinite(length) else right - left
                yield cv2.resize(piece, (wide, image.shape[0]), interpolation=cv2.INTER_CUBIC)

    def drawn(self) -> np.ndarray:
        """Return the picture of the view for a person, with the found joints drawn over it."""
        image = self._colour.copy()
        for middles, borders in self.tracks():
            for k in (0, 1):
                line = np.rint(np.stack([middles, borders[:, k]], axis=1)).astype(np.int32)
                cv2.polylines(image, [line], False, _DRAWN, 2, cv2.LINE_AA)
            row = self._straight(middles, borders)
            if row is None or not np.isfinite(self._pattern.length_m):
                continue
            strip = round(UNITS.strip_m * JOINTS.px_per_m)
            for left, _ in self._pieces(row[1], row[2], whole=False):
                x = middles[0] - strip / 2 + left / self._scale
                ends = [round(float(np.interp(x, middles, borders[:, k]))) for k in (0, 1)]
                cv2.line(image, (round(x), ends[0]), (round(x), ends[1]), _DRAWN, 2, cv2.LINE_AA)
        return _window(image, self._valid)

    def _straight(
        self, middles: np.ndarray, borders: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Return a row's image, its good columns, and the strength of end joints along it."""
        strip = round(UNITS.strip_m * JOINTS.px_per_m)
        low, high = middles[0] - strip / 2, middles[-1] + strip / 2
        columns = round((high - low) * self._scale)
        rows = max(4, round(self._pattern.width_m * JOINTS.px_per_m))
        x = low + (np.arange(columns) + 0.5) / self._scale - 0.5
        top, bottom = (np.interp(x, middles, borders[:, k]) for k in (0, 1))
        share = (np.arange(rows) + 0.5) / rows
        y = (top + share[:, None] * (bottom - top)).astype(np.float32)
        across = np.broadcast_to(x, y.shape).astype(np.float32)

        def taken(values: np.ndarray) -> np.ndarray:
            return cv2.remap(values.astype(np.float32), across, y, cv2.INTER_LINEAR)

        good = taken(self._valid & ~self._burnt).min(axis=0) > 0.9
        gain = taken(self._gain).mean(axis=0)
        good &= (gain < UNITS.most_gain) & (gain > 1 / UNITS.most_gain)
        if good.sum() < UNITS.shortest_m * JOINTS.px_per_m * 0.5:
            return None
        return taken(self._even), good, taken(self._ends)[rows // 8 : rows - rows // 8].mean(axis=0)

    def _pieces(
        self, good: np.ndarray, ends: np.ndarray, *, whole: bool = True
    ) -> Iterator[tuple[int, int]]:
        """Yield the first and last column of a row's units: all, or only those seen `whole`."""
        length = self._pattern.length_m * JOINTS.px_per_m
        if np.isfinite(length):
            places = [round(x) for x in comb(np.where(good, ends, 0.0), length)]
            pairs = list(pairwise(places))
        else:
            edges = np.flatnonzero(np.diff(np.r_[0, good.astype(int), 0]))
            most = round(UNITS.longest_m * JOINTS.px_per_m)
            pairs = [
                (left, min(left + most, right))
                for first, right in edges.reshape(-1, 2)
                for left in range(first, right, most)
            ]
        shortest = UNITS.shortest_m * JOINTS.px_per_m
        for left, right in pairs:
            inside = 0 <= left < right <= len(good)
            clear = _whole(ends, left, right) if np.isfinite(length) else right - left >= shortest
            if not whole or (inside and clear and good[left:right].all()):
                yield left, right

    def profiles(self) -> list[np.ndarray]:
        """Return the colours (2 n + 1, 3) across each joint between rows, n = `UNITS.joint_px`."""
        found = []
        reach = np.arange(-UNITS.joint_px, UNITS.joint_px + 1)
        for middles, borders in self.tracks():
            for x, (top, _) in zip(middles, borders, strict=True):
                rows = round(top) + reach
                part = slice(max(int(x) - 20, 0), int(x) + 20)
                if rows[0] < 0 or rows[-1] >= len(self._valid) or not self._valid[rows, part].all():
                    continue
                found.append(self._even[rows, part].mean(axis=1))
        return found


def _whole(ends: np.ndarray, left: int, right: int) -> bool:
    """Return whether the joints at a unit's ends are stronger than anything between them."""
    rim = max(1, round(UNITS.loose * (right - left)))
    inner = ends[left + rim : right - rim]
    at_ends = [ends[max(x - 2, 0) : x + 3] for x in (left, right)]
    return all(part.size for part in at_ends) and bool(
        inner.max(initial=0.0) < min(part.max() for part in at_ends)
    )


def comb(line: np.ndarray, step: float) -> list[float]:
    """Return the places of joints about `step` px apart, from the strength along a line (n,)."""
    starts = np.arange(0.0, step, 0.5)
    at = np.arange(len(line))
    counts = np.arange(int(len(line) / step) + 1)
    sums = [float(np.interp(s + counts * step, at, line, right=0.0).sum()) for s in starts]
    first = starts[int(np.argmax(sums))]
    places = []
    for place in first + counts * step:
        low, high = (round(place + way * UNITS.loose * step) for way in (-1, 1))
        part = line[max(low, 0) : high + 1]
        if place > len(line) - 1 or not len(part):
            continue
        places.append(float(max(low, 0) + int(part.argmax())) if part.max() > 0 else float(place))
    return places


def _evenly_lit(image: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return an evenly lit image (h, w, 3) around 0.5, and the light (h, w) over its median."""
    sigma = UNITS.light_m * JOINTS.px_per_m
    light = np.dstack([nearby(channel, valid, sigma) for channel in cv2.split(image)])
    usual = np.median(light[valid], axis=0)
    even = 0.5 * image / np.maximum(light, 1 / 255)
    return even.astype(np.float32), light.mean(axis=2) / usual.mean()
