"""What light and camera do to a photo, for augmentation: nothing here moves a label."""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, LABELS, OTHER
from plan2scene_workshop.segmentation.patterns import SIDE, surface_tiles

Array = np.ndarray
Rng = np.random.Generator


def recolour_labels(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with each label's pixels tinted on their own, shading kept."""
    gains = np.ones((256, 3), np.float32)
    for label in range(len(LABELS)):
        if label != OTHER and rng.random() < 0.6:
            gains[label] = np.exp(rng.normal(0, 0.3) + rng.normal(0, 0.15, 3))
    field = cv2.GaussianBlur(gains[labels], (3, 3), 0)
    return np.asarray(cv2.multiply(image, field, dtype=cv2.CV_8U))


def retexture(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with one label's surface of another material, its shading kept.

    The tile lies in perspective on floors and ceilings, flat on walls and things.
    """
    found = [k for k in range(len(LABELS)) if (labels == k).mean() > 0.02]
    if not found:
        return image
    weights = np.array([2.0 if k == FLOOR else 1.0 for k in found])
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


def sun_and_shade(image: Array, labels: Array, rng: Rng) -> Array:
    """Return the photo with patches of sun, or a shadow, with hard or soft edges."""
    height, width = labels.shape
    field = np.zeros((height, width), np.float32)
    corner = rng.uniform(-0.2, 1.0, 2) * [width, height]
    across, along = rng.normal(0, 0.22, (2, 2)) * [width, height]
    panes = int(rng.integers(1, 5))
    gap = rng.uniform(0.05, 0.3)
    for k in range(panes):
        origin = corner + k * across
        quad = [origin, origin + (1 - gap) * across]
        quad += [quad[1] + along, quad[0] + along]
        cv2.fillConvexPoly(field, np.array(quad).astype(np.int32), 1.0)
    if rng.random() < 0.5:
        field = cv2.GaussianBlur(field, (0, 0), rng.uniform(0.5, 5))
    if rng.random() < 0.5:  # one surface only
        kinds = np.unique(labels[labels != IGNORE])
        if len(kinds):
            field = field * (labels == rng.choice(kinds))
    sunny = rng.random() < 0.65
    gain = np.exp(rng.uniform(0.25, 1.3)) if sunny else np.exp(rng.uniform(-1.2, -0.2))
    tint = np.exp(rng.normal(0, 0.05, 3)) * gain
    factor = 1 + field[..., None] * (tint - 1).astype(np.float32)
    return np.asarray(cv2.multiply(image, factor.astype(np.float32), dtype=cv2.CV_8U))


def camera_effects(image: Array, rng: Rng) -> Array:
    """Return the photo as another camera in another light might have taken it (uint8)."""
    x = _light(image.astype(np.float32) * np.float32(1 / 255), rng)
    blur = rng.random()
    if blur < 0.25:
        x = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.4, 1.6))
    elif blur < 0.33:
        x = cv2.filter2D(x, -1, _streak(rng))
    if rng.random() < 0.2:
        soft = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.7, 2.0))
        x = x + np.float32(rng.uniform(0.3, 1.2)) * (x - soft)
    height, width = x.shape[:2]
    if rng.random() < 0.15:
        shrink = rng.uniform(0.3, 0.8)
        small = (max(8, int(width * shrink)), max(8, int(height * shrink)))
        x = cv2.resize(x, small, interpolation=cv2.INTER_AREA)
        x = cv2.resize(x, (width, height), interpolation=cv2.INTER_LINEAR)
    if rng.random() < 0.5:
        noise = rng.standard_normal(x.shape, dtype=np.float32)
        x = x + noise * np.float32(rng.uniform(0.003, 0.035))
    result = np.clip(x * 255, 0, 255).astype(np.uint8)
    if rng.random() < 0.4:
        quality = int(rng.integers(20, 92))
        encoded = cv2.imencode(".jpg", result, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        result = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)
    return np.asarray(result)


def _streak(rng: Rng) -> Array:
    """Return the (n, n) kernel of a small motion of the camera."""
    side = 2 * int(rng.integers(1, 4)) + 1
    kernel = np.zeros((side, side), np.float32)
    way = rng.normal(0, 1, 2)
    way = way / np.abs(way).max() * (side // 2)
    start, end = side // 2 - way, side // 2 + way
    cv2.line(kernel, tuple(np.rint(start).astype(int)), tuple(np.rint(end).astype(int)), 1.0)
    return np.asarray(kernel / kernel.sum())


def _light(x: Array, rng: Rng) -> Array:
    """Return a float image under other exposure, white balance, contrast and uneven light."""
    height, width = x.shape[:2]
    if rng.random() < 0.4:
        colours = 3 if rng.random() < 0.4 else 1  # lamps of mixed colour temperature
        coarse = rng.normal(0, 0.28, (3, 4, 1)) + rng.normal(0, 0.1, (3, 4, colours))
        field = cv2.resize(
            coarse.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR
        )
        x = x * cv2.exp(field).reshape(height, width, -1)
    if rng.random() < 0.25:
        dy, dx = np.linspace(-1, 1, height)[:, None], np.linspace(-1, 1, width)
        x = x * (1 - rng.uniform(0.1, 0.55) * (dy**2 + dx**2) / 2).astype(np.float32)[..., None]
    cast = rng.choice([0.06, 0.2], p=[0.8, 0.2])
    x = x * np.exp(rng.normal(0, 0.25) + rng.normal(0, cast, 3)).astype(np.float32)
    grey = cv2.transform(x, np.full((1, 3), 1 / 3, np.float32))[..., None]
    saturation = np.float32(0.0 if rng.random() < 0.06 else rng.uniform(0.3, 1.6))
    x = np.clip(grey + saturation * (x - grey), 0, None)
    x = cv2.pow(x, float(np.exp(rng.normal(0, 0.28))))
    middle = np.float32(rng.uniform(0.3, 0.6))
    x = middle + np.float32(rng.uniform(0.65, 1.4)) * (x - middle)
    if rng.random() < 0.2:
        x = _burnt_out(x, rng)
    return np.asarray(np.clip(x, 0, 1), np.float32)


def _burnt_out(x: Array, rng: Rng) -> Array:
    """Return the image with its brightest places blown out, with glare around them."""
    grey = x.max(axis=2)
    limit = max(float(np.quantile(grey[::4, ::4], rng.uniform(0.8, 0.98))), 0.45)
    bright = np.clip((grey - limit) * 8, 0, 1)
    small = cv2.resize(bright, (max(1, x.shape[1] // 4), max(1, x.shape[0] // 4)))
    glare = cv2.GaussianBlur(small, (0, 0), rng.uniform(1, 6))
    glare = cv2.resize(glare, (x.shape[1], x.shape[0]))
    added = np.float32(rng.uniform(0.5, 1)) * bright + np.float32(rng.uniform(0.1, 0.8)) * glare
    return np.asarray(x + added[..., None])
