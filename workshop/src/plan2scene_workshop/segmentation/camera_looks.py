"""Augmentation of light and camera, so that a network trained on renderings works on photos.

It uses OpenCV on the processor. That is ten times faster there than libraries that augment
tensors, which took longer than the network's own step.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

Array = np.ndarray
Rng = np.random.Generator
_GREY = np.array([0.299, 0.587, 0.114], np.float32)


def lamp(image: Array, rng: Rng) -> Array:
    """Return an image (h, w, 3) float32 in [0, 1] under a gradient or a broad spot of light."""
    height, width = image.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j].astype(np.float32)
    if rng.random() < 0.5:
        angle = rng.uniform(0, 2 * np.pi)
        field = np.cos(angle) * x + np.sin(angle) * y
    else:
        left, top, spread = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.3, 1.2)
        field = 2 * np.exp(-((x - left) ** 2 + (y - top) ** 2) / (2 * spread**2)) - 0.5
    tint = np.exp(rng.normal(0, 0.1, 3)).astype(np.float32)
    return image * np.exp(rng.uniform(-0.7, 0.7) * field)[..., None] ** tint


def burnt(image: Array, rng: Rng) -> Array:
    """Return an image with an overexposed spot of light; the rest is up to half as bright."""
    height, width = image.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j].astype(np.float32)
    left, top, spread = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.1, 0.5)
    spot = np.exp(-((x - left) ** 2 + (y - top) ** 2) / (2 * spread**2))
    tint = np.exp(rng.normal(0, 0.15, 3)).astype(np.float32)
    gain = rng.uniform(0.5, 1) + rng.uniform(1, 5) * spot
    return image * gain[..., None].astype(np.float32) ** tint


def random_filter(image: Array, rng: Rng) -> Array:
    """Return a mix of an image and a random linear filter of it.

    Shapes stay; textures and colours change, so that the network does not rely on them. RandConv,
    Xu et al. 2021, https://arxiv.org/abs/2007.13003.
    """
    side = int(rng.choice([1, 3, 5, 7]))
    kernels = rng.standard_normal((3, 3, side, side), dtype=np.float32) / (side * np.sqrt(3))
    planes = [np.ascontiguousarray(image[..., k]) - np.float32(0.5) for k in range(3)]
    found = np.stack(
        [sum(cv2.filter2D(p, -1, k) for p, k in zip(planes, row, strict=True)) for row in kernels],
        axis=2,
    )
    share = np.float32(rng.uniform(0.1, 0.8))
    return np.asarray((1 - share) * image + share * (found * np.float32(1.2) + np.float32(0.5)))


def balance(image: Array, rng: Rng) -> Array:
    """Return an image with another white balance: cold or warm, and slightly green or pink."""
    warm, green = rng.normal(0, 0.16), rng.normal(0, 0.05)
    gains = np.exp(np.array([warm, green, -warm], np.float32))
    return image * (gains / (gains @ _GREY))


def tone(image: Array, rng: Rng) -> Array:
    """Return an image with another exposure and tone curve (black and white points, gamma, bend).

    Phones lift shadows and compress highlights. Clipped light and dark parts stay clipped.
    """
    x = np.linspace(0, 1, 1024, dtype=np.float32)
    black, white = rng.uniform(-0.08, 0.12), rng.uniform(0.7, 1.35)
    if rng.random() < 0.3:  # underexposed
        white *= rng.uniform(1.2, 2.8)
    y = np.clip((x - black) / (white - black), 0, 1) ** np.exp(rng.normal(0.05, 0.35))
    y = y + rng.uniform(-0.4, 0.4) * np.sin(2 * np.pi * y) / (2 * np.pi)
    return y[(np.clip(image, 0, 1) * 1023).astype(np.int32)]


def saturation(image: Array, rng: Rng) -> Array:
    """Return an image with stronger or paler colours, sometimes grey."""
    share = 0.0 if rng.random() < 0.12 else rng.uniform(0.3, 1.6)
    grey = (image @ _GREY)[..., None]
    return np.asarray(grey + np.float32(share) * (image - grey))


def blur(image: Array, rng: Rng) -> Array:
    """Return an image with focus blur or motion blur."""
    if rng.random() < 0.75:
        return cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 1.7))
    length = int(rng.integers(3, 8))
    kernel = np.zeros((length, length), np.float32)
    kernel[length // 2] = 1 / length
    turn = cv2.getRotationMatrix2D(((length - 1) / 2, (length - 1) / 2), rng.uniform(0, 180), 1)
    kernel = cv2.warpAffine(kernel, turn, (length, length))
    return cv2.filter2D(image, -1, kernel / kernel.sum())


def sharpen(image: Array, rng: Rng) -> Array:
    """Return an image with the halos that cameras draw along edges."""
    soft = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.6, 2.0))
    return image + np.float32(rng.uniform(0.3, 1.5)) * (image - soft)


def noise(image: Array, rng: Rng) -> Array:
    """Return an image with sensor noise, fine or coarse, stronger in dark parts."""
    height, width = image.shape[:2]
    grain = 1 if rng.random() < 0.6 else 2
    size = (-(-height // grain), -(-width // grain), 3)
    field = rng.standard_normal(size, dtype=np.float32)
    if grain > 1:
        field = cv2.resize(field, (width, height), interpolation=cv2.INTER_LINEAR)
    return image + field * (rng.uniform(0.004, 0.05) * (1.2 - np.clip(image, 0, 1)))


def compress(image: Array, rng: Rng) -> Array:
    """Return an image after JPEG compression of random quality."""
    quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(25, 92))]
    _, data = cv2.imencode(".jpg", (np.clip(image, 0, 1) * 255).astype(np.uint8), quality)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.float32) / 255


#: The changes to a view, in this order, each with its probability.
LOOKS: tuple[tuple[Callable[[Array, Rng], Array], float], ...] = (
    (random_filter, 0.2),
    (lamp, 0.35),
    (burnt, 0.12),
    (balance, 0.6),
    (blur, 0.3),
    (tone, 0.75),
    (saturation, 0.5),
    (noise, 0.5),
    (sharpen, 0.2),
    (compress, 0.4),
)


def other_camera(image: Array, rng: Rng) -> Array:
    """Return an image (h, w, 3) uint8 sRGB as another camera might have taken it."""
    changed = image.astype(np.float32) / 255
    for look, share in LOOKS:
        if rng.random() < share:
            changed = look(changed, rng)
    return (np.clip(changed, 0, 1) * 255 + 0.5).astype(np.uint8)
