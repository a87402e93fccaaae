"""Which way a surface's crops run, so that planks of photos taken in different directions agree.

A photo's frame is known up to quarter turns, so the same floor runs along x in one crop and along
y in the next. Planks, boards and grain vary across much more than along.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from plan2scene.textures.exemplar.light import log_luma

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
    values = luma.astype(np.float64)
    band = cv2.GaussianBlur(values, (0, 0), _FINE) - cv2.GaussianBlur(values, (0, 0), _SLOW)
    used = cv2.dilate(mask.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
    across, down = (cv2.Sobel(band, cv2.CV_64F, dx, 1 - dx)[used] for dx in (1, 0))
    energy = float((across**2).sum() + (down**2).sum())
    return float((down**2).sum() - (across**2).sum()) / energy if energy > 0 else 0.0


def quarter_turns(grains: Sequence[float]) -> np.ndarray:
    """Return which crops have to be turned by 90 degrees to run as most do, (n,) bool.

    None where too few crops have a direction: tiles, plaster, carpets.
    """
    runs = np.asarray(grains, dtype=np.float64)
    clear = np.abs(runs) >= _CLEAR
    if clear.sum() < _MOST * len(runs):
        return np.zeros(len(runs), dtype=bool)
    usual = np.sign(runs[clear].sum()) or 1.0
    return np.asarray(clear & (np.sign(runs) != usual))


def one_way(flat: np.ndarray, masks: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return crops (n, s, s, 3), masks (n, s, s) with planks running one way, and which turned."""
    turned = quarter_turns([grain(log_luma(i), m) for i, m in zip(flat, masks, strict=True)])
    flat, masks = flat.copy(), masks.copy()
    flat[turned] = np.rot90(flat[turned], axes=(1, 2))
    masks[turned] = np.rot90(masks[turned], axes=(1, 2))
    return flat, masks, turned
