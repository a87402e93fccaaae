"""Degradation of clean textures to look like crops of room photos.

Light acts first: a smooth gain field, sometimes a soft shadow edge or a highlight. Then the camera:
a colour cast, lost resolution, blur, noise and JPEG compression. :func:`degrade` is the protocol
for measuring texture methods: crops are windows of the repeated tile at a random position, scale
and rotation, and a method's result from them is compared with the clean tile. Training degrades
its crops by :func:`photograph`.
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
    """Parameters of the degradation; the defaults are the protocol of the published figures."""

    window_share: float = 0.75  #: side of a window over the tile's, before scaling (96 of 128 px)
    scale: tuple[float, float] = (0.8, 1.25)  #: range of the factor on the window's side
    rotation_deg: float = 3.0  #: largest random rotation to either side
    turn_deg: float = 0.0  #: fixed rotation of all crops, added to the random one

    gain: float = 0.25  #: largest deviation of the smooth gain field from 1
    keep_median: bool = False  #: divide the gain field by its median: the median colour stays
    shadow_share: float = 1 / 3  #: share of crops with a shadow edge
    highlight_share: float = 1 / 6  #: share of crops with a highlight
    white_balance: float = 0.05  #: largest deviation of the red and the blue factor from 1
    exposure: float = 0.0  #: largest deviation from 1 of the factor on all colours

    resolution: float = 1.0  #: smallest photo resolution, relative to the crop's pixels in a row
    blur_px: tuple[float, float] = (0.4, 0.8)  #: range of the blur's sigma in crop pixels
    noise: float = 0.0  #: largest standard deviation of the noise, of 255 levels
    jpeg_quality: tuple[int, int] = (70, 70)  #: range, both ends included


#: Inputs of the texture models. These take the colour from the crop's median, so that must stay.
UNEVEN_LIGHT = Degradation(
    gain=0.35,
    keep_median=True,
    shadow_share=0.0,
    highlight_share=0.0,
    white_balance=0.0,
    blur_px=(0.05, 0.8),
    noise=3.0,
    jpeg_quality=(98, 100),
)
#: Like the worst crops of real photos: distant, dim, badly lit.
ROOM_PHOTO = Degradation(
    gain=0.5,
    shadow_share=0.3,
    highlight_share=0.15,
    white_balance=0.1,
    exposure=0.25,
    resolution=0.25,
    blur_px=(0.1, 0.8),
    noise=4.0,
    jpeg_quality=(40, 95),
)


@dataclass(frozen=True, eq=False)
class DegradedCrop:
    """A degraded crop and the degradation that was drawn for it."""

    image: np.ndarray  #: (128, 128, 3) uint8 sRGB
    side: float  #: of the window, in sides of the tile
    angle_deg: float  #: turn of the crop's columns against the tile's
    shadow: bool
    highlight: bool


def degrade(
    tile: np.ndarray, seed: int, *, crops: int = 6, how: Degradation | None = None
) -> list[DegradedCrop]:
    """Return photo-like crops of a clean tileable texture; same seed, same bytes.

    The tile (s, s, 3) is uint8 sRGB; ValueError otherwise. Position, light and colour cast are
    drawn for each crop. The shares of shadows and highlights hold exactly over the crops (rounded
    to whole crops); which crops get them is random.
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
    """Return one crop of the protocol."""
    rng = np.random.default_rng(seed)
    side = how.window_share * float(rng.uniform(*how.scale))
    angle = how.turn_deg + float(rng.uniform(-how.rotation_deg, how.rotation_deg))
    view = window(tile, rng.uniform(0.0, 1.0, 2), side, angle)
    return DegradedCrop(_seen(view, rng, how, shadow, highlight), side, angle, shadow, highlight)


def photograph(view: np.ndarray, rng: np.random.Generator, how: Degradation) -> np.ndarray:
    """Return a crop (128, 128, 3) uint8 sRGB under other light and from another camera."""
    shadow, highlight = rng.random(2) < (how.shadow_share, how.highlight_share)
    return _seen(view, rng, how, bool(shadow), bool(highlight))


def photographed(
    crops: np.ndarray, rng: np.random.Generator, how: Degradation, share: float
) -> np.ndarray:
    """Return crops (n, 128, 128, 3) uint8; each is degraded by :func:`photograph` at random."""
    spoiled = rng.random(len(crops)) < share
    pairs = zip(crops, spoiled, strict=True)
    return np.stack([photograph(crop, rng, how) if hit else crop for crop, hit in pairs])


def _seen(
    view: np.ndarray, rng: np.random.Generator, how: Degradation, shadow: bool, highlight: bool
) -> np.ndarray:
    """Return a degraded view; light acts on linear values, the camera on sRGB values.

    Exposure, resolution and noise draw no random numbers where `how` turns them off.
    """
    values = srgb_to_linear(view)
    gain = gain_field(rng, how.gain)
    values *= (gain / np.median(gain) if how.keep_median else gain)[..., None]
    if shadow:
        values *= _shadow(rng)[..., None]
    if highlight:
        blob = _highlight(rng)[..., None]
        values = values + (1.0 - values) * blob
    cast = 1.0 + how.white_balance * rng.uniform(-1.0, 1.0, 3) * (1.0, 0.0, 1.0)
    if how.exposure:
        cast *= 1.0 + rng.uniform(-how.exposure, how.exposure)
    image = as_uint8(linear_to_srgb(np.minimum(values, 1.0)) * cast)
    if how.resolution < 1.0:
        side = round(CROP_PX * rng.uniform(how.resolution, 1.0))
        small = cv2.resize(image, (side, side), interpolation=cv2.INTER_AREA)
        image = cv2.resize(small, (CROP_PX, CROP_PX), interpolation=cv2.INTER_CUBIC)
    image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(*how.blur_px)))
    if how.noise:
        noise = rng.normal(0.0, rng.uniform(0.0, how.noise), image.shape)
        image = np.rint(np.clip(image + noise, 0, 255)).astype(np.uint8)
    quality = int(rng.integers(*how.jpeg_quality, endpoint=True))
    _, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    decoded = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))
    return np.ascontiguousarray(decoded[..., ::-1])


def window(tile: np.ndarray, centre: np.ndarray, side: float, angle_deg: float) -> np.ndarray:
    """Return a 128 px view of a repeated tile, (128, 128, 3) of the tile's dtype.

    Parameters
    ----------
    centre : (2,) float
        Middle of the window (x, y) in sides of the tile.
    side : float
        Side of the window in sides of the tile; above 1 the tile repeats in the window.
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
    """Return a smooth (128, 128) factor in 1 -+ `gain`, interpolated from a random 3 x 3 grid."""
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
    """Return an elliptic specular blob: (128, 128) shares of white."""
    centre = rng.uniform(0.2, 0.8, 2)
    radius = rng.uniform(0.08, 0.2, 2)
    position = (np.arange(CROP_PX) + 0.5) / CROP_PX
    x = (position[None, :] - centre[0]) / radius[0]
    y = (position[:, None] - centre[1]) / radius[1]
    return rng.uniform(0.5, 0.9) * np.exp(-0.5 * (x**2 + y**2))
