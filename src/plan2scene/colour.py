"""Colour spaces and colour differences in numpy (no torch).

Images are ``(..., 3)`` floats in [0, 1], sRGB unless a name says otherwise; hue, saturation and
value are in [0, 1] too (hue 0 and 1 are the same red).
"""

from __future__ import annotations

import numpy as np

#: CIE XYZ of the D65 white (2 degree observer), Y = 1.
WHITE_D65 = np.array([0.95047, 1.0, 1.08883])
_RGB_TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)


def as_float(image: np.ndarray) -> np.ndarray:
    """Return a uint8 image as float32 in [0, 1]; a float image as float32 unchanged."""
    if image.dtype == np.uint8:
        return image.astype(np.float32) / np.float32(255.0)
    return image.astype(np.float32)


def as_uint8(image: np.ndarray) -> np.ndarray:
    """Return a float image in [0, 1] as uint8, rounded; values outside are clamped."""
    return np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)


def rgb_to_hsv(rgb: np.ndarray) -> np.ndarray:
    """Return HSV (..., 3) of RGB (..., 3), both in [0, 1]; the hue of greys is 0."""
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    value = rgb.max(axis=-1)
    chroma = value - rgb.min(axis=-1)
    safe = np.where(chroma > 0, chroma, 1.0)
    hue = np.where(
        value == red,
        (green - blue) / safe,
        np.where(value == green, 2.0 + (blue - red) / safe, 4.0 + (red - green) / safe),
    )
    hue = np.where(chroma > 0, (hue / 6.0) % 1.0, 0.0)
    saturation = np.where(value > 0, chroma / np.where(value > 0, value, 1.0), 0.0)
    return np.stack([hue, saturation, value], axis=-1).astype(rgb.dtype)


def hsv_to_rgb(hsv: np.ndarray) -> np.ndarray:
    """Return RGB (..., 3) of HSV (..., 3), both in [0, 1]; hue is taken modulo 1."""
    hue, saturation, value = hsv[..., 0:1], hsv[..., 1:2], hsv[..., 2:3]
    sector = (np.array([5.0, 3.0, 1.0], dtype=hsv.dtype) + hue * 6.0) % 6.0
    ramp = np.clip(np.minimum(sector, 4.0 - sector), 0.0, 1.0)
    return (value - value * saturation * ramp).astype(hsv.dtype)


def median_colour(image: np.ndarray) -> np.ndarray:
    """Return the per-channel median (3,) float32 of an (h, w, 3) RGB image.

    The lower of the two middle values of an even count, as ``torch.median`` gives (paper
    section 4.3: the median colour is part of the texture embedding).
    """
    pixels = np.sort(as_float(image).reshape(-1, 3), axis=0)
    return pixels[(len(pixels) - 1) // 2]


def delta_hsv(image: np.ndarray, median_rgb: np.ndarray) -> np.ndarray:
    """Return HSV minus the HSV of `median_rgb`, hue wrapped to [-0.5, 0.5], shape (h, w, 3)."""
    delta = rgb_to_hsv(as_float(image)) - rgb_to_hsv(median_rgb.astype(np.float32))
    delta[..., 0] -= np.rint(delta[..., 0])
    return delta


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


def rgb_to_lab(rgb: np.ndarray) -> np.ndarray:
    """Return CIE L*a*b* (D65) of sRGB (..., 3) in [0, 1], float64."""
    ratio = srgb_to_linear(rgb) @ _RGB_TO_XYZ.T / WHITE_D65
    cube = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = cube[..., 0], cube[..., 1], cube[..., 2]
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def delta_e_2000(lab_a: np.ndarray, lab_b: np.ndarray) -> np.ndarray:
    """Return the CIEDE2000 difference (...,) of two L*a*b* colours (..., 3).

    Sharma, Wu and Dalal, "The CIEDE2000 color-difference formula" (2005), kL = kC = kH = 1.
    """
    lab_a, lab_b = np.asarray(lab_a, np.float64), np.asarray(lab_b, np.float64)
    mean_chroma = (np.hypot(*_ab(lab_a)) + np.hypot(*_ab(lab_b))) / 2
    gain = 1.5 - 0.5 * np.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7))
    chroma_a, hue_a = _chroma_hue(lab_a, gain)
    chroma_b, hue_b = _chroma_hue(lab_b, gain)
    grey = chroma_a * chroma_b == 0
    turn = hue_b - hue_a
    turn = np.where(turn > 180, turn - 360, np.where(turn < -180, turn + 360, turn))
    d_hue = 2 * np.sqrt(chroma_a * chroma_b) * np.sin(np.radians(np.where(grey, 0.0, turn)) / 2)
    hue = hue_a + hue_b
    far = np.abs(hue_a - hue_b) > 180
    mean_hue = np.where(far, np.where(hue < 360, hue + 360, hue - 360), hue) / 2
    mean_hue = np.where(grey, hue, mean_hue)
    lightness = (lab_a[..., 0] + lab_b[..., 0]) / 2
    chroma = (chroma_a + chroma_b) / 2
    weight_l, weight_c, weight_h, rotation = _ciede_weights(lightness, chroma, mean_hue)
    term_l = (lab_b[..., 0] - lab_a[..., 0]) / weight_l
    term_c = (chroma_b - chroma_a) / weight_c
    term_h = d_hue / weight_h
    return np.sqrt(term_l**2 + term_c**2 + term_h**2 + rotation * term_c * term_h)


def _ab(lab: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return lab[..., 1], lab[..., 2]


def _chroma_hue(lab: np.ndarray, gain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return CIEDE2000's modified chroma and hue (degrees in [0, 360))."""
    a, b = lab[..., 1] * gain, lab[..., 2]
    return np.hypot(a, b), np.degrees(np.arctan2(b, a)) % 360


def _ciede_weights(
    lightness: np.ndarray, chroma: np.ndarray, hue: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return S_L, S_C, S_H and R_T of the CIEDE2000 formula."""
    factor = (
        1
        - 0.17 * np.cos(np.radians(hue - 30))
        + 0.24 * np.cos(np.radians(2 * hue))
        + 0.32 * np.cos(np.radians(3 * hue + 6))
        - 0.20 * np.cos(np.radians(4 * hue - 63))
    )
    offset = (lightness - 50) ** 2
    weight_l = 1 + 0.015 * offset / np.sqrt(20 + offset)
    weight_c = 1 + 0.045 * chroma
    weight_h = 1 + 0.015 * chroma * factor
    angle = np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2)))
    rotation = -np.sin(angle) * 2 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    return weight_l, weight_c, weight_h, rotation
