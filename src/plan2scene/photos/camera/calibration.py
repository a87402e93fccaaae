"""Focal length and rotation of a photo, estimated from its lines, EXIF data and labels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plan2scene.camera import Camera, rounded_rows
from plan2scene.photos.camera.exif import ExifFocal
from plan2scene.photos.camera.lines import (
    CAMERA,
    PhotoSegments,
    Segments,
    find_segments,
    weighted_segments,
)
from plan2scene.photos.camera.manhattan import Manhattan, fit_manhattan, refine_rotation

#: Horizontal field of view, degrees, of a photo for which nothing else gives one: the value of the
#: paper's reference.
DEFAULT_FOV_DEG = 60.0


def estimate_camera(
    image: np.ndarray,
    labels: np.ndarray | None = None,
    *,
    fov_deg: float = DEFAULT_FOV_DEG,
    exif: ExifFocal | None = None,
    segments: PhotoSegments | None = None,
) -> Camera:
    """Return focal length and rotation of a photo of a room (paper section 4, made metric).

    `image` is (h, w, 3) uint8 sRGB. `labels` are (h, w) uint8: segments on walls, on ceilings and
    on borders between surfaces count more than those on floors and furniture. `fov_deg` is the
    horizontal field of view to start from and to fall back to, degrees. `segments` are found here
    (`lines.find_segments`) when not given.

    The focal length is that of `exif`, else of vanishing points, else of `fov_deg`. Vanishing
    points of high confidence replace EXIF data that differ by more than `CAMERA.exif_tolerance`,
    but not a focal length that the user has `told`. The EXIF data of a cropped photo only replace
    `fov_deg`.
    """
    height, width = image.shape[:2]
    lines = find_segments(image) if segments is None else segments
    columns = lines.size[1]
    weighted = weighted_segments(lines.camera, lines.size, labels)
    exif_focal = None if exif is None or exif.focal_px is None else exif.focal_px * columns / width
    prior = columns / 2 / np.tan(np.radians(fov_deg) / 2) if exif_focal is None else exif_focal
    frame = fit_manhattan(weighted, columns, prior)
    pose = _decide(frame, weighted, prior, exif_focal is not None)
    if frame is not None and exif_focal is not None and exif is not None and not exif.cropped:
        exif_frame = fit_manhattan(weighted, columns, exif_focal, fixed=True)
        pose = _with_exif(pose, exif_frame, exif_focal, told=exif.told)
    return Camera(
        width=width,
        height=height,
        focal_px=round(float(pose.focal) * width / columns, 4),
        cx=(width - 1) / 2,
        cy=(height - 1) / 2,
        rotation=rounded_rows(canonical(pose.axes)),
        focal_source=pose.source,
        confidence=round(float(np.clip(pose.confidence, 0.0, 1.0)), 4),
        fallback=pose.fallback,
    )


@dataclass(frozen=True)
class _Pose:
    """The chosen rotation and focal length of a photo, in pixels of the reduced photo."""

    axes: np.ndarray
    focal: float
    source: str
    confidence: float
    fallback: bool


def _decide(frame: Manhattan | None, segments: Segments, prior: float, is_exif: bool) -> _Pose:
    """Return the fitted frame, or the prior focal length where the evidence is weak."""
    prior_source = "exif" if is_exif else "config"
    if frame is None or not _believed(frame):
        return _Pose(np.diag([-1.0, -1.0, 1.0]), prior, prior_source, 0.0, True)
    confidence = frame.certainty * _support(frame)
    if frame.log_focal_sd <= CAMERA.max_log_focal_sd:
        return _Pose(frame.axes, frame.focal, "vanishing_points", confidence, False)
    axes = refine_rotation(segments, frame, prior)
    return _Pose(axes, prior, prior_source, CAMERA.given_certainty * confidence, False)


def _with_exif(pose: _Pose, frame: Manhattan | None, focal: float, *, told: bool) -> _Pose:
    """Return the pose with EXIF's focal length, unless it is not `told` and lines contradict it."""
    ratio = max(pose.focal / focal, focal / pose.focal)
    clear = pose.source == "vanishing_points" and pose.confidence >= CAMERA.high_confidence
    if clear and ratio > CAMERA.exif_tolerance and not told:
        return pose
    if frame is None or not _believed(frame):
        return replace(pose, focal=focal, source="exif")
    certainty = CAMERA.exif_certainty * _support(frame)
    return _Pose(frame.axes, focal, "exif", certainty, False)


def _support(frame: Manhattan) -> float:
    """Return the support of a frame in a photo's lines, 0..1, 1 from `CAMERA.full_share` on."""
    return min(1.0, frame.share / CAMERA.full_share)


def _believed(frame: Manhattan) -> bool:
    """Tell whether a frame has support: the vertical and a horizontal, or both horizontals."""
    x, y, z = frame.counts
    upright = y >= CAMERA.min_vertical and x + z >= CAMERA.min_horizontal
    return frame.share >= CAMERA.min_share and (upright or min(x, z) >= CAMERA.min_horizontal)


def canonical(axes: np.ndarray) -> np.ndarray:
    """Return world-to-camera `axes` with x and z turned by quarter turns so that z looks ahead.

    The result is a proper rotation whose y column points up in the image and whose z column is
    the horizontal direction nearest to the view direction.
    """
    up = axes[:, 1] if axes[1, 1] < 0 else -axes[:, 1]
    choices = [axes[:, 0], -axes[:, 0], axes[:, 2], -axes[:, 2]]
    ahead = max(choices, key=lambda axis: float(axis[2]))
    turned = np.stack([np.cross(up, ahead), up, ahead], axis=1)
    left, _, right = np.linalg.svd(turned)
    return np.asarray(left @ right)
