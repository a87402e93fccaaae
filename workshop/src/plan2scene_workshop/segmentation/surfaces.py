"""Augmentation that tints surfaces of photos or replaces their materials, label by label.

Augmentation libraries change only whole pictures; none changes one surface in its perspective.
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
#: Extra labels for pixels of other whose normal is known: horizontal tops (beds, tables) and
#: vertical fronts (cupboards).
TOP, FRONT = len(LABELS_AND_OPENINGS), len(LABELS_AND_OPENINGS) + 1
#: Relative probability that a label gets another material (others: 1). Floors, ceilings and what
#: is easily mistaken for them are chosen most often.
WEIGHTS = {FLOOR: 2.0, CEILING: 2.0, TOP: 2.0, FRONT: 1.5}


@lru_cache(maxsize=1)
def surface_tiles() -> tuple[Array, ...]:
    """Return the fixed set of tiles (128, 128, 3) uint8 sRGB that are laid over surfaces."""
    rng = generator(0, "augmentation tiles")
    tiles = [
        random_material(substance, int(rng.integers(2**62)), size_px=SIDE).albedo
        for substance in ("wood", "carpet", "carpet", "tile", "plaster")
        for _ in range(12)
    ]
    return (*tiles, *(pattern(rng, SIDE) for _ in range(24)))


def recolour_labels(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with the pixels of each label tinted separately; shading is kept."""
    gains = np.ones((256, 3), np.float32)
    for label in range(len(LABELS_AND_OPENINGS)):
        if label != OTHER and rng.random() < 0.6:
            gains[label] = np.exp(rng.normal(0, 0.3) + rng.normal(0, 0.15, 3))
    field = cv2.GaussianBlur(gains[labels], (3, 3), 0)
    return np.asarray(cv2.multiply(image, field, dtype=cv2.CV_8U))


def faced(labels: Array, geometry: Array | None) -> Array:
    """Return labels (h, w) uint8 in which other is `TOP` or `FRONT` where its normal says so.

    `geometry` (h, w, 4) is normals in camera axes, y down, and depth; cameras look nearly level.
    Things that lie on the floor (rugs) stay other: only their material distinguishes them from it.
    """
    if geometry is None:
        return labels
    upright, known = geometry[..., 1], np.abs(geometry[..., :3]).max(axis=2) > 0.5
    other = (labels == OTHER) & known
    top = other & (upright < -0.75) & ~_on_floor(labels, geometry[..., 3])
    found = np.where(top, TOP, labels)
    return np.where(other & (np.abs(upright) < 0.3), FRONT, found).astype(np.uint8)


def _on_floor(labels: Array, depth: Array) -> Array:
    """Return which pixels (h, w) lie on the floor's plane: inverse depth is linear on a plane."""
    rows, columns = np.nonzero((labels == FLOOR) & (depth > 0))
    if len(rows) < 50:
        return np.zeros(labels.shape, bool)
    step = len(rows) // 500 + 1
    rows, columns = rows[::step], columns[::step]
    places = np.stack([rows, columns, np.ones(len(rows))], axis=1)
    plane = np.linalg.lstsq(places, 1 / depth[rows, columns], rcond=None)[0]
    y, x = np.indices(labels.shape)
    inverse = plane[0] * y + plane[1] * x + plane[2]
    return np.asarray(np.abs(depth * inverse - 1) < 0.06)


def retexture(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with another material on the surface of one label; shading is kept.

    The tile lies in perspective on floors, ceilings and tops, flat on walls and things. `labels`
    are the result of :func:`faced`.
    """
    found = [k for k in range(FRONT + 1) if (labels == k).mean() > 0.02]
    if not found:
        return image
    weights = np.array([WEIGHTS.get(k, 1.0) for k in found])
    label = int(rng.choice(found, p=weights / weights.sum()))
    inside = labels == label
    rows, columns = np.nonzero(inside)
    pixels = image[rows, columns].astype(np.float32)
    grey = pixels @ np.array([0.3, 0.6, 0.1], np.float32)
    tiles = surface_tiles()
    tile = tiles[int(rng.integers(len(tiles)))].astype(np.float32)
    shading = (grey + 8) / (np.median(grey) + 8)
    if label == OTHER:  # full shading: it separates the things
        shading = np.clip(shading, 0.15, 2)
    else:
        # Remove the old material, but keep broad light and shade.
        soft = cv2.blur(np.where(inside, cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), 0), (9, 9))
        weight = cv2.blur(inside.astype(np.float32), (9, 9))
        soft = soft / np.maximum(weight, 1e-3)
        smooth = (soft[rows, columns] + 8) / (np.median(grey) + 8)
        keep = rng.uniform(0, 0.5)
        shading = keep * shading + (1 - keep) * smooth
    u, v = _tile_places(label, rows, columns, labels.shape, rng)
    texel = tile[v.astype(np.int32) % SIDE, u.astype(np.int32) % SIDE]
    mean = tile.mean(axis=(0, 1))
    # A colour between the old average colour and the tile's own.
    own = rng.uniform(0.2, 1.0)
    texel = texel * (own + (1 - own) * pixels.mean(axis=0) / np.maximum(mean, 8))
    result = image.copy()
    result[rows, columns] = np.clip(texel * shading[:, None], 0, 255)
    return result


def _tile_places(
    label: int, rows: Array, columns: Array, size: tuple[int, int], rng: Rng
) -> tuple[Array, Array]:
    """Return where photo pixels lie on the tile: (n,), (n,) float32 in tile pixels."""
    height, width = size
    scale = SIDE * np.exp(rng.uniform(-0.3, 1.6))
    angle = rng.choice([0.0, np.pi / 2, rng.uniform(0, np.pi)])
    x, y = (columns - width / 2) / width, rows / height
    if label in (FLOOR, CEILING, TOP):
        down = y.max() - y if label == CEILING else y - y.min()
        depth = 1 / (down + rng.uniform(0.08, 0.4))
        x, y = x * depth, 0.6 * depth
    cos, sin = np.cos(angle), np.sin(angle)
    u, v = scale * (cos * x - sin * y), scale * (sin * x + cos * y)
    return u.astype(np.float32) + 4096, v.astype(np.float32) + 4096
