"""Random views of a photo: crop, scale, turn, tilt, lens distortion; one warp for all its maps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from plan2scene.photos.labels.palette import IGNORE

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Warp:
    """How pixels of a view lie in a photo.

    Attributes
    ----------
    matrix : (3, 3) float64
        Takes photo pixels (x, y, 1) to view pixels, without the distortion.
    distortion : float
        Radial: a view pixel at distance r from the middle (1 at the corners) looks at distance
        ``r (1 + distortion r^2)``.
    size : (height, width)
        Of the view.
    """

    matrix: Array
    distortion: float
    size: tuple[int, int]

    @cached_property
    def grid(self) -> tuple[Array, Array]:
        """Photo columns and rows (h, w) float32 that the view's pixels look at."""
        height, width = self.size
        x = np.arange(width, dtype=np.float32)[None, :] - np.float32((width - 1) / 2)
        y = np.arange(height, dtype=np.float32)[:, None] - np.float32((height - 1) / 2)
        bent = 1 + np.float32(self.distortion * 4 / (width**2 + height**2)) * (x * x + y * y)
        x = x * bent + np.float32((width - 1) / 2)
        y = y * bent + np.float32((height - 1) / 2)
        m = np.linalg.inv(self.matrix).astype(np.float32)
        depth = m[2, 0] * x + m[2, 1] * y + m[2, 2]
        columns = (m[0, 0] * x + m[0, 1] * y + m[0, 2]) / depth
        rows = (m[1, 0] * x + m[1, 1] * y + m[1, 2]) / depth
        return columns, rows

    def image(self, photo: Array) -> Array:
        """Return the view of a (h, w, 3) uint8 photo, reflected beyond its border."""
        zoom = float(np.sqrt(abs(np.linalg.det(self.matrix[:2, :2]))))
        if zoom < 0.75:  # keeps fine texture from aliasing
            photo = cv2.GaussianBlur(photo, (0, 0), 0.35 / zoom)
        return np.asarray(
            cv2.remap(photo, *self.grid, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        )

    def labels(self, labels: Array) -> Array:
        """Return the view of (h, w) uint8 labels; outside is ignore."""
        return np.asarray(
            cv2.remap(
                labels,
                *self.grid,
                cv2.INTER_NEAREST,
                borderMode=cv2.BORDER_CONSTANT,
                borderValue=IGNORE,
            )
        )

    def values(self, values: Array) -> Array:
        """Return the view of any (h, w) or (h, w, c) float32 map; outside is NaN."""
        return np.asarray(
            cv2.remap(
                values.astype(np.float32),
                *self.grid,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_CONSTANT,
                borderValue=(float("nan"),) * 4,
            )
        )


def random_warp(
    photo_size: tuple[int, int], size: tuple[int, int], rng: np.random.Generator
) -> Warp:
    """Return a random crop, scale, turn (up to 8 deg), mirror image, tilt and distortion."""
    height, width = size
    h, w = photo_size
    # From a little more than the whole photo to half of its side.
    zoom = max(height / h, width / w) * float(np.exp(rng.uniform(-0.1, 0.65)))
    stretch = float(np.exp(rng.normal(0, 0.08)))
    angle = np.deg2rad(np.clip(rng.normal(0, 2.5), -8, 8))
    cos, sin = np.cos(angle), np.sin(angle)
    linear = zoom * np.array([[cos * stretch, -sin], [sin * stretch, cos]])
    if rng.random() < 0.5:
        linear[:, 0] *= -1
    # The view's centre looks at a point that keeps most of the view inside the photo.
    slack = np.maximum(0, np.array([w, h]) - np.array([width, height]) / zoom)
    seen = np.array([w, h]) / 2 + slack * rng.uniform(-0.5, 0.5, 2)
    middle = np.array([width, height]) / 2
    matrix = np.eye(3)
    matrix[:2] = np.column_stack([linear, middle - linear @ seen])
    if rng.random() < 0.3:
        tilt = np.eye(3)
        tilt[2, :2] = rng.normal(0, 0.12, 2) / np.array([width, height])
        tilt[2, 2] = 1 - tilt[2, :2] @ middle  # the middle keeps its scale
        matrix = tilt @ matrix
        moved = matrix @ np.array([*seen, 1.0])
        shift = np.eye(3)
        shift[:2, 2] = middle - moved[:2] / moved[2]
        matrix = shift @ matrix
    distortion = float(rng.normal(0, 0.08)) if rng.random() < 0.4 else 0.0
    return Warp(matrix, float(np.clip(distortion, -0.18, 0.18)), size)
