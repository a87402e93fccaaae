"""Which way a surface's crops run, so that planks of photos taken in different directions agree.

A photo's frame is known up to quarter turns, so the same floor runs along x in one crop and along
y in the next. Planks, boards and grain vary across much more than along.
"""

from __future__ import annotations

import cv2
import numpy as np

_FINE, _SLOW = 1.5, 12.0  # scales (sigma, crop pixels) between which a pattern lies
_CLEAR = 0.2  # from this on a crop has a direction
_MOST = 0.6  # share of the crops that need one for the surface to have one


def grain(luma: np.ndarray, mask: np.ndarray) -> float:
    """Return how much a crop runs along x (to 1) or along y (to -1); 0 for neither.

    The structure tensor's energies along both axes: (Jyy - Jxx) / (Jxx + Jyy).

    Parameters
    ----------
    luma : (s, s) float
        Log grey values.
    mask : (s, s) bool
        Pixels to leave out.
    """
    band = pattern_band(luma)
    used = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
    across, down = (cv2.Sobel(band, cv2.CV_64F, dx, 1 - dx)[used] for dx in (1, 0))
    energy = float((across**2).sum() + (down**2).sum())
    return float((down**2).sum() - (across**2).sum()) / energy if energy > 0 else 0.0


def directed(grains: np.ndarray) -> bool:
    """Return whether crops of grains (n,) run one way: not tiles, plaster, carpets."""
    return bool((np.abs(grains) >= _CLEAR).sum() >= _MOST * len(grains))


def quarter_turns(grains: np.ndarray) -> np.ndarray:
    """Return which crops have to be turned by 90 degrees to run as most do, (n,) bool.

    None where too few crops have a direction.
    """
    clear = np.abs(grains) >= _CLEAR
    if not directed(grains):
        return np.zeros(len(grains), dtype=bool)
    usual = np.sign(grains[clear].sum()) or 1.0
    return np.asarray(clear & (np.sign(grains) != usual))


def faintness(luma: np.ndarray, masks: np.ndarray, grains: np.ndarray) -> np.ndarray:
    """Return by how much (n,) log crops' patterns are fainter than that of the better ones.

    0 for the quarter of the strongest contrast. A view at a flat angle into a window shows a gleam
    and hardly a plank. 0 for all where the surface does not run one way: there contrast is things
    more than pattern. `luma` (n, s, s) log grey values, `masks` (n, s, s) as of :func:`grain`.
    """
    if not directed(grains):
        return np.zeros(len(grains))
    band = [pattern_band(one)[~mask].std() for one, mask in zip(luma, masks, strict=True)]
    contrast = np.maximum(np.nan_to_num(band), 1e-4)
    return np.maximum(np.log(np.percentile(contrast, 75) / contrast), 0.0)


def pattern_band(luma: np.ndarray) -> np.ndarray:
    """Return the scales of log grey values (s, s) between which a pattern lies."""
    values = luma.astype(np.float64)
    return cv2.GaussianBlur(values, (0, 0), _FINE) - cv2.GaussianBlur(values, (0, 0), _SLOW)


def grains_of(luma: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return the :func:`grain` (n,) of crops (n, s, s)."""
    return np.array([grain(one, mask) for one, mask in zip(luma, masks, strict=True)])


def one_way(
    flat: np.ndarray, masks: np.ndarray, grains: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return crops (n, s, s, 3), masks (n, s, s) with planks running one way, and which turned."""
    turned = quarter_turns(grains)
    flat, masks = flat.copy(), masks.copy()
    flat[turned] = np.rot90(flat[turned], axes=(1, 2))
    masks[turned] = np.rot90(masks[turned], axes=(1, 2))
    return flat, masks, turned
