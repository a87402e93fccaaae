"""Camera model: linear radiance to a photo by exposure, balance, lens, sensor, tone and JPEG."""

from __future__ import annotations

import io
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from plan2scene.colour import as_uint8, linear_to_srgb
from plan2scene_workshop.rendering.denoise import MIN_ALBEDO

Image = NDArray[np.float32]
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


@dataclass(frozen=True)
class CameraStyle:
    """Camera parameters of one shot."""

    exposure_stops: float  #: bias of the automatic exposure
    balance: tuple[float, float, float]  #: gains by errors of the automatic white balance, near 1
    cast_left: float  #: share in [0, 1] of the light's colour that white balance does not remove
    shoulder: float  #: linear value above which highlights are compressed
    contrast: float  #: exponent about middle grey, near 1
    vignette: float  #: loss of light in the corners, in [0, 1]
    blur_px: float  #: standard deviation of the lens blur at 640 px of width
    noise: float  #: sensor noise: its deviation is this times sqrt(value + 0.02), full scale 1
    #: Exponent on the light's brightness relative to its median. Below 1 it imitates merged
    #: exposures as in listings, so that dark corners and bright window sides keep their texture.
    range_kept: float


def draw_style(rng: np.random.Generator) -> CameraStyle:
    """Draw the style of one shot; one in eight has a strong colour cast."""
    strength = 0.07 if rng.random() < 0.125 else 0.025
    balance = np.exp(np.clip(rng.normal(0, strength, 3), -2 * strength, 2 * strength))
    balance /= balance.mean()
    red, green, blue = (float(gain) for gain in balance)
    return CameraStyle(
        float(np.clip(rng.normal(0.0, 0.22), -0.5, 0.45)),
        (red, green, blue),
        float(rng.uniform(0.1, 0.5)),
        float(rng.uniform(0.5, 0.7)),
        float(rng.uniform(0.9, 1.06)),
        float(rng.uniform(0.0, 0.22)),
        float(rng.uniform(0.2, 0.55)),
        float(rng.uniform(0.002, 0.012)),
        float(rng.uniform(0.5, 0.85)),
    )


def develop(
    radiance: Image, albedo: Image, style: CameraStyle, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return the photo of a radiance image.

    Parameters
    ----------
    radiance, albedo : (h, w, 3) float32
        Linear RGB; from the albedo, metering computes the amount and colour of incident light.

    Returns
    -------
    (h, w, 3) uint8
        sRGB.
    """
    lit = albedo.max(-1) > MIN_ALBEDO
    image = radiance * _metering(radiance, albedo, lit, style)
    image = _lens(image, style)
    noise = rng.standard_normal(image.shape, dtype=np.float32)
    image = image + noise * style.noise * np.sqrt(np.maximum(image, 0) + 0.02)
    image = tone(np.maximum(image, 0), style)
    return as_uint8(linear_to_srgb(image))


def merge_exposures(light: Image, lit: NDArray[np.bool_], kept: float) -> Image:
    """Return `light` (h, w, 3) with its brightness over the median raised to the power `kept`."""
    grey = light @ _LUMINANCE
    if not lit.any():
        return light
    median = float(np.median(grey[lit]))
    gain = (np.maximum(grey, 1e-4) / max(median, 1e-4)) ** (kept - 1)
    return (light * np.minimum(gain, 8.0)[..., None]).astype(np.float32)


def _metering(
    radiance: Image, albedo: Image, lit: NDArray[np.bool_], style: CameraStyle
) -> NDArray[np.float32]:
    """Return gains (3,) of exposure (by incident and reflected light) and white balance."""
    if not lit.any():
        return np.ones(3, np.float32)
    light = radiance[lit] / np.maximum(albedo[lit], MIN_ALBEDO)
    incident = float(np.median(light @ _LUMINANCE))
    reflected = float(np.exp(np.mean(np.log(radiance[lit] @ _LUMINANCE + 1e-4))))
    exposure = (0.64 / max(incident, 1e-4)) ** 0.6 * (0.25 / max(reflected, 1e-4)) ** 0.4
    bright = float(np.percentile(radiance[lit] @ _LUMINANCE, 92))
    exposure = min(exposure, 0.8 / max(bright, 1e-4))  # walls are not overexposed, windows are
    colour = np.median(light, axis=0) / max(incident, 1e-6)
    correction = np.maximum(colour, 0.1) ** -(1 - style.cast_left)
    gains = correction * np.array(style.balance) * exposure * 2**style.exposure_stops
    return gains.astype(np.float32)


def _lens(image: Image, style: CameraStyle) -> Image:
    """Return the image after vignetting, a faint glow of the highlights, and blur."""
    height, width = image.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    radius2 = ((x / (width - 1) - 0.5) ** 2 + (y / (height - 1) - 0.5) ** 2) * 2
    image = image * (1 - style.vignette * radius2)[..., None]
    image = np.minimum(image, 12.0)
    glow = cv2.GaussianBlur(np.maximum(image - 1, 0), (0, 0), width / 80)
    image = image + 0.02 * glow
    return cv2.GaussianBlur(image, (0, 0), max(style.blur_px * width / 640, 0.15))


def tone(image: Image, style: CameraStyle) -> Image:
    """Return values in [0, 1]: contrast about middle grey, then compression above the shoulder."""
    image = 0.4 * (image / 0.4) ** style.contrast
    start = style.shoulder
    over = np.maximum(image - start, 0) / (1 - start)
    rolled = start + (1 - start) * (1 - np.exp(-over))
    return np.where(image > start, rolled, image).astype(np.float32)


def encode_jpeg(image: NDArray[np.uint8], quality: int) -> bytes:
    """Return `image` (h, w, 3) uint8 sRGB as JPEG bytes at `quality` (1..95)."""
    buffer = io.BytesIO()
    PillowImage.fromarray(image).save(buffer, "JPEG", quality=quality, subsampling=2)
    return buffer.getvalue()
