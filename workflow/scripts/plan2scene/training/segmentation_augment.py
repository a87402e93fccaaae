"""Augmentation: what makes a network trained on rendered rooms stand real photos.

Rendered rooms look alike in ways that real ones do not. So shape (crop, scale, turn, mirror),
what stands in the room (things of other photos, plain patches), what surfaces look like (each
label recoloured on its own), light and camera are all varied widely.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from plan2scene.photos.masks import IGNORE, LABELS, OTHER
from plan2scene.training.segmentation_data import LabelledPhoto

Array = np.ndarray


def training_sample(
    photos: Sequence[LabelledPhoto], index: int, size: tuple[int, int], rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return an augmented view of ``photos[index]``: (h, w, 3) uint8 sRGB, (h, w) uint8 labels.

    Parameters
    ----------
    size : (height, width)
        Of the view.
    rng : numpy Generator
        All choices come from it.
    """
    image, labels = random_view(photos[index], size, rng)
    if rng.random() < 0.35:
        image = recolour_labels(image, labels, rng)
    if rng.random() < 0.35:
        donor = random_view(photos[int(rng.integers(len(photos)))], size, rng)
        image, labels = paste_thing(image, labels, *donor, rng)
    if rng.random() < 0.25:
        image, labels = paste_patches(image, labels, rng)
    return camera_effects(image, rng), labels


def random_view(
    photo: LabelledPhoto, size: tuple[int, int], rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return a random crop, scale, turn (up to 6 deg) and mirror image; outside is ignore."""
    height, width = size
    h, w = photo.labels.shape
    # From a little more than the whole photo to half of its side.
    zoom = max(height / h, width / w) * float(np.exp(rng.uniform(-0.1, 0.65)))
    stretch = float(np.exp(rng.normal(0, 0.08)))
    angle = np.deg2rad(np.clip(rng.normal(0, 2.5), -6, 6))
    cos, sin = np.cos(angle), np.sin(angle)
    linear = zoom * np.array([[cos * stretch, -sin], [sin * stretch, cos]])
    if rng.random() < 0.5:
        linear[:, 0] *= -1
    # The view's centre looks at a point that keeps most of the view inside the photo.
    slack = np.maximum(0, np.array([w, h]) - np.array([width, height]) / zoom)
    seen = np.array([w, h]) / 2 + slack * rng.uniform(-0.5, 0.5, 2)
    matrix = np.column_stack([linear, np.array([width, height]) / 2 - linear @ seen])
    image = cv2.warpAffine(
        photo.image, matrix, (width, height), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
    )
    labels = cv2.warpAffine(
        photo.labels,
        matrix,
        (width, height),
        flags=cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=IGNORE,
    )
    return image, labels


def recolour_labels(image: Array, labels: Array, rng: np.random.Generator) -> Array:
    """Return the photo with each label's pixels tinted on their own, shading kept."""
    gains = np.ones((256, 3), np.float32)
    for label in range(len(LABELS)):
        if label != OTHER and rng.random() < 0.6:
            gains[label] = np.exp(rng.normal(0, 0.25) + rng.normal(0, 0.12, 3))
    field = cv2.GaussianBlur(gains[labels], (3, 3), 0)
    return np.clip(image * field, 0, 255).astype(np.uint8)


def paste_thing(
    image: Array, labels: Array, donor: Array, donor_labels: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return the photo with one connected thing of another photo in front, labelled other."""
    count, parts, stats, _ = cv2.connectedComponentsWithStats((donor_labels == OTHER).astype("u1"))
    area = stats[1:, cv2.CC_STAT_AREA] / labels.size
    fitting = np.flatnonzero((area > 0.004) & (area < 0.35)) + 1
    if count < 2 or not len(fitting):
        return image, labels
    mask = parts == rng.choice(fitting)
    shift = np.array([[1, 0, rng.normal(0, 0.2) * mask.shape[1]], [0, 1, 0]], np.float32)
    size = (mask.shape[1], mask.shape[0])
    mask = cv2.warpAffine(mask.astype("u1"), shift, size, flags=cv2.INTER_NEAREST) > 0
    moved = cv2.warpAffine(donor, shift, size)
    gain = np.exp(rng.normal(0, 0.2, 3))
    image, labels = image.copy(), labels.copy()
    image[mask] = np.clip(moved[mask] * gain, 0, 255)
    labels[mask] = OTHER
    return image, labels


def paste_patches(image: Array, labels: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the photo with up to three flat or striped shapes in front, labelled other."""
    image, labels = image.copy(), labels.copy()
    height, width = labels.shape
    for _ in range(int(rng.integers(1, 4))):
        mask = np.zeros_like(labels)
        centre = (int(rng.uniform(0, width)), int(rng.uniform(0, height)))
        axes = (int(width * rng.uniform(0.02, 0.16)), int(height * rng.uniform(0.03, 0.2)))
        if rng.random() < 0.3:
            cv2.ellipse(mask, centre, axes, rng.uniform(0, 180), 0, 360, 1, -1)
        else:
            turn = rng.choice([0.0, rng.normal(0, 15)])
            box = cv2.boxPoints((centre, (2 * axes[0], 2 * axes[1]), turn))
            skew = rng.normal(0, 0.12, (4, 2)) * axes
            cv2.fillConvexPoly(mask, (box + skew).astype(np.int32), 1)
        wave = np.sin(np.arange(width) * rng.uniform(0.02, 1.2)) * rng.uniform(0, 30)
        slope = np.linspace(-1, 1, height)[:, None] * rng.normal(0, 30)
        fill = rng.uniform(10, 245, 3) + (wave[None, :] + slope)[..., None]
        inside = mask > 0
        image[inside] = np.clip(fill[inside], 0, 255)
        labels[inside] = OTHER
    return image, labels


def camera_effects(image: Array, rng: np.random.Generator) -> Array:
    """Return the photo as another camera in another light might have taken it (uint8)."""
    x = _light(image.astype(np.float32) / 255, rng)
    if rng.random() < 0.25:
        x = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.4, 1.6))
    if rng.random() < 0.2:
        soft = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.7, 2.0))
        x = x + rng.uniform(0.3, 1.2) * (x - soft)
    if rng.random() < 0.5:
        x = x + rng.normal(0, rng.uniform(0.003, 0.035), x.shape).astype(np.float32)
    result = np.clip(x * 255, 0, 255).astype(np.uint8)
    if rng.random() < 0.4:
        quality = int(rng.integers(25, 92))
        encoded = cv2.imencode(".jpg", result, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        result = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)
    return result


def _light(x: Array, rng: np.random.Generator) -> Array:
    """Return a float image under other exposure, white balance, contrast and uneven light."""
    height, width = x.shape[:2]
    if rng.random() < 0.4:
        coarse = rng.normal(0, 0.22, (3, 4)).astype(np.float32)
        field = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
        x = x * np.exp(field)[..., None]
    x = x * np.exp(rng.normal(0, 0.2) + rng.normal(0, 0.06, 3)).astype(np.float32)
    grey = x.mean(axis=2, keepdims=True)
    saturation = 0.0 if rng.random() < 0.05 else rng.uniform(0.3, 1.6)
    x = np.clip(grey + saturation * (x - grey), 0, None)
    x = x ** np.float32(np.exp(rng.normal(0, 0.2)))
    middle = rng.uniform(0.3, 0.6)
    x = middle + rng.uniform(0.75, 1.3) * (x - middle)
    return np.clip(x, 0, 1).astype(np.float32)
