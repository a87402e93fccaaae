"""Degradation of drawings as by scanning, printing, photographing and sending them."""

from __future__ import annotations

import cv2
import numpy as np


def bend(
    image: np.ndarray,
    labels: np.ndarray,
    move: np.ndarray,
    size: tuple[int, int],
    rng: np.random.Generator,
    *,
    wobble: float = 0.0,
    beyond: tuple[int, int, int] = (255, 255, 255),
) -> tuple[np.ndarray, np.ndarray]:
    """Return a picture (h, w, 3) and its labels (h, w), warped to `size` (h, w).

    `move` is the homography from pixels of the drawing to pixels of the view. `wobble` is the
    standard deviation in pixels of smooth random shifts, like those of a drawing hand.
    """
    h, w = size
    inverse = np.linalg.inv(move)
    columns, rows = np.meshgrid(np.arange(w, dtype=np.float64), np.arange(h, dtype=np.float64))
    there = np.stack([columns, rows, np.ones_like(rows)], -1) @ inverse.T
    x, y = there[..., 0] / there[..., 2], there[..., 1] / there[..., 2]
    if wobble:
        for field in (x, y):
            coarse = rng.normal(0, wobble, (max(2, h // 48), max(2, w // 48))).astype(np.float32)
            field += cv2.resize(coarse, (w, h), interpolation=cv2.INTER_CUBIC)
    x, y = x.astype(np.float32), y.astype(np.float32)
    seen = cv2.remap(
        image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=beyond
    )
    told = cv2.remap(labels, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
    return seen, told


def homography(
    size: tuple[int, int], rng: np.random.Generator, *, turn: float, keystone: float
) -> np.ndarray:
    """Return the homography (3, 3) of a rotation by `turn` degrees about the middle and a keystone.

    `keystone` is the largest shift of a corner as a share of the size.
    """
    h, w = size
    angle = np.deg2rad(turn)
    c, s = np.cos(angle), np.sin(angle)
    cx, cy = w / 2, h / 2
    rotation = np.array(
        [[c, -s, cx - c * cx + s * cy], [s, c, cy - s * cx - c * cy], [0, 0, 1]], np.float64
    )
    corners = np.array([(0, 0), (w, 0), (w, h), (0, h)], np.float32)
    moved = corners + rng.uniform(-keystone, keystone, (4, 2)) * (w, h)
    tilt = cv2.getPerspectiveTransform(corners, moved.astype(np.float32))
    return tilt @ rotation


def worn(image: np.ndarray, rng: np.random.Generator, *, photographed: bool) -> np.ndarray:
    """Return a picture (h, w, 3) uint8, degraded as by a scanner, printer, camera or messenger."""
    picture: np.ndarray = image.astype(np.float32)
    h, w = picture.shape[:2]
    if photographed:
        picture *= _shade(h, w, rng)[..., None]
        picture *= np.array(rng.uniform(0.85, 1.05, 3) * rng.uniform(0.6, 1.05), np.float32)
    if rng.random() < (0.9 if photographed else 0.25):
        sigma = float(rng.uniform(0.3, 1.1))
        picture = cv2.GaussianBlur(picture, (0, 0), sigma)
    if rng.random() < (0.8 if photographed else 0.25):
        picture += rng.normal(0, float(rng.uniform(1, 9)), (h, w, 1)).astype(np.float32)
    if rng.random() < 0.15:
        spots = rng.random((h, w)) < float(rng.uniform(0.0002, 0.003))
        picture[spots] = float(rng.uniform(0, 160))
    if rng.random() < 0.2:
        low, high = float(rng.uniform(-30, 50)), float(rng.uniform(200, 280))
        picture = low + picture * (high - low) / 255
    if rng.random() < 0.25:
        picture = np.repeat(picture.mean(2, keepdims=True), 3, axis=2)
    if rng.random() < 0.06:
        edge = float(rng.uniform(90, 200))
        picture = np.where(picture.mean(2, keepdims=True) > edge, 255.0, 0.0) * np.ones(3)
    found = picture.clip(0, 255).astype(np.uint8)
    if rng.random() < 0.5:
        quality = int(rng.integers(25, 95))
        _, data = cv2.imencode(".jpg", found, [cv2.IMWRITE_JPEG_QUALITY, quality])
        found = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))
    return found


def _shade(h: int, w: int, rng: np.random.Generator) -> np.ndarray:
    """Return uneven light and a fold on a photographed sheet as factors (h, w) float32 near 1."""
    coarse = rng.uniform(0.65, 1.05, (3, 3)).astype(np.float32)
    shade = cv2.resize(coarse, (w, h), interpolation=cv2.INTER_CUBIC)
    if rng.random() < 0.3:
        direction = rng.normal(size=2)
        direction /= np.linalg.norm(direction)
        columns, rows = np.meshgrid(np.arange(w), np.arange(h))
        offset = columns * direction[0] + rows * direction[1]
        fold = float(rng.uniform(offset.min(), offset.max()))
        shade = shade * np.where(offset > fold, float(rng.uniform(0.85, 1.0)), 1.0)
    fine = rng.normal(0, 0.012, (max(2, h // 2), max(2, w // 2))).astype(np.float32)
    return (shade + cv2.resize(fine, (w, h))).astype(np.float32)
