"""The camera of photos and pictures: where it stands, how it is turned, what a pixel shows.

World axes: metres, right-handed, y up. Camera axes: x right, y down, z ahead, as OpenCV has them.
Pixels are (x, y); (0, 0) is the middle of the upper left pixel.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from plan2scene.errors import InputError

_PART = 32_768  #: Number of pixels whose rays are computed at a time
Rows = tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera, or an orthographic one.

    A photo's camera stands at the origin; its place in the plan is found later
    (:class:`plan2scene.photos.locate.pose.Pose`).
    """

    #: Size of the picture, pixels.
    width: int
    height: int
    focal_px: float  #: focal length in pixels; pixels per metre of an orthographic camera
    #: Principal point, pixels.
    cx: float
    cy: float
    #: (3, 3) world to camera: rows are the camera's right, down and ahead in world axes. In a
    #: photo's own (Manhattan) frame the world's x, z are the two horizontal vanishing directions,
    #: z the one nearest to the view direction.
    rotation: Rows
    #: Source of a photo's focal length: ``exif``, ``vanishing_points`` or ``config`` (the constant
    #: field of view).
    focal_source: str = "config"
    #: 0..1: probability that the focal length is within 15 %, times the frame's support by lines.
    confidence: float = 1.0
    #: True if no frame was found in the photo: then a level camera facing a wall is assumed.
    fallback: bool = False
    #: x, y, z in the world, metres.
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orthographic: bool = False

    @property
    def matrix(self) -> np.ndarray:
        """Return the rotation as a (3, 3) float64 array."""
        return np.array(self.rotation, dtype=np.float64)

    @property
    def intrinsics(self) -> np.ndarray:
        """Return K as a (3, 3) float64 array."""
        return np.array(
            [[self.focal_px, 0.0, self.cx], [0.0, self.focal_px, self.cy], [0.0, 0.0, 1.0]]
        )

    def with_rotation(self, rotation: np.ndarray) -> Camera:
        """Return the camera with another (3, 3) world-to-camera rotation, rounded."""
        return replace(self, rotation=rounded_rows(rotation))

    def resized(self, size: tuple[int, int]) -> Camera:
        """Return the camera of the same picture resized to (height, width)."""
        scale = size[1] / self.width
        return replace(
            self,
            width=size[1],
            height=size[0],
            focal_px=self.focal_px * scale,
            cx=(self.cx + 0.5) * scale - 0.5,
            cy=(self.cy + 0.5) * size[0] / self.height - 0.5,
        )

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Return world points (..., 3) in camera axes: metres to the right, down and ahead."""
        return np.asarray((points - np.array(self.position)) @ self.matrix.T)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return pixels (..., 2) of world points (..., 3); NaN at or behind a pinhole camera."""
        in_camera = self.seen(np.asarray(points, dtype=np.float64))
        depth = in_camera[..., 2:]
        depth = np.ones_like(depth) if self.orthographic else np.where(depth > 1e-9, depth, np.nan)
        return np.asarray(in_camera[..., :2] / depth * self.focal_px + np.array([self.cx, self.cy]))

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit view directions (..., 3) in world axes of pixels (..., 2) of a pinhole."""
        pixels = np.asarray(pixels)
        flat_pixels, rays = pixels.reshape(-1, 2), np.empty((pixels[..., 0].size, 3))
        # In parts that fit the processor's cache: a photo's rays take a quarter of the time.
        for first in range(0, len(flat_pixels), _PART):
            part = flat_pixels[first : first + _PART]
            # Column by column: numpy is ten times slower along an axis of length two or three.
            in_camera = np.ones((len(part), 3))
            for axis, middle in enumerate((self.cx, self.cy)):
                np.subtract(part[:, axis], middle, out=in_camera[:, axis])
                in_camera[:, axis] /= self.focal_px
            world = np.matmul(in_camera, self.matrix, out=rays[first : first + _PART])
            x, y, z = world.T
            length = np.sqrt(x * x + y * y + z * z)
            for column in (x, y, z):
                column /= length
        return rays.reshape(*pixels.shape[:-1], 3)

    def rays_at(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return the rays (n, 3) of the pixels in these rows and columns, (n,) each.

        The rays of the whole picture are computed once and cached until another camera is used.
        """
        return _all_rays(self)[rows, columns]

    def to_json(self) -> dict[str, Any]:
        """Return a photo's camera as plain JSON values (masks/cameras.json)."""
        values = asdict(self)
        return {name: values[name] for name in values if name not in ("position", "orthographic")}

    @classmethod
    def from_json(cls, value: Any, *, file: object = "") -> Camera:
        """Return the camera of `to_json`'s values; InputError if they describe no camera.

        `focal_source`, `confidence` and `fallback` may be missing, as in the true cameras of
        synthetic houses.
        """
        try:
            rotation = np.array(value["rotation"], dtype=np.float64).reshape(3, 3)
            if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3):
                raise ValueError("rotation is not orthonormal")
            return cls(
                width=int(value["width"]),
                height=int(value["height"]),
                focal_px=float(value["focal_px"]),
                cx=float(value["cx"]),
                cy=float(value["cy"]),
                rotation=rounded_rows(rotation),
                focal_source=str(value.get("focal_source", "config")),
                confidence=float(value.get("confidence", 1.0)),
                fallback=bool(value.get("fallback", False)),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InputError(
                "a camera (width, height, focal_px, cx, cy, rotation)",
                f"{type(error).__name__}: {error}",
                file=file,
            ) from None


@lru_cache(maxsize=1)
def _all_rays(camera: Camera) -> np.ndarray:
    """Return the rays (h, w, 3) of all pixels of a picture."""
    rows, columns = np.indices((camera.height, camera.width))
    return camera.rays(np.stack([columns, rows], axis=-1))


def focal_of(fov: float, width: int) -> float:
    """Return the focal length in pixels of a horizontal field of view in radians."""
    return width / (2 * math.tan(fov / 2))


def as_rows(matrix: np.ndarray) -> Rows:
    """Return a (3, 3) array as tuples."""
    return tuple((float(a), float(b), float(c)) for a, b, c in matrix)


def rounded_rows(matrix: np.ndarray) -> Rows:
    """Return a (3, 3) array as rounded tuples, so that JSON gives the same bytes everywhere."""
    return as_rows(np.round(matrix, 9) + 0.0)
