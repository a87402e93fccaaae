"""Plain paint: textures of white walls and ceilings without what light and cameras left in them.

White paint has one colour. What varies slowly over a white wall is its light, and faint colours
of its grain are the noise of a dim photo; relief and coloured patterns stay.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.colour import as_uint8, from_log_axes, linear_to_srgb, log_axes, srgb_to_linear


@dataclass(frozen=True)
class PlainSettings:
    """What counts as light and as noise. Chosen by looking at one real flat (development)."""

    slow_m: float = 0.1  #: standard deviation, metres, of the filter before a pattern is measured
    smear_m: float = 0.03  #: of the filter that takes light, smears and lens dirt of plain paint
    noise: float = 0.06  #: fainter colours (log red or blue against green) are noise
    brightest: float = 0.95  #: linear


SETTINGS = PlainSettings()


def plain(image: np.ndarray, colour: np.ndarray, px_per_m: float) -> tuple[np.ndarray, float]:
    """Return a tile in one paint with its relief, and how strong its pattern is.

    `image` and the tile are (h, w, 3) uint8 sRGB, `colour` (3,) is the paint in linear RGB; the
    strength is the standard deviation of log brightness.
    """
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)
    pattern = float((axes - _slow(axes, SETTINGS.slow_m * px_per_m))[..., 0].std())
    detail = axes - _slow(axes, SETTINGS.smear_m * px_per_m)
    faint = np.clip(detail[..., 1:], -SETTINGS.noise, SETTINGS.noise)
    detail[..., 1:] -= faint
    detail[..., 0] -= np.median(detail[..., 0])
    linear = from_log_axes(log_axes(np.asarray(colour)) + detail)
    painted = as_uint8(linear_to_srgb(np.minimum(linear, SETTINGS.brightest)))
    return painted, pattern


def _slow(axes: np.ndarray, sigma: float) -> np.ndarray:
    """Return the slow part of a tile (h, w, 3) float32, of a filter of so many pixels."""
    pad = int(np.ceil(3 * sigma))
    padded = np.pad(axes, ((pad, pad), (pad, pad), (0, 0)), mode="wrap")
    slow = cv2.GaussianBlur(padded, (0, 0), sigma)
    return np.asarray(slow[pad:-pad, pad:-pad] if pad else slow)
