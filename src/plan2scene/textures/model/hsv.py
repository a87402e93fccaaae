"""Differentiable colour conversions: torch counterparts of :mod:`plan2scene.colour`.

Images are ``(n, 3, h, w) float32``; RGB, saturation, value and hue in [0, 1].
"""

from __future__ import annotations

import numpy as np
import torch
from PIL import Image


def rgb_to_hsv(rgb: torch.Tensor) -> torch.Tensor:
    """Return HSV (n, 3, h, w) of RGB (n, 3, h, w); the hue of greys is 0."""
    red, green, blue = rgb.unbind(1)
    value, _ = rgb.max(dim=1)
    chroma = value - rgb.min(dim=1).values
    safe = torch.where(chroma > 0, chroma, torch.ones_like(chroma))
    hue = torch.where(
        value == red,
        (green - blue) / safe,
        torch.where(value == green, 2.0 + (blue - red) / safe, 4.0 + (red - green) / safe),
    )
    hue = torch.where(chroma > 0, torch.remainder(hue / 6.0, 1.0), torch.zeros_like(hue))
    bright = torch.where(value > 0, value, torch.ones_like(value))
    return torch.stack([hue, chroma / bright, value], dim=1)


def rgb_to_hsv_8_bit(rgb: torch.Tensor) -> torch.Tensor:
    """As :func:`rgb_to_hsv`, but quantised to Pillow's 8 bits, like the reference; no gradients."""
    images = (rgb.detach() * 255.0).round().to(torch.uint8).permute(0, 2, 3, 1).cpu().numpy()
    cut = np.stack([np.array(Image.fromarray(image).convert("HSV")) for image in images])
    return torch.from_numpy(cut).permute(0, 3, 1, 2).to(rgb) / 255.0


def hsv_to_rgb(hsv: torch.Tensor) -> torch.Tensor:
    """Return RGB (n, 3, h, w) of HSV (n, 3, h, w); hue modulo 1; gradients reach all channels."""
    hue, saturation, value = hsv[:, 0:1], hsv[:, 1:2], hsv[:, 2:3]
    offset = torch.tensor([5.0, 3.0, 1.0], dtype=hsv.dtype, device=hsv.device).view(1, 3, 1, 1)
    sector = torch.remainder(offset + hue * 6.0, 6.0)
    ramp = torch.minimum(sector, 4.0 - sector).clamp(0.0, 1.0)
    return value - value * saturation * ramp


def median_colour(rgb: torch.Tensor) -> torch.Tensor:
    """Return the per-channel median (n, 3) of (n, 3, h, w); the lower one of two middle values."""
    return rgb.flatten(2).median(dim=2).values


def wrap_hue(delta: torch.Tensor) -> torch.Tensor:
    """Return delta-HSV (n, 3, h, w) with its hue difference wrapped to [-0.5, 0.5]."""
    hue = delta[:, 0:1]
    return torch.cat([hue - hue.round(), delta[:, 1:]], dim=1)
