"""Line segments of a photo and of its label mask, with what each says about the camera."""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene.photos.camera.lines import border_lines, detect_segments
from plan2scene.photos.camera.vanishing import END_NOISE, Segments
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL

MAX_SEGMENTS = 320
#: Weight of a line along a border between wall and floor or ceiling, and of the photo's own lines
#: there; how far its ends may be off, pixels.
BORDER_WEIGHT = 2.0
BORDER_NOISE = 4.0
#: Neighbours of nearly the same direction among which a segment still counts in full; how far they
#: may be (share of the photo's width), and their direction (radians).
CROWD = 2.0
CROWD_REACH = 0.2
CROWD_ANGLE = np.radians(8.0)


def weighted_segments(grey: np.ndarray, labels: np.ndarray | None) -> Segments:
    """Return the segments of a photo and of its label mask with their weights.

    Long segments say more than short ones, borders between surfaces more than what lies on a
    floor (herringbone, rugs) or on other things, and the many parallel segments of a pattern
    (trellis wallpaper, diagonal tiles) less than as many single ones.
    """
    rows, columns = grey.shape
    lines = detect_segments(grey)[:MAX_SEGMENTS]
    weight = _label_weight(lines, labels, grey.shape)
    noise, level = np.full(len(lines), END_NOISE), np.zeros(len(lines), dtype=bool)
    if labels is not None:
        small = cv2.resize(labels, (columns, rows), interpolation=cv2.INTER_NEAREST)
        borders = border_lines(small, ((WALL, FLOOR), (WALL, CEILING)))
        lines = np.vstack([lines, borders])
        weight = np.concatenate([weight, np.full(len(borders), BORDER_WEIGHT)])
        noise = np.concatenate([noise, np.full(len(borders), BORDER_NOISE)])
        level = np.concatenate([level, np.ones(len(borders), dtype=bool)])
    length = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    weight = weight * np.sqrt(np.minimum(length / columns, 0.3) / 0.06)
    weight = weight / np.sqrt(1.0 + _neighbours(lines, columns) / CROWD)
    return Segments(lines, ((columns - 1) / 2, (rows - 1) / 2), weight, noise, level)


def _neighbours(lines: np.ndarray, columns: int) -> np.ndarray:
    """Return how many other segments are near and nearly parallel, (n,) float64."""
    middle = (lines[:, :2] + lines[:, 2:]) / (2.0 * columns)
    along = lines[:, 2:] - lines[:, :2]
    angle = np.arctan2(along[:, 1], along[:, 0])
    turn = np.abs((angle[:, None] - angle + np.pi / 2) % np.pi - np.pi / 2) / CROWD_ANGLE
    apart = ((middle[:, None] - middle) ** 2).sum(axis=-1) / CROWD_REACH**2
    return np.asarray(np.exp(-0.5 * (apart + turn**2)).sum(axis=1) - 1.0)


def _label_weight(
    lines: np.ndarray, labels: np.ndarray | None, shape: tuple[int, int]
) -> np.ndarray:
    """Return each segment's weight.

    `BORDER_WEIGHT` between wall, floor and ceiling, 1 on walls, 0.5 on floors and other things.
    """
    if labels is None or not len(lines):
        return np.ones(len(lines))
    rows, columns = shape
    steps = np.linspace(0.1, 0.9, 5)[:, None]
    start, end = lines[:, :2], lines[:, 2:]
    across = (end - start)[:, ::-1] * np.array([-1.0, 1.0])
    across *= 0.008 * columns / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    other, floor = np.ones(len(lines), dtype=bool), np.ones(len(lines), dtype=bool)
    sides = []
    for side in (-1.0, 1.0):
        points = (start + side * across)[None] + steps[..., None] * (end - start)[None]
        x = np.clip(points[..., 0] / columns * labels.shape[1], 0, labels.shape[1] - 1)
        y = np.clip(points[..., 1] / rows * labels.shape[0], 0, labels.shape[0] - 1)
        seen = labels[y.astype(int), x.astype(int)]
        sides.append(seen)
        other &= np.isin(seen, (OTHER, IGNORE)).mean(axis=0) > 0.5
        floor &= (seen == FLOOR).mean(axis=0) > 0.5
    border = (sides[0] != sides[1]) & (np.isin(sides, (FLOOR, WALL, CEILING)).all(axis=0))
    weight = np.where(other | floor, 0.5, 1.0)
    return np.where(border.mean(axis=0) > 0.5, BORDER_WEIGHT, weight)
