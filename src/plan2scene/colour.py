"""Colour in numpy (no torch): the sRGB curve, L*a*b*, colour differences, clipped pixels.

Images are ``(..., 3)`` sRGB, floats in [0, 1] or uint8.
"""

from __future__ import annotations

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  #: Luminance of linear R, G, B
#: A pixel of a photo is clipped if its greatest channel is at most the first level (black) or its
#: least channel at least the second (burned out). The second is one below the default of
#: :func:`clipped_share`, by which kept crops are compared: 4 of the demo's 594 crops would pass it.
CLIPPED_LEVELS = (2, 249)
#: Colour of a house's outside (light render), sRGB levels; photos of rooms do not show it.
RENDER = (222, 216, 206)
#: Bare wood in L*a*b*: range of hue in degrees, from mahogany to pine, and smallest chroma. Chosen
#: by looking at doors of two real flats (development) and the demo.
WOOD_HUE, WOOD_CHROMA = (40.0, 88.0), 15.0


def as_float(image: np.ndarray) -> np.ndarray:
    """Return a uint8 image as float32 in [0, 1]; a float image as float32 unchanged."""
    if image.dtype == np.uint8:
        return image.astype(np.float32) / np.float32(255.0)
    return image.astype(np.float32)


def as_uint8(image: np.ndarray) -> np.ndarray:
    """Return a float image in [0, 1] as uint8, rounded; values outside are clamped."""
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def median_colour(image: np.ndarray) -> np.ndarray:
    """Return the per-channel median (3,) float32 of an (h, w, 3) RGB image.

    Of an even count it is the lower of the two middle values, as in ``torch.median`` (paper
    section 5.2: the median colour is part of the texture embedding).
    """
    pixels = np.sort(as_float(image).reshape(-1, 3), axis=0)
    return pixels[(len(pixels) - 1) // 2]


def clipped_share(image: np.ndarray, levels: tuple[int, int] = (2, 250)) -> float:
    """Return the share of pixels of an (h, w, 3) uint8 image that are burned out or black.

    Black: the greatest channel is at most `levels[0]`; burned out: the least, at least `levels[1]`.
    """
    low, high = levels
    red, green, blue = image[..., 0], image[..., 1], image[..., 2]
    brightest = np.maximum(np.maximum(red, green), blue)  # far faster than max(axis=2)
    least = np.minimum(np.minimum(red, green), blue)
    return float(((least >= high) | (brightest <= low)).mean())


def srgb_to_linear(rgb: np.ndarray) -> np.ndarray:
    """Return linear values (float64) of sRGB: uint8, or floats in [0, 1]; any shape."""
    if rgb.dtype == np.uint8:
        return _LINEAR_OF_UINT8[rgb]
    encoded = np.asarray(rgb, dtype=np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(linear: np.ndarray) -> np.ndarray:
    """Return sRGB (float64) of linear values in [0, 1], any shape; negative ones count as 0."""
    values = np.maximum(np.asarray(linear, dtype=np.float64), 0.0)
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)


_LINEAR_OF_UINT8 = srgb_to_linear(np.arange(256) / 255.0)


def log_axes(linear: np.ndarray) -> np.ndarray:
    """Return log brightness, red and blue (..., 3) of linear RGB (..., 3).

    Brightness is the mean of the three logs; red and blue are log(red / green), log(blue / green).
    """
    log = np.log(np.maximum(linear, 1e-3))
    green = log[..., 1]
    return np.stack([log.mean(axis=-1), log[..., 0] - green, log[..., 2] - green], axis=-1)


def from_log_axes(axes: np.ndarray) -> np.ndarray:
    """Return linear RGB (..., 3) of log brightness, red and blue (..., 3)."""
    brightness, red, blue = axes[..., 0], axes[..., 1], axes[..., 2]
    green = brightness - (red + blue) / 3
    return np.exp(np.stack([green + red, green, green + blue], axis=-1))


def rgb_to_lab(rgb: np.ndarray) -> np.ndarray:
    """Return CIE L*a*b* (D65) of sRGB floats (..., 3) in [0, 1], float64."""
    from skimage.color import rgb2lab

    return rgb2lab(np.asarray(rgb, dtype=np.float64))


def is_wood(labs: np.ndarray) -> np.ndarray:
    """Return which L*a*b* colours (..., 3) are those of bare wood, rare in paint, (...) bool."""
    hue = np.degrees(np.arctan2(labs[..., 2], labs[..., 1]))
    chroma = np.hypot(labs[..., 1], labs[..., 2])
    return np.asarray((chroma >= WOOD_CHROMA) & (hue >= WOOD_HUE[0]) & (hue <= WOOD_HUE[1]))


def delta_e_2000(lab_a: np.ndarray, lab_b: np.ndarray) -> np.ndarray:
    """Return the CIEDE2000 difference (...,) of two L*a*b* colours (..., 3), broadcast."""
    from skimage.color import deltaE_ciede2000

    return deltaE_ciede2000(lab_a, lab_b)
