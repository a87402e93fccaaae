"""Camera of one photo: focal length and rotation from vanishing points (docs/conventions.md)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.photos.camera.exif import ExifFocal
from plan2scene.photos.camera.line_weights import weighted_segments
from plan2scene.photos.camera.manhattan import Manhattan, fit_manhattan, refine_rotation
from plan2scene.photos.camera.vanishing import Segments

#: Horizontal field of view where nothing tells it, degrees: that of the paper's reference.
DEFAULT_FOV_DEG = 60.0
#: Photos are reduced to this width or height (the larger) before segments are sought.
WORKING_SIDE = 800
#: A frame is believed with this many segments on the vertical and on the horizontal axes (or on
#: each of the horizontal ones), ...
MIN_VERTICAL = 3
MIN_HORIZONTAL = 5
#: ... with this share of the segments' weight; the focal length below this relative spread, which
#: is nearly that of the prior alone.
MIN_SHARE = 0.30
FULL_SHARE = 0.7
MAX_LOG_FOCAL_SD = 0.30
#: From this confidence on a camera counts as well known: more likely than not its focal length is
#: within 15 %. Later stages may rely on it.
HIGH_CONFIDENCE = 0.5
#: A focal length of EXIF data gives way to confident vanishing points beyond this ratio: the photo
#: was cropped or its data are another photo's.
EXIF_TOLERANCE = 1.2
#: Factor of the confidence where the focal length is not measured at all: never high.
GIVEN_CERTAINTY = 0.49
#: Certainty of a focal length of EXIF data, as a factor of the confidence.
EXIF_CERTAINTY = 0.95


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in the Manhattan frame of its photo."""

    #: Size of the photo, pixels.
    width: int
    height: int
    #: Focal length and principal point, pixels.
    focal_px: float
    cx: float
    cy: float
    #: (3, 3), world to camera; the world has y up and x, z along the two horizontal vanishing
    #: directions, z the one nearest to the view direction. Camera axes: x right, y down, z forward.
    rotation: tuple[tuple[float, float, float], ...]
    #: ``exif``, ``vanishing_points`` or ``config`` (the constant field of view).
    focal_source: str
    #: 0..1: the probability that the focal length is within 15 %, times the support of the frame;
    #: high from `HIGH_CONFIDENCE` on.
    confidence: float
    #: True when no frame was found: a level camera that looks straight at a wall.
    fallback: bool

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
        """Return the camera with another (3, 3) world-to-camera rotation."""
        return replace(self, rotation=_rows(rotation))

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return pixels (n, 2) of points (n, 3) given from the camera centre in world axes.

        Points at or behind the camera give NaN.
        """
        seen = np.asarray(points, dtype=np.float64) @ self.matrix.T
        depth = np.where(seen[:, 2:] > 1e-9, seen[:, 2:], np.nan)
        return np.asarray(seen[:, :2] / depth * self.focal_px + np.array([self.cx, self.cy]))

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return unit view directions (..., 3) in world axes of pixels (..., 2) as x, y."""
        flat = (np.asarray(pixels, dtype=np.float64) - np.array([self.cx, self.cy])) / self.focal_px
        seen = np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)
        world = seen @ self.matrix
        return np.asarray(world / np.linalg.norm(world, axis=-1, keepdims=True))

    def to_json(self) -> dict[str, Any]:
        """Return the camera as plain JSON values (masks/cameras.json)."""
        return asdict(self)

    @classmethod
    def from_json(cls, value: Any, *, file: object = "") -> Camera:
        """Return the camera of `to_json`'s values; InputError when they are none.

        `focal_source`, `confidence` and `fallback` may be missing: a measured camera, as in
        the truth of synthetic houses, needs none of them.
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
                rotation=_rows(rotation),
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


def estimate_camera(
    image: np.ndarray,
    labels: np.ndarray | None = None,
    *,
    fov_deg: float = DEFAULT_FOV_DEG,
    exif: ExifFocal | None = None,
    seed: int = 0,
) -> Camera:
    """Return focal length and rotation of a photo of a room (paper section 4, made metric).

    Parameters
    ----------
    image : (h, w, 3) uint8
        The photo, sRGB.
    labels : (h, w) uint8, optional
        Label mask; segments on surfaces and their borders count more than those on furniture.
    fov_deg : float
        Horizontal field of view to start from and to fall back to, degrees.
    exif : ExifFocal, optional
        What the photo's EXIF data say (`exif.read_exif_focal`).
    seed : int
        Seed of the vertical vanishing point's random pairs.

    Notes
    -----
    Precedence of the focal length: EXIF, vanishing points, `fov_deg`. EXIF data give way to
    vanishing points of high confidence that differ by more than `EXIF_TOLERANCE`; those of a
    cropped photo only stand in for `fov_deg`.
    """
    height, width = image.shape[:2]
    scale = min(1.0, WORKING_SIDE / max(height, width))
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    if scale < 1.0:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    columns = grey.shape[1]
    segments = weighted_segments(grey, labels)
    known = None if exif is None or exif.focal_px is None else exif.focal_px * columns / width
    prior = columns / 2 / np.tan(np.radians(fov_deg) / 2) if known is None else known
    frame = fit_manhattan(segments, columns, prior, seed)
    pose = _decide(frame, segments, prior, known is not None)
    if frame is not None and known is not None and exif is not None and not exif.cropped:
        pose = _with_exif(pose, fit_manhattan(segments, columns, known, seed, fixed=True), known)
    return Camera(
        width=width,
        height=height,
        focal_px=round(float(pose.focal) * width / columns, 4),
        cx=(width - 1) / 2,
        cy=(height - 1) / 2,
        rotation=_rows(canonical(pose.axes)),
        focal_source=pose.source,
        confidence=round(float(np.clip(pose.confidence, 0.0, 1.0)), 4),
        fallback=pose.fallback,
    )


@dataclass(frozen=True)
class _Pose:
    """What was decided about a photo, in working pixels."""

    axes: np.ndarray
    focal: float
    source: str
    confidence: float
    fallback: bool


def _decide(frame: Manhattan | None, segments: Segments, prior: float, is_exif: bool) -> _Pose:
    """Return the fitted frame, or the prior focal length where the evidence is weak."""
    given = "exif" if is_exif else "config"
    if frame is None or not _believed(frame):
        return _Pose(np.diag([-1.0, -1.0, 1.0]), prior, given, 0.0, True)
    confidence = frame.certainty * _support(frame)
    if frame.log_focal_sd <= MAX_LOG_FOCAL_SD:
        return _Pose(frame.axes, frame.focal, "vanishing_points", confidence, False)
    axes = refine_rotation(segments, frame, prior)
    return _Pose(axes, prior, given, GIVEN_CERTAINTY * confidence, False)


def _with_exif(pose: _Pose, frame: Manhattan | None, focal: float) -> _Pose:
    """Return the frame fitted with EXIF's focal length unless vanishing points contradict it."""
    ratio = max(pose.focal / focal, focal / pose.focal)
    clear = pose.source == "vanishing_points" and pose.confidence >= HIGH_CONFIDENCE
    if clear and ratio > EXIF_TOLERANCE:
        return pose
    if frame is None or not _believed(frame):
        return replace(pose, focal=focal, source="exif")
    certainty = EXIF_CERTAINTY * _support(frame)
    return _Pose(frame.axes, focal, "exif", certainty, False)


def _support(frame: Manhattan) -> float:
    """Return 0..1: how much of a photo's lines follow the frame, 1 from `FULL_SHARE` on."""
    return min(1.0, frame.share / FULL_SHARE)


def _believed(frame: Manhattan) -> bool:
    """Tell whether a frame has support: the vertical and a horizontal, or both horizontals."""
    x, y, z = frame.counts
    upright = y >= MIN_VERTICAL and x + z >= MIN_HORIZONTAL
    return frame.share >= MIN_SHARE and (upright or min(x, z) >= MIN_HORIZONTAL)


def canonical(axes: np.ndarray) -> np.ndarray:
    """Return world-to-camera `axes` turned by a multiple of 90 degrees so that z looks ahead.

    The result is a proper rotation whose y column points up in the image and whose z column is
    the horizontal direction nearest to the view direction.
    """
    up = axes[:, 1] if axes[1, 1] < 0 else -axes[:, 1]
    choices = [axes[:, 0], -axes[:, 0], axes[:, 2], -axes[:, 2]]
    ahead = max(choices, key=lambda axis: float(axis[2]))
    turned = np.stack([np.cross(up, ahead), up, ahead], axis=1)
    left, _, right = np.linalg.svd(turned)
    return np.asarray(left @ right)


def _rows(matrix: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    """Return a (3, 3) array as rounded tuples, so that JSON gives the same bytes everywhere."""
    rounded = np.round(matrix, 9) + 0.0
    return tuple((float(row[0]), float(row[1]), float(row[2])) for row in rounded)
