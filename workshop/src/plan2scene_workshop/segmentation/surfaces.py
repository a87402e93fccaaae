"""Surfaces of photos tinted and made of other materials, label by label.

By hand: augmentation libraries change a picture as a whole, none one surface in its perspective.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from plan2scene.materials import random_material
from plan2scene.photos.labels.palette import CEILING, FLOOR, LABELS_AND_OPENINGS, OTHER
from plan2scene.seeds import generator
from plan2scene_workshop.rendering.palette import pattern

Array = np.ndarray
Rng = np.random.Generator
#: Side of the tiles in pixels.
SIDE = 128


@lru_cache(maxsize=1)
def surface_tiles() -> tuple[Array, ...]:
    """Return the tiles (128, 128, 3) uint8 sRGB that are laid over surfaces: always the same."""
    rng = generator(0, "augmentation tiles")
    tiles = [
        random_material(substance, int(rng.integers(2**62)), size_px=SIDE).albedo
        for substance in ("wood", "carpet", "carpet", "tile", "plaster")
        for _ in range(12)
    ]
    return (*tiles, *(pattern(rng, SIDE) for _ in range(24)))


def recolour_labels(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with each label's pixels tinted on their own, shading kept."""
    gains = np.ones((256, 3), np.float32)
    for label in range(len(LABELS_AND_OPENINGS)):
        if label != OTHER and rng.random() < 0.6:
            gains[label] = np.exp(rng.normal(0, 0.3) + rng.normal(0, 0.15, 3))
    field = cv2.GaussianBlur(gains[labels], (3, 3), 0)
    return np.asarray(cv2.multiply(image, field, dtype=cv2.CV_8U))


def retexture(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with one label's surface of another material, its shading kept.

    The tile lies in perspective on floors and ceilings, flat on walls and things.
    """
    found = [k for k in range(len(LABELS_AND_OPENINGS)) if (labels == k).mean() > 0.02]
    if not found:
        return image
    weights = np.array([2.0 if k in (FLOOR, CEILING) else 1.0 for k in found])
    label = int(rng.choice(found, p=weights / weights.sum()))
    inside = labels == label
    rows, columns = np.nonzero(inside)
    pixels = image[rows, columns].astype(np.float32)
    grey = pixels @ np.array([0.3, 0.6, 0.1], np.float32)
    tiles = surface_tiles()
    tile = tiles[int(rng.integers(len(tiles)))].astype(np.float32)
    shading = (grey + 8) / (np.median(grey) + 8)
    if label == OTHER:  # keeps what tells one thing from another
        shading = np.clip(shading, 0.15, 2)
    else:
        # Old material goes, broad light and shade stay.
        soft = cv2.blur(np.where(inside, cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), 0), (9, 9))
        weight = cv2.blur(inside.astype(np.float32), (9, 9))
        soft = soft / np.maximum(weight, 1e-3)
        smooth = (soft[rows, columns] + 8) / (np.median(grey) + 8)
        keep = rng.uniform(0, 0.5)
        shading = keep * shading + (1 - keep) * smooth
    u, v = _tile_places(label, rows, columns, labels.shape, rng)
    texel = tile[v.astype(np.int32) % SIDE, u.astype(np.int32) % SIDE]
    mean = tile.mean(axis=(0, 1))
    # Between the old average colour and the tile's own.
    own = rng.uniform(0.2, 1.0)
    texel = texel * (own + (1 - own) * pixels.mean(axis=0) / np.maximum(mean, 8))
    result = image.copy()
    result[rows, columns] = np.clip(texel * shading[:, None], 0, 255)
    return result


def _tile_places(
    label: int, rows: Array, columns: Array, size: tuple[int, int], rng: Rng
) -> tuple[Array, Array]:
    """Return the tile positions (n,), (n,) float32 in tile pixels, of photo pixels."""
    height, width = size
    scale = SIDE * np.exp(rng.uniform(-0.3, 1.6))
    angle = rng.choice([0.0, np.pi / 2, rng.uniform(0, np.pi)])
    x, y = (columns - width / 2) / width, rows / height
    if label in (FLOOR, CEILING):
        down = y - y.min() if label == FLOOR else y.max() - y
        depth = 1 / (down + rng.uniform(0.08, 0.4))
        x, y = x * depth, 0.6 * depth
    cos, sin = np.cos(angle), np.sin(angle)
    u, v = scale * (cos * x - sin * y), scale * (sin * x + cos * y)
    return u.astype(np.float32) + 4096, v.astype(np.float32) + 4096
