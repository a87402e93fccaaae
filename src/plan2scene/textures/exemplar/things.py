"""Things on plain surfaces: outlets, switches, stickers, hooks, spots of light."""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene.paint.shading import filled
from plan2scene.textures.exemplar.lattice import pattern_band
from plan2scene.textures.exemplar.settings import EXEMPLAR


def oddness(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return how strongly (n,) crops of a plain surface show objects; 0 if nearly all crops do.

    `luma` (n, s, s) are log grey values, `masks` (n, s, s) bool the pixels to leave out.
    """
    pairs = zip(luma, masks, strict=True)
    ratio = np.array([_most(_away(one, mask), mask) for one, mask in pairs])
    if not len(ratio) or np.quantile(ratio, EXEMPLAR.some) > EXEMPLAR.plain:
        return np.zeros(len(ratio))
    return np.asarray(np.maximum(np.log(ratio / EXEMPLAR.plain), 0.0))


def things(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return the pixels of objects (n, s, s) bool on crops that are plain without them.

    Objects are few and small. What is long, or repeats many times, is the pattern. Parameters as in
    :func:`oddness`.
    """
    pixels = np.stack([_things(*pair) for pair in zip(luma, masks, strict=True)])
    return np.asarray(pixels & ~masks)


def _away(luma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return the pattern's absolute values (s, s) over their median; 0 where masked."""
    away = np.where(mask, 0.0, np.abs(pattern_band(filled(luma, mask))))
    usual = float(np.median(away[~mask])) if not mask.all() else 1.0
    return np.asarray(away / max(usual, 1e-6))


def _most(away: np.ndarray, mask: np.ndarray) -> float:
    """Return the high percentile of :func:`_away`; 1 where all is masked."""
    return float(np.percentile(away[~mask], EXEMPLAR.high)) if not mask.all() else 1.0


def _things(luma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return the objects' pixels (s, s) bool on one crop; none if the rest is not plain.

    The strongest part is taken out first, because its halo would hide the next one.
    """
    pixels = np.zeros_like(mask)
    for _ in range(EXEMPLAR.parts):
        out = mask | pixels
        away = _away(luma, out)
        if _most(away, out) <= EXEMPLAR.plain:
            return _boxed(pixels)
        pixels |= _strongest(away)
        if not _few_and_small(pixels):
            break
    return np.zeros_like(mask)


def _strongest(away: np.ndarray) -> np.ndarray:
    """Return the pixels (s, s) bool of the part with the strongest value."""
    peak = float(away.max())
    parts = (away > max(EXEMPLAR.part * EXEMPLAR.plain, EXEMPLAR.halo * peak)).astype(np.uint8)
    _, places = cv2.connectedComponents(parts, connectivity=8)
    one = places == places[np.unravel_index(int(away.argmax()), away.shape)]
    return (
        cv2.dilate(
            one.astype(np.uint8), np.ones((EXEMPLAR.around_px, EXEMPLAR.around_px), np.uint8)
        )
        > 0
    )


def _boxes(pixels: np.ndarray) -> np.ndarray:
    """Return left, top, width, height (n, 4) of the connected components of pixels (s, s) bool."""
    _, _, boxes, _ = cv2.connectedComponentsWithStats(pixels.astype(np.uint8), connectivity=8)
    return np.asarray(boxes[1:, :4])


def _boxed(pixels: np.ndarray) -> np.ndarray:
    """Return things (s, s) bool grown to their boxes: a plate is fainter than the switch on it."""
    mask = np.zeros_like(pixels)
    for left, top, width, height in _boxes(pixels):
        rows = slice(max(0, top - EXEMPLAR.box_rim_px), top + height + EXEMPLAR.box_rim_px)
        mask[rows, max(0, left - EXEMPLAR.box_rim_px) : left + width + EXEMPLAR.box_rim_px] = True
    return mask


def _few_and_small(pixels: np.ndarray) -> bool:
    """Return whether pixels (s, s) bool are few things, none of them long."""
    boxes = _boxes(pixels)
    return len(boxes) <= EXEMPLAR.few and bool((boxes[:, 2:] <= EXEMPLAR.small * len(pixels)).all())
