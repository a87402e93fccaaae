"""Where cameras of drawn rooms stand, and how they expose."""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Array,
    Eye,
)

Rng = np.random.Generator
#: Sizes (height, width) of the pictures in pixels, and how often they occur.
SIZES = (((240, 320), 0.55), ((320, 240), 0.17), ((208, 368), 0.14), ((272, 280), 0.14))


def random_eye(half: Array, rng: Rng) -> Eye:
    """Return a camera in a room centred on x = z = 0: mostly near a wall, looking inside.

    Parameters
    ----------
    half : (3,) float
        Half the room's size in metres; its floor is at y = 0.
    """
    size = SIZES[int(rng.choice(len(SIZES), p=[share for _, share in SIZES]))][0]
    anywhere = rng.random() < 0.15
    near = (0.0, 0.95) if anywhere else (0.2, 0.92)
    position = rng.uniform(*near, 3) * rng.choice([-1, 1], 3) * half
    position[1] = np.clip(rng.normal(1.4, 0.3), 0.8, min(2.0, 2 * half[1] - 0.2))
    position[[0, 2]] = np.clip(position[[0, 2]], 0.25 - half[[0, 2]], half[[0, 2]] - 0.25)
    target = rng.uniform(-0.7, 0.7, 2) * half[[0, 2]]
    heading = np.arctan2(*(target - position[[0, 2]])) + rng.normal(0, 0.25)
    if anywhere:
        heading = rng.uniform(0, 2 * np.pi)
    pitch = rng.normal(-7, 8) if rng.random() < 0.7 else rng.uniform(-35, 15)
    roll = rng.normal(0, 1.2 if rng.random() < 0.8 else 5)
    turn = _looking(heading, np.deg2rad(np.clip(pitch, -35, 18)), np.deg2rad(roll))
    fov = np.deg2rad(rng.uniform(40, 110) if rng.random() < 0.5 else rng.uniform(52, 85))
    return Eye(position, turn, max(size) / 2 / float(np.tan(fov / 2)), size)


def _looking(heading: float, pitch: float, roll: float) -> Array:
    """Return the (3, 3) rotation, world to camera, of a view; angles in radians."""
    forward = np.array(
        [np.sin(heading) * np.cos(pitch), np.sin(pitch), np.cos(heading) * np.cos(pitch)]
    )
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    return np.stack(
        [
            np.cos(roll) * right + np.sin(roll) * down,
            np.cos(roll) * down - np.sin(roll) * right,
            forward,
        ]
    )


def developed(picture: Array, rng: Rng) -> Array:
    """Return a linear picture exposed, tone mapped and encoded: (h, w, 3) uint8 sRGB."""
    level = np.quantile(picture[::3, ::3].mean(axis=2), rng.uniform(0.4, 0.75))
    x = picture * np.float32(rng.uniform(0.2, 0.6) / max(float(level), 1e-4))
    if rng.random() < 0.7:
        x = x / (1 + np.float32(0.4) * x) * np.float32(1.25)
    small = cv2.resize(x, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    bloom = cv2.GaussianBlur(np.clip(small - 1, 0, 4), (0, 0), rng.uniform(1, 4))
    bloom = cv2.resize(bloom, (x.shape[1], x.shape[0]), interpolation=cv2.INTER_LINEAR)
    x = cv2.pow(np.clip(x + np.float32(0.3) * bloom, 0, 1), 1 / 2.2)
    return (x * 255).astype(np.uint8)
