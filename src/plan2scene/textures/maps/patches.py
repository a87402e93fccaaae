"""Patches that a surface map is quilted from, in step with the pattern's lattice."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from plan2scene.paint.shading import log_luma
from plan2scene.textures.maps.detail import Detail
from plan2scene.textures.quilting import Cell, Patches, Source

#: Metres between patches and by which they overlap, where the crops are large enough.
STEP_M, OVERLAP_M = 0.3, 0.1
#: Most patches to choose from: their costs are worked out for each pair.
MOST = 500
#: Share of a source's side that a patch without a lattice takes at most.
_SHARE = 0.85
_LEAST_PX = 12  # side of a patch
_PHASES = 48  # bins of a period


def cell(px_per_m: float, period: float, side: float) -> Cell:
    """Return how patches lie along an axis of sources that are `side` px long.

    With a `period` (px; NaN without) whole periods lie between them.
    """
    overlap = OVERLAP_M * px_per_m
    step = STEP_M * px_per_m
    if math.isfinite(period):
        step = max(1, round(step / period)) * period
        overlap = min(overlap, 0.5 * step)
    else:
        scale = min(1.0, _SHARE * side / (step + overlap))
        scale = max(scale, _LEAST_PX / (step + overlap))
        step, overlap = step * scale, overlap * scale
    return Cell(step, max(3, round(overlap)), period)


def cut_patches(detail: Detail, rng: np.random.Generator) -> Patches | None:
    """Return patches of the sources of a map; None where none holds a whole patch.

    `rng` chooses among too many.
    """
    sources, px_per_m, periods = detail.sources, detail.px_per_m, detail.periods
    sides = [np.median([s.valid.shape[axis] for s in sources]) for axis in (0, 1)]
    down, across = cell(px_per_m, periods[1], sides[0]), cell(px_per_m, periods[0], sides[1])
    shifts = [_phases(sources, axis, c.period) for axis, c in ((0, down), (1, across))]
    places = []
    for k, source in enumerate(sources):
        rows = _starts(source.valid.shape[0], down, shifts[0][k])
        columns = _starts(source.valid.shape[1], across, shifts[1][k])
        if not len(rows) or not len(columns):
            continue
        total = cv2.integral(source.valid.astype(np.uint8))
        r, c = (grid.ravel() for grid in np.meshgrid(rows, columns, indexing="ij"))
        inside = total[r + down.side, c + across.side] - total[r, c + across.side]
        inside += total[r, c] - total[r + down.side, c]
        whole = inside == down.side * across.side
        found = np.stack([np.full(int(whole.sum()), k), r[whole], c[whole]], axis=1)
        places.append(_drawn(found, max(1, math.ceil(2 * MOST / len(sources))), rng))
    found = np.concatenate(places) if places else np.zeros((0, 3), int)
    if not len(found):
        return None
    images = [np.rint(255 * np.clip(s.image, 0, 1)).astype(np.uint8) for s in sources]
    found = _drawn(found, MOST, rng)
    return Patches(images, found, _shown(detail, found, down, across), down, across)


def _shown(detail: Detail, places: np.ndarray, down: Cell, across: Cell) -> np.ndarray:
    """Return plane and middle (n, 3) of patches (n, 3)."""
    source = places[:, 0]
    sizes = np.array([s.valid.shape for s in detail.sources])[source]
    y = places[:, 1] + (down.side - sizes[:, 0]) / 2
    x = places[:, 2] + (across.side - sizes[:, 1]) / 2
    turned = detail.turned[source]
    right, below = np.where(turned, -y, x), np.where(turned, x, y)
    return detail.origins[source] + np.stack([np.zeros(len(x)), right, below], axis=1)


def _drawn(places: np.ndarray, most: int, rng: np.random.Generator) -> np.ndarray:
    """Return at most so many rows, in their order."""
    if len(places) <= most:
        return places
    return places[np.sort(rng.choice(len(places), most, replace=False))]


def _starts(length: int, axis: Cell, shift: float) -> np.ndarray:
    """Return where patches may begin in a source of `length` px."""
    last = length - axis.side
    if last < 0:
        return np.zeros(0, int)
    if not math.isfinite(axis.period):
        stride = max(1, min(axis.side // 12, last // 6))
        return np.arange(0, last + 1, stride)
    # A joint of the lattice lies in the middle of the patches' overlap.
    first = (shift - axis.overlap / 2) % axis.period
    starts = np.rint(np.arange(first, last + 1, axis.period)).astype(int)
    return starts[starts <= last]


def _phases(sources: Sequence[Source], axis: int, period: float) -> np.ndarray:
    """Return where each source's first joint lies along an axis, (n,) px; 0 without a period."""
    if not math.isfinite(period):
        return np.zeros(len(sources))
    profiles = np.stack([_profile(source, axis, period) for source in sources])
    spectra = np.fft.rfft(profiles, axis=1)
    shared, shifts = profiles[0], np.zeros(len(sources), int)
    for _ in range(3):
        match = np.fft.irfft(spectra.conj() * np.fft.rfft(shared), n=_PHASES, axis=1)
        shifts = match.argmax(axis=1)
        shared = np.mean([np.roll(p, s) for p, s in zip(profiles, shifts, strict=True)], axis=0)
    joint = int(np.abs(shared - np.median(shared)).argmax())
    return ((joint - shifts) % _PHASES + 0.5) * period / _PHASES


def _profile(source: Source, axis: int, period: float) -> np.ndarray:
    """Return a source's mean log grey value over one period, (`_PHASES`,), of mean 0."""
    luma = log_luma(np.clip(source.image, 0, 1))
    slow = cv2.GaussianBlur(luma, (0, 0), max(period / 3, 1.0))
    weight = source.valid.sum(axis=1 - axis)
    line = ((luma - slow) * source.valid).sum(axis=1 - axis)
    bins = (np.arange(len(line)) * _PHASES / period).astype(int) % _PHASES
    total = np.bincount(bins, line, _PHASES)
    count = np.bincount(bins, weight, _PHASES)
    profile = np.divide(total, count, out=np.zeros(_PHASES), where=count > 0)
    return np.asarray(profile - profile.mean())
