"""Herringbone and chevron: planks in columns that slant to one side and the other.

Both repeat along their columns and across them, and planks of one slant have only those of the
other beside them. Chevron has a straight joint along its columns, herringbone none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from scipy.ndimage import maximum_filter1d

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
    """Constants chosen on procedural herringbone, chevron, basket, planks and tiles."""

    width_m: tuple[float, float] = (0.04, 0.2)  #: of planks that are tried
    ratio: tuple[float, float] = (2.5, 9.0)  #: of length to width
    least_deg: float = 50.0  #: between the slants of two columns
    spine: float = 0.55  #: score of joints along columns, from which on it is a chevron
    fit: float = 0.02  #: by which a view's angle (radians), width and length are tried beside


ZIGZAG = ZigzagSettings()
_STEP = 0.02  #: log ratio of the widths and of the ratios that are tried
_WIDTHS = np.exp(np.arange(np.log(ZIGZAG.width_m[0]), np.log(ZIGZAG.width_m[1]), _STEP))
_RATIOS = np.exp(np.arange(np.log(ZIGZAG.ratio[0]), np.log(ZIGZAG.ratio[1]), _STEP))


@dataclass(frozen=True, eq=False)
class Slants:
    """What a view shows of planks in columns of one direction."""

    view: FloorView
    columns_deg: float  #: from +x of the image towards +y (down), [0, 180)
    slant_deg: float  #: between planks and columns
    #: (n, m) float: How clearly planks repeat of each of `_WIDTHS` and `_RATIOS` of length to
    #: width, 0..1
    scores: np.ndarray

    @property
    def columns(self) -> Upright:
        """The view turned so that columns run along x."""
        return upright(*evened(self.view.image, self.view.mask), self.columns_deg)


def find_zigzag(
    views: Sequence[FloorView], weights: np.ndarray, same_size: float
) -> tuple[Zigzag, float, list[tuple[Slants, float, float]]]:
    """Return how planks lie in columns, if they do, and how clearly (0..1).

    And what each view says: direction, the width there (metres), and its score. Scales of views,
    which count by `weights` (n,), differ by a log ratio of `same_size`.
    """
    options = [slants(view) for view in views]
    reach = 2 * round(same_size / _STEP) + 1
    best = np.array([np.max([o.scores for o in mine], axis=0) for mine in options])
    wide = maximum_filter1d(maximum_filter1d(best, reach, axis=1), 3, axis=2)
    pooled = np.tensordot(weights, np.clip(wide, 0.0, None), 1) / weights.sum()
    k, j = np.unravel_index(int(pooled.argmax()), pooled.shape)
    rows = slice(max(k - reach // 2, 0), k + reach // 2 + 1)
    columns = slice(max(j - 1, 0), j + 2)
    read = []
    for mine in options:
        one = max(mine, key=lambda option: option.scores[rows, columns].max())
        line = one.scores[rows, columns].max(axis=1)
        read.append((one, float(_WIDTHS[rows][line.argmax()]), float(line.max())))
    clearest = int(
        np.argmax([score * weight for (_, _, score), weight in zip(read, weights, strict=True)])
    )
    slant = round(read[clearest][0].slant_deg, 1)
    shown = [(item, w) for item, w in zip(read, weights, strict=True) if item[2] > 0.0]
    spine = 0.0
    for (one, width, score), weight in shown:
        at = width * _RATIOS[j] * np.sin(np.radians(one.slant_deg))
        near = np.abs(np.log(DISTANCES / at)) <= 0.05
        joints = across(one.columns)
        along = max((float(joints[name][near].max()) for name in ("dark", "light")), default=0.0)
        spine += score * weight * along
    spine /= max(sum(item[2] * weight for item, weight in shown), 1e-9)
    chevron = spine >= ZIGZAG.spine or abs(slant - 45.0) > 2.0
    found = Zigzag(
        "chevron" if chevron else "herringbone",
        float(_WIDTHS[k]),
        float(_WIDTHS[k] * _RATIOS[j]),
        slant if chevron else 45.0,
    )
    return found, float(pooled[k, j]), [item for item, _ in shown]


@lru_cache(maxsize=64)  # a view is read with its material and with its room
def slants(view: FloorView) -> tuple[Slants, ...]:
    """Return what a view shows of planks in columns, for all directions that columns may have."""
    found = []
    contrast, valid = evened(view.image, view.mask)
    first = view.directions[0].angle_deg
    tried = np.arange(first + ZIGZAG.least_deg, first + 181.0 - ZIGZAG.least_deg, JOINTS.step_deg)
    kept = kept_along(contrast, valid, tried)
    peaks = [k for k in range(1, len(tried) - 1) if kept[k] == max(kept[k - 1 : k + 2])]
    turns = {90.0, *(float(tried[k] - first) for k in sorted(peaks, key=lambda k: -kept[k])[:1])}
    families: dict[float, list[np.ndarray]] = {}
    for angle in {0.0, *turns}:
        turned = upright(contrast, valid, first + angle)
        counts = Overlap(turned.valid)
        along = JOINTS.along_m * JOINTS.px_per_m
        families[angle] = [
            cv2.dilate(np.nan_to_num(counts.alike(line).alike, nan=-1.0), np.ones((3, 3)))
            for _, line in lines(turned, along, down=True)
        ]
    for turn in sorted(turns):
        for columns in (turn / 2, turn / 2 + 90.0):
            slant = min(columns % 180.0, 180.0 - columns % 180.0)
            scores = [
                np.minimum(*(_repeats(alike, columns - own, slant) for own, alike in pair))
                for pair in (
                    ((0.0, a), (turn, b))
                    for a, b in zip(families[0.0], families[turn], strict=True)
                )
            ]
            best = np.max(scores, axis=0)
            found.append(Slants(view, (first + columns) % 180.0, slant, best))
    return tuple(found)


def _repeats(alike: np.ndarray, columns_deg: float, slant_deg: float) -> np.ndarray:
    """Return how clearly lines along x (n, m) repeat as those of planks of one slant do.

    `alike` (h, w) at shifts of two pixels, wrapped around; columns at an angle to the lines.
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
        # As far along planks the other way, where those of a basket are as well.
        mean(0.0, 0.0, range(1, 5), mirrored=True),
    ]
    return np.asarray(np.min(same, axis=0) - np.max(other, axis=0))


def fitted(zigzag: Zigzag, view: Upright) -> tuple[Zigzag, np.ndarray]:
    """Return a pattern with the sizes of a view that is turned to its columns, and where it lies.

    Which is (h, w, 2) metres along the columns and across them of each pixel, as
    :meth:`Zigzag.planks` takes them.
    """
    scale = JOINTS.px_per_m
    rows, columns = (at[::4] for at in np.nonzero(view.valid))
    value = cv2.GaussianBlur(view.contrast, (0, 0), 1.0)[rows, columns]
    middle = np.array([columns.mean(), rows.mean()])
    places = (np.stack([columns, rows], axis=1) - middle) / scale
    beside = np.linspace(-ZIGZAG.fit, ZIGZAG.fit, 9)
    best: tuple[float, Any] = (-1.0, None)

    def tried(turn: float, wide: float, long: float) -> None:
        nonlocal best
        sized = replace(zigzag, width_m=zigzag.width_m * wide, length_m=zigzag.length_m * long)
        worth, shift = _shifted(sized, _turned(places, turn), value)
        if worth > best[0]:
            best = worth, (turn, wide, sized, shift)

    for turn in beside:
        for wide in beside:
            tried(turn, 1.0 + wide, 1.0)
    turn, wide = best[1][:2]
    for long in 2 * beside:
        tried(turn, wide, 1.0 + long)
    turn, _, sized, shift = best[1]
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in view.valid.shape[::-1])), axis=-1)
    return sized, _turned((grid - middle) / scale, turn) + shift


def _turned(places: np.ndarray, angle: float) -> np.ndarray:
    """Return places (..., 2) turned back by an angle, radians."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(places @ np.array([[cosine, -sine], [sine, cosine]]))


def _shifted(zigzag: Zigzag, places: np.ndarray, value: np.ndarray) -> tuple[float, np.ndarray]:
    """Return how well joints fit contrast (n,) at places (n, 2), and their shift (2,)."""
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
