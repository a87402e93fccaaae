"""Degradation protocol: photo-like crops of a clean tile, to measure texture methods against it.

A crop is a window of the repeated tile at a random place, scale and slant, seen under uneven
light: a smooth gain field, at times a soft shadow edge or a highlight, a colour cast, blur and
JPEG compression. What a method makes of such crops is compared with the clean tile.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.colour import as_uint8, linear_to_srgb, srgb_to_linear
from plan2scene.seeds import derive_seed

#: Side of the crops in pixels.
CROP_PX = 128


@dataclass(frozen=True)
class Degradation:
    """How crops are spoiled; the defaults are the protocol of the published figures.

    Attributes
    ----------
    window_share : float
        Side of a window over the tile's, before scaling (96 of 128 px).
    scale : (float, float)
        Range of the factor on the window's side.
    rotation_deg : float
        Largest slant to either side.
    turn_deg : float
        Turn of all crops, before the slant.
    gain : float
        Largest deviation of the smooth gain field from 1.
    shadow_share, highlight_share : float
        Shares of crops with a shadow edge and with a highlight.
    white_balance : float
        Largest deviation of the red and the blue factor from 1.
    blur_px : (float, float)
        Range of the blur's sigma in crop pixels.
    jpeg_quality : int
    """

    window_share: float = 0.75
    scale: tuple[float, float] = (0.8, 1.25)
    rotation_deg: float = 3.0
    turn_deg: float = 0.0
    gain: float = 0.25
    shadow_share: float = 1 / 3
    highlight_share: float = 1 / 6
    white_balance: float = 0.05
    blur_px: tuple[float, float] = (0.4, 0.8)
    jpeg_quality: int = 70


@dataclass(frozen=True, eq=False)
class DegradedCrop:
    """A spoiled crop and what was done to it.

    Attributes
    ----------
    image : (128, 128, 3) uint8
        sRGB.
    side : float
        Side of the window in sides of the tile.
    angle_deg : float
        Turn of the crop's columns against the tile's.
    shadow, highlight : bool
    """

    image: np.ndarray
    side: float
    angle_deg: float
    shadow: bool
    highlight: bool


def degrade(
    tile: np.ndarray, seed: int, *, crops: int = 6, how: Degradation | None = None
) -> list[DegradedCrop]:
    """Return photo-like crops of a clean tileable texture; same seed, same bytes.

    Parameters
    ----------
    tile : (s, s, 3) uint8
        sRGB tile that repeats in both directions.
    seed : int
        Decides places, light and casts, each crop on its own.
    crops : int
        Number of crops. The shares of shadows and highlights hold exactly over the crops (rounded
        to whole crops); which crops get them is drawn.
    how : Degradation, optional
        ValueError for a tile that is not square uint8 RGB.
    """
    if tile.dtype != np.uint8 or tile.ndim != 3 or tile.shape[0] != tile.shape[1]:
        raise ValueError(f"expected (s, s, 3) uint8, found {tile.shape} {tile.dtype}")
    how = how or Degradation()
    rng = np.random.default_rng(derive_seed(seed, "degradation"))
    shadows = rng.permutation(crops) < round(how.shadow_share * crops)
    highlights = rng.permutation(crops) < round(how.highlight_share * crops)
    return [
        _spoil(tile, derive_seed(seed, "degradation", k), how, bool(shadows[k]), bool(lights))
        for k, lights in enumerate(highlights)
    ]


def _spoil(
    tile: np.ndarray, seed: int, how: Degradation, shadow: bool, highlight: bool
) -> DegradedCrop:
    """Return one crop; light acts on linear values, the cast, blur and JPEG on sRGB ones."""
    rng = np.random.default_rng(seed)
    side = how.window_share * float(rng.uniform(*how.scale))
    angle = how.turn_deg + float(rng.uniform(-how.rotation_deg, how.rotation_deg))
    view = window(tile, rng.uniform(0.0, 1.0, 2), side, angle)
    values = srgb_to_linear(view)
    values *= gain_field(rng, how.gain)[..., None]
    if shadow:
        values *= _shadow(rng)[..., None]
    if highlight:
        blob = _highlight(rng)[..., None]
        values = values + (1.0 - values) * blob
    cast = 1.0 + how.white_balance * rng.uniform(-1.0, 1.0, 3) * (1.0, 0.0, 1.0)
    image = as_uint8(linear_to_srgb(np.minimum(values, 1.0)) * cast)
    image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(*how.blur_px)))
    _, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, how.jpeg_quality])
    decoded = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))
    return DegradedCrop(np.ascontiguousarray(decoded[..., ::-1]), side, angle, shadow, highlight)


def window(tile: np.ndarray, centre: np.ndarray, side: float, angle_deg: float) -> np.ndarray:
    """Return a 128 px view of a repeated tile, (128, 128, 3) of the tile's dtype.

    Parameters
    ----------
    centre : (2,) float
        Middle of the window (x, y) in sides of the tile.
    side : float
        Side of the window in sides of the tile; above 1 where the tile repeats in it.
    angle_deg : float
        The window's turn, from x towards y.
    """
    px = tile.shape[0]
    turn = np.radians(angle_deg)
    step = side * px / CROP_PX
    offset = (np.arange(CROP_PX) + 0.5 - CROP_PX / 2) * step
    along, down = np.meshgrid(offset, offset)
    x = np.cos(turn) * along - np.sin(turn) * down + centre[0] * px
    y = np.sin(turn) * along + np.cos(turn) * down + centre[1] * px
    margin = 4
    wide = cv2.copyMakeBorder(tile, margin, margin, margin, margin, cv2.BORDER_WRAP)
    if step > 1.0:  # fewer pixels than the tile has: average first
        wide = cv2.GaussianBlur(wide, (0, 0), 0.45 * step)
    x32, y32 = ((v % px + margin - 0.5).astype(np.float32) for v in (x, y))
    return cv2.remap(wide, x32, y32, cv2.INTER_CUBIC)


def gain_field(rng: np.random.Generator, gain: float) -> np.ndarray:
    """Return a smooth (128, 128) factor within 1 -+ `gain`, a random 3 x 3 grid interpolated."""
    grid = rng.uniform(-gain, gain, (3, 3))
    position = np.linspace(0.0, 2.0, CROP_PX, dtype=np.float32)
    across, down = np.meshgrid(position, position)
    smooth = cv2.remap(
        grid.astype(np.float32), across, down, cv2.INTER_CUBIC, None, cv2.BORDER_REFLECT_101
    )
    return 1.0 + np.clip(smooth.astype(np.float64), -gain, gain)


def _shadow(rng: np.random.Generator) -> np.ndarray:
    """Return a (128, 128) factor: 1 on one side of a soft straight edge, 0.6 to 0.8 beyond."""
    direction = rng.uniform(0.0, 2.0 * np.pi)
    position = (np.arange(CROP_PX) + 0.5) / CROP_PX - 0.5
    across = np.cos(direction) * position[None, :] + np.sin(direction) * position[:, None]
    softness = rng.uniform(0.02, 0.08)
    beyond = 1.0 / (1.0 + np.exp(-(across - rng.uniform(-0.25, 0.25)) / softness))
    return 1.0 - (1.0 - rng.uniform(0.6, 0.8)) * beyond


def _highlight(rng: np.random.Generator) -> np.ndarray:
    """Return (128, 128) shares of white of an elliptic specular blob."""
    centre = rng.uniform(0.2, 0.8, 2)
    radius = rng.uniform(0.08, 0.2, 2)
    position = (np.arange(CROP_PX) + 0.5) / CROP_PX
    x = (position[None, :] - centre[0]) / radius[0]
    y = (position[:, None] - centre[1]) / radius[1]
    return rng.uniform(0.5, 0.9) * np.exp(-0.5 * (x**2 + y**2))
