"""Homography from a plane of a photo to metres: the plane seen straight on, to scale.

Axes of the rectified image (``docs/conventions.md``): for walls, rows go down and columns go to the
right as seen from inside; for floors and ceilings, columns go along +x and rows along +z of the
photo's Manhattan frame. The image of a ceiling is therefore mirrored against the photo, which makes
it look right on a mesh whose UVs are (x, z).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.images import window_counts
from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.walls import PLANES


@dataclass(frozen=True)
class RectifiedPlane:
    """A plane of a photo in metres."""

    photo: np.ndarray  #: (h, w, 3) uint8 sRGB
    to_photo: np.ndarray  #: (3, 3) float64: Homography from rectified pixels to the photo's
    #: (h, w) bool: Usable pixels: in the plane's mask, not seen at too flat an angle, dense enough.
    mask: np.ndarray
    #: (2,): Plane coordinates (right, down), metres, of the image's top left corner.
    origin: tuple[float, float]
    metres_per_pixel: float  #: side of a pixel
    #: (3, 3) float64: Rows: unit right, unit down, and the plane's point nearest to the camera
    #: (plane coordinates 0, 0), metres from the camera.
    axes: np.ndarray
    focal_px: float  #: focal length of the photo, pixels

    @cached_property
    def image(self) -> np.ndarray:
        """The plane seen straight on, (h, w, 3) uint8 sRGB."""
        size = self.mask.shape[::-1]
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_CUBIC
        border = cv2.BORDER_REPLICATE
        return cv2.warpPerspective(self.photo, self.to_photo, size, flags=flags, borderMode=border)

    def at_scale(self, px_per_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the image (h, w, 3) uint8 and the mask (h, w) bool at another resolution."""
        scale = self.metres_per_pixel * px_per_m
        size = tuple(max(1, round(side * scale)) for side in self.mask.shape[::-1])
        way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        mask = cv2.resize(self.mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        return cv2.resize(self.image, size, interpolation=way), mask > 0

    def window(self, row: int, column: int, side: int) -> tuple[float, float, float, float]:
        """Return x0 y0 x1 y1 on the plane, metres, of a square of pixels."""
        step = self.metres_per_pixel
        x, y = self.origin[0] + column * step, self.origin[1] + row * step
        return (x, y, x + side * step, y + side * step)

    def places(self, side: int) -> np.ndarray:
        """Return the top left pixels at which a square of `side` pixels is fully inside the mask.

        (h - side + 1, w - side + 1) bool; empty if the square is larger than the image.
        """
        if side > min(self.mask.shape):
            return np.zeros((0, 0), bool)
        return window_counts(self.mask, side, side) == side * side

    def view(self, x: float, y: float) -> tuple[float, float]:
        """Return (grazing angle in degrees, photo pixels per metre) at a point of the plane.

        The pixels are the geometric mean over the two directions on the plane.
        """
        point = self.axes[2] + x * self.axes[0] + y * self.axes[1]
        reach = float(np.linalg.norm(point))
        facing = float(np.linalg.norm(self.axes[2])) / max(reach, 1e-9)
        density = self.focal_px / max(reach, 1e-9) * np.sqrt(facing)
        return float(np.degrees(np.arcsin(np.clip(facing, 0.0, 1.0)))), float(density)


def plane_axes(plane: Plane) -> np.ndarray:
    """Return (3, 3) rows: right, down, and the plane's point nearest to the camera."""
    normal = np.array(plane.normal)
    if plane.surface == "wall":
        right = np.cross(-normal, [0.0, 1.0, 0.0])
        down = np.array([0.0, -1.0, 0.0])
    else:
        right, down = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    return np.stack([right, down, normal * plane.offset])


@dataclass(frozen=True)
class PlanePixels:
    """The pixels of a plane, for any density of the rectified image."""

    mask: np.ndarray  #: (h, w) bool: The plane's mask without its border
    places: tuple[np.ndarray, np.ndarray]  #: (n,), (n,) int64: Rows and columns of its pixels
    points: np.ndarray  #: (n, 2) float64: Plane coordinates (right, down), metres
    #: (n,) float64: Photo pixels per metre, geometric mean of both directions on the plane.
    density: np.ndarray
    good: np.ndarray  #: (n,) bool: Neither seen at too flat an angle nor a skirting board


def plane_pixels(camera: Camera, plane: Plane) -> PlanePixels:
    """Return the pixels of a plane, with their positions, densities and whether they are usable."""
    border = max(1, round(PLANES.border_share * camera.width))
    kernel = np.ones((2 * border + 1, 2 * border + 1), np.uint8)
    mask = cv2.erode(plane.mask.astype(np.uint8), kernel) > 0
    rows, columns = np.nonzero(mask)
    rays = camera.rays_at(rows, columns)
    facing = -(rays @ np.array(plane.normal))
    reach = -plane.offset / np.maximum(facing, 1e-6)
    density = camera.focal_px / reach * np.sqrt(np.maximum(facing, 0.0))
    good = facing >= np.sin(np.radians(PLANES.min_grazing_deg))
    for column in rays.T:
        column *= reach
    points = rays @ plane_axes(plane)[:2].T
    if plane.surface == "wall":
        good &= points[:, 1] < plane.camera_height_m - PLANES.skirting_m
    return PlanePixels(mask, (rows, columns), points, density, good)


def rectify(
    image: np.ndarray,
    camera: Camera,
    plane: Plane,
    *,
    min_density: float = 0.0,
    pixels: PlanePixels | None = None,
) -> RectifiedPlane | None:
    """Return a plane of a photo (h, w, 3) uint8 sRGB seen straight on; None when none is usable.

    Pixels of fewer than `min_density` photo pixels per metre are left out. `pixels` are those of
    :func:`plane_pixels`, to save time for a plane that is rectified more than once. The resolution
    is that of the photo's densest part (90th percentile of its sampling density): no detail is lost
    there, and warping hardly aliases. The rest is upsampled at most by the ratio of this density to
    `min_density`.
    """
    pixels = pixels or plane_pixels(camera, plane)
    good = pixels.good & (pixels.density >= min_density)
    points, density = pixels.points[good], pixels.density[good]
    if len(points) < 16:
        return None
    mask = pixels.mask.copy()
    mask[pixels.places[0][~good], pixels.places[1][~good]] = False
    low, high = (np.array([end(column) for column in points.T]) for end in (np.min, np.max))
    extent = float(max((high - low).max(), 1e-3))
    resolution = float(np.clip(np.percentile(density, 90), *PLANES.resolution_range))
    resolution = min(resolution, PLANES.max_side_px / extent)
    step = 1.0 / resolution
    size = np.maximum(1, np.ceil((high - low) / step).astype(int))
    axes = plane_axes(plane)
    to_plane = np.array([[step, 0, low[0] + step / 2], [0, step, low[1] + step / 2], [0, 0, 1.0]])
    to_photo = camera.intrinsics @ camera.matrix @ axes.T @ to_plane
    shape = (int(size[0]), int(size[1]))
    nearest = cv2.WARP_INVERSE_MAP | cv2.INTER_NEAREST
    inside = cv2.warpPerspective(mask.astype(np.uint8), to_photo, shape, flags=nearest)
    ahead = _ahead(camera, axes, low, step, shape)
    return RectifiedPlane(
        photo=image,
        to_photo=to_photo,
        mask=(inside > 0) & ahead,
        origin=(float(low[0]), float(low[1])),
        metres_per_pixel=step,
        axes=axes,
        focal_px=camera.focal_px,
    )


def _ahead(
    camera: Camera, axes: np.ndarray, low: np.ndarray, step: float, shape: tuple[int, int]
) -> np.ndarray:
    """Return the rectified pixels in front of the camera; the homography maps those behind, too."""
    forward = camera.matrix[2]
    x = (low[0] + (np.arange(shape[0]) + 0.5) * step) * float(forward @ axes[0])
    y = (low[1] + (np.arange(shape[1]) + 0.5) * step) * float(forward @ axes[1])
    return np.asarray(x[None, :] + y[:, None] + float(forward @ axes[2]) > 1e-3)
