"""What drawn rooms consist of: paints, boxes and ellipsoids, lamps, and the camera.

Lengths in metres, y up; colours are linear unless said otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Paint:
    """Colour of a thing: a tile that repeats, in several resolutions, or a plain colour.

    Attributes
    ----------
    levels : tuple of (n, n, 3) float32 linear
        Each half the size of the one before; the last is 1x1.
    size_m : float
        Metres that a tile covers; 0 stretches one tile over each face.
    gloss : float
        Strength of highlights, 0 matt.
    """

    levels: tuple[Array, ...]
    size_m: float = 1.0
    gloss: float = 0.0


def plain(colour: Array, gloss: float = 0.0) -> Paint:
    """Return a paint of one linear colour."""
    return Paint((np.asarray(colour, np.float32).reshape(1, 1, 3),), 1.0, gloss)


def tiled(albedo: Array, size_m: float, gloss: float = 0.0) -> Paint:
    """Return a paint of a (n, n, 3) uint8 sRGB tile."""
    level = (albedo.astype(np.float32) / 255) ** np.float32(2.2)
    levels = [level]
    while level.shape[0] > 1:
        side = max(1, level.shape[0] // 2)
        level = cv2.resize(level, (side, side), interpolation=cv2.INTER_AREA)
        levels.append(level.reshape(side, side, 3))
    return Paint(tuple(levels), size_m, gloss)


@dataclass(frozen=True, eq=False)
class Body:
    """A box or an ellipsoid, turned about the vertical; `hollow` is the room, seen from inside.

    Attributes
    ----------
    centre, half : (3,) float
        Middle in the world and half the size along the body's own axes, metres.
    yaw, tilt : float
        Turn about the vertical, then about the body's own x axis, radians.
    paints, labels : tuple
        One entry, or six: -x, +x, -y, +y, -z, +z faces as seen from outside.
    stencil : (n, m) bool, optional
        Cuts a box's thinnest axis out to a shape: rows run down (or along z), columns along x
        (or z); rays pass where it is False.
    mirror : float
        Share of light that it mirrors: near 1 a mirror, about 0.3 a polished floor.
    beyond : Body, optional
        A hollow body, listed too, that rays enter here: an open door to the next room.
    """

    centre: Array
    half: Array
    yaw: float
    labels: tuple[int, ...]
    paints: tuple[Paint, ...]
    round: bool = False
    hollow: bool = False
    glow: float = 0.0
    tilt: float = 0.0
    stencil: Array | None = None
    mirror: float = 0.0
    beyond: Body | None = None

    @cached_property
    def turn(self) -> Array:
        """(3, 3) float32: world to body axes."""
        cos, sin = np.cos(self.yaw), np.sin(self.yaw)
        about_y = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
        cos, sin = np.cos(self.tilt), np.sin(self.tilt)
        about_x = np.array([[1, 0, 0], [0, cos, sin], [0, -sin, cos]])
        return (about_x @ about_y).astype(np.float32)

    @cached_property
    def span(self) -> Array:
        """(3,) float32: `half`."""
        return self.half.astype(np.float32)

    def local(self, points: Array) -> Array:
        """Return world points (..., 3) in the body's frame, metres, float32."""
        moved = points.astype(np.float32) - self.centre.astype(np.float32)
        return np.asarray(moved @ self.turn.T)


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light that reaches from a point with some size."""

    position: Array
    colour: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Eye:
    """A pinhole camera: `rotation` takes world to camera (x right, y down, z forward)."""

    position: Array
    rotation: Array
    focal_px: float
    size: tuple[int, int]

    def rays(self) -> Array:
        """Return (h, w, 3) float32 directions in the world, depth 1 along the view."""
        height, width = self.size
        rows, columns = np.mgrid[:height, :width].astype(np.float32)
        camera = np.stack(
            [
                (columns - (width - 1) / 2) / self.focal_px,
                (rows - (height - 1) / 2) / self.focal_px,
                np.ones_like(rows),
            ],
            axis=-1,
        )
        return (camera @ self.rotation).astype(np.float32)
