"""Things on plain surfaces: outlets, switches, stickers, hooks, spots of light."""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene.paint.shading import filled
from plan2scene.textures.exemplar.grain import pattern_band

#: High percentile over the median of what a crop's pattern varies by: noise and plaster have 5 to
#: 10, a thing on them more, as do joints of tiles (from 12 on).
PLAIN = 10.0
#: That percentile: an outlet has a few pixels of a crop.
_HIGH = 99.97
#: Share of the crops that have to be plain for their surface to be so.
_SOME = 0.25
_FAINT = 0.5  # of what makes a thing its fainter parts have at least: a switch's plate
_HALO = 0.4  # of a part's peak, under which it is a halo
_AROUND = 9  # pixels over which a part spreads: the pattern's band is blurred
_RIM = 4  # pixels about a thing's box that go with it
_ROUNDS = 12  # parts of all things
_FEW = 4  # things in a crop at most; a pattern has more
_SMALL = 0.35  # side of a thing over the crop's, at most; joints are longer


def oddness(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return by how much (n,) log crops of a plain surface show things; 0 where nearly all do.

    `luma` (n, s, s) log grey values, `masks` (n, s, s) bool pixels to leave out.
    """
    pairs = zip(luma, masks, strict=True)
    ratio = np.array([_most(_away(one, mask), mask) for one, mask in pairs])
    if not len(ratio) or np.quantile(ratio, _SOME) > PLAIN:
        return np.zeros(len(ratio))
    return np.asarray(np.maximum(np.log(ratio / PLAIN), 0.0))


def things(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return the pixels of things (n, s, s) bool on crops that are plain without them.

    A thing is small, and there are few: what is long, or there many times, is the pattern.
    Parameters as of :func:`oddness`.
    """
    found = np.stack([_things(*pair) for pair in zip(luma, masks, strict=True)])
    return np.asarray(found & ~masks)


def _away(luma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return how far a crop's pattern is from nothing (s, s), in its usual distance; 0 if masked.

    Masked pixels do not count for what is beside them.
    """
    away = np.where(mask, 0.0, np.abs(pattern_band(filled(luma, mask))))
    usual = float(np.median(away[~mask])) if not mask.all() else 1.0
    return np.asarray(away / max(usual, 1e-6))


def _most(away: np.ndarray, mask: np.ndarray) -> float:
    """Return the high percentile of :func:`_away`; 1 where all is masked."""
    return float(np.percentile(away[~mask], _HIGH)) if not mask.all() else 1.0


def _things(luma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return the pixels of things (s, s) bool on one crop; none where it is not plain without.

    The strongest part goes first: it throws a halo into the band that the next is found in.
    """
    found = np.zeros_like(mask)
    for _ in range(_ROUNDS):
        out = mask | found
        away = _away(luma, out)
        if _most(away, out) <= PLAIN:
            return _boxed(found)
        found |= _strongest(away)
        if not _few_and_small(found):
            break
    return np.zeros_like(mask)


def _strongest(away: np.ndarray) -> np.ndarray:
    """Return the pixels (s, s) bool of the part that is farthest away."""
    peak = float(away.max())
    parts = (away > max(_FAINT * PLAIN, _HALO * peak)).astype(np.uint8)
    _, places = cv2.connectedComponents(parts, connectivity=8)
    one = places == places[np.unravel_index(int(away.argmax()), away.shape)]
    return cv2.dilate(one.astype(np.uint8), np.ones((_AROUND, _AROUND), np.uint8)) > 0


def _boxes(found: np.ndarray) -> np.ndarray:
    """Return left, top, width, height (n, 4) of the things that pixels (s, s) bool make up."""
    _, _, boxes, _ = cv2.connectedComponentsWithStats(found.astype(np.uint8), connectivity=8)
    return np.asarray(boxes[1:, :4])


def _boxed(found: np.ndarray) -> np.ndarray:
    """Return the boxes about things (s, s) bool: a plate is fainter than what is on it."""
    mask = np.zeros_like(found)
    for left, top, width, height in _boxes(found):
        rows = slice(max(0, top - _RIM), top + height + _RIM)
        mask[rows, max(0, left - _RIM) : left + width + _RIM] = True
    return mask


def _few_and_small(found: np.ndarray) -> bool:
    """Return whether pixels (s, s) bool are few things, none of them long."""
    boxes = _boxes(found)
    return len(boxes) <= _FEW and bool((boxes[:, 2:] <= _SMALL * len(found)).all())
