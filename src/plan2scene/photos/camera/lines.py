"""Line segments of a photo and of its label mask, and their weights in the estimate of the camera.

A segment and the camera centre span a plane with unit normal n. If the segment shows a line along
the unit direction d (camera axes), then n . d = 0. The residual used here is the angle by which
the segment would have to turn about the ray m through its middle, ``asin(|n . d| / |m x d|)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.io import read_parquet, write_parquet
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL


@dataclass(frozen=True)
class CameraSettings:
    """Constants of the estimate of a photo's camera.

    Source, where a field names no other: set by hand; ``benchmarks/cameras.py`` scores the cameras
    of synthetic homes against their truth.
    """

    # Line segments of the photo.
    #: Longer side that photos are reduced to before segments are found, pixels.
    working_side_px: int = 800
    max_segments: int = 320  #: largest number of segments used; the longest are kept
    min_length_px: float = 12.0  #: shorter segments are dropped, pixels of the reduced photo
    end_noise_px: float = 1.0  #: error of a segment's ends, pixels
    #: Least angular noise of a segment, first in the fit, then for the first guesses, radians.
    angle_noise: float = float(np.radians(0.35))
    coarse_noise: float = float(np.radians(1.6))
    #: Number of near, parallel neighbours that divides a segment's weight by the square root of 2.
    crowd: float = 2.0
    #: Gaussian scales of their distance (share of the photo's width) and angle (radians).
    crowd_reach: float = 0.2
    crowd_angle: float = float(np.radians(8.0))

    # Lines along borders of labels.
    max_borders: int = 12  #: largest number of lines
    border_length: float = 0.08  #: shortest length of a line, share of the photo's width
    #: Border pixels within this distance of a line belong to it, share of the photo's width.
    border_width: float = 0.01
    border_weight: float = 2.0  #: weight of such a line, and of photo segments on a border
    border_noise_px: float = 4.0  #: error of the ends of such a line, pixels

    # First guesses.
    #: Horizontal fields of view that are searched, degrees; widened to include the prior's.
    fov_range_deg: tuple[float, float] = (30.0, 115.0)
    #: Numbers of focal lengths, headings, drawn pairs of upright segments, and verticals kept.
    n_focal: int = 19
    n_heading: int = 45
    n_pairs: int = 300
    n_verticals: int = 5
    n_voters: int = 160  #: segments that vote: those of the largest weight
    #: Largest roll and pitch of a photo, and the largest lean in the photo of a segment that may
    #: show a vertical line, degrees.
    max_roll_deg: float = 25.0
    max_pitch_deg: float = 35.0
    max_slant_deg: float = 45.0
    #: Penalty where the log ratio of a focal length to the prior is 0.3, share of the votes; it
    #: grows with the square of the log ratio.
    focal_penalty: float = 0.02

    # Refinement.
    #: Number of guesses that are refined with their focal length free: the best ones.
    n_free: int = 8
    #: Standard deviations of the priors: log focal length, pitch and roll (radians; heavy tails).
    sigma_log_focal: float = 0.35
    sigma_pitch: float = float(np.radians(12.0))
    sigma_roll: float = float(np.radians(5.0))
    #: Standard deviation of the lens distortion's prior (`Segments.bent_rays`), and its bounds.
    sigma_bend: float = 0.03
    bend_range: tuple[float, float] = (-0.4, 0.25)
    #: This many segments count as one: segments share errors of the lens or of one texture.
    correlation: float = 1.4
    #: Width of the robust weight in each iteration, and of the cost, in units of a segment's noise.
    reweighting: tuple[float, ...] = (5.0, 4.0, 3.0, 2.2, 1.5, 1.5, 1.5)
    cost_width: float = 1.5
    difference: float = 1e-5  #: step of the numeric derivatives
    agrees: float = 2.5  #: largest residual of an inlier, in units of a segment's noise
    right_within: float = 1.15  #: largest ratio to the true focal length that counts as right

    # Acceptance and confidence.
    #: A frame is accepted with this many inlier segments on the vertical and on the horizontal axes
    #: (or on each of the two horizontal axes), and this share of the segments' weight.
    min_vertical: int = 3
    min_horizontal: int = 5
    min_share: float = 0.30
    full_share: float = 0.7  #: share of the weight from which on a frame has full support
    #: Largest standard deviation of the log focal length at which it counts as measured. It is
    #: nearly that of the prior alone.
    max_log_focal_sd: float = 0.30
    #: From this confidence on a camera counts as well known: more likely than not its focal length
    #: is within 15 %.
    high_confidence: float = 0.5
    #: Confident vanishing points replace a focal length of EXIF data beyond this ratio: the photo
    #: was cropped, or its data belong to another photo.
    exif_tolerance: float = 1.2
    #: Factor of the confidence where the focal length is not measured; it is never high then.
    given_certainty: float = 0.49
    exif_certainty: float = 0.95  #: factor of the confidence where EXIF data give the focal length


CAMERA = CameraSettings()


SEGMENTS = "segments.parquet"  #: File of the segments in a masks folder


def detect_segments(grey: np.ndarray) -> np.ndarray:
    """Return the line segments of a grey image, longest first.

    `grey` is (h, w) uint8; the segments are (n, 4) float64, ``x1 y1 x2 y2`` in pixels, (0, 0) the
    centre of the top left pixel. OpenCV's detector (von Gioi et al., LSD, 2012).
    """
    lines = cv2.createLineSegmentDetector().detect(np.ascontiguousarray(grey))[0]
    segments = np.zeros((0, 4)) if lines is None else lines.reshape(-1, 4).astype(np.float64)
    return segments[np.argsort(-_lengths(segments), kind="stable")]


def _lengths(segments: np.ndarray) -> np.ndarray:
    """Return the lengths (n,) of segments (n, 4)."""
    return np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])


_ENDS = ["x1", "y1", "x2", "y2"]  #: Columns of segments.parquet that hold a segment's ends


@dataclass(frozen=True, eq=False)
class PhotoSegments:
    """Line segments of a photo, ``x1 y1 x2 y2``, the longest first; the masks stage finds them."""

    size: tuple[int, int]  #: (height, width) of the reduced photo in which `camera` was found
    camera: np.ndarray  #: (n, 4) float64, pixels of the reduced photo: used to estimate the camera
    #: (m, 4) float64, pixels of the photo: long segments, used to find which way a wall faces.
    walls: np.ndarray
    scale: float = 1.0  #: pixels of the photo per pixel of the reduced one


def find_segments(image: np.ndarray) -> PhotoSegments:
    """Return the line segments of a photo (h, w, 3) uint8 sRGB."""
    height, width = image.shape[:2]
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    full_segments = reduced = detect_segments(grey)
    scale = min(1.0, CAMERA.working_side_px / max(height, width))
    if scale < 1.0:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
        reduced = detect_segments(grey)
    camera = reduced[_lengths(reduced) >= CAMERA.min_length_px][: CAMERA.max_segments]
    walls = full_segments[_lengths(full_segments) >= width / 25]
    return PhotoSegments((grey.shape[0], grey.shape[1]), camera, walls, width / grey.shape[1])


def write_segments(path: str | Path, segments: Mapping[str, PhotoSegments]) -> None:
    """Write the segments of a house's photos, in pixels of the photos (docs/conventions.md)."""
    import pandas as pd

    frames = []
    for photo, of_photo in segments.items():
        camera = (of_photo.camera + 0.5) * of_photo.scale - 0.5
        for use, ends in (("camera", camera), ("walls", of_photo.walls)):
            frame = pd.DataFrame(ends.astype(np.float32), columns=_ENDS)
            frames.append(frame.assign(photo=photo, use=use))
    table = pd.concat(frames) if frames else pd.DataFrame(columns=["photo", "use", *_ENDS])
    write_parquet(path, table[["photo", "use", *_ENDS]], {})


def read_segments(path: str | Path, use: str) -> dict[str, np.ndarray]:
    """Return photo -> segments (n, 4) float64, pixels; `use` is ``camera`` or ``walls``."""
    table, _ = read_parquet(path)
    return {
        str(photo): rows[_ENDS].to_numpy(np.float64)
        for photo, rows in table[table["use"] == use].groupby("photo")
    }


def border_lines(labels: np.ndarray) -> np.ndarray:
    """Return long lines along the feet and tops of walls, also of ragged ones; longest first.

    `labels` is (h, w) uint8. The lines are (n, 4) float64, ``x1 y1 x2 y2`` in pixels: least-squares
    lines through border pixels, at most `CAMERA.max_borders`.
    """
    edges = np.zeros(labels.shape, dtype=np.uint8)
    for one, other in ((WALL, FLOOR), (FLOOR, WALL), (WALL, CEILING), (CEILING, WALL)):
        near = cv2.dilate((labels == other).astype(np.uint8), np.ones((3, 3), np.uint8))
        edges |= near & (labels == one).astype(np.uint8)
    size = labels.shape[1]
    lines: list[np.ndarray] = []
    for _ in range(CAMERA.max_borders):
        hough = cv2.HoughLinesP(
            edges,
            1.0,
            np.pi / 180,
            threshold=max(8, round(0.03 * size)),
            minLineLength=CAMERA.border_length * size,
            maxLineGap=0.04 * size,
        )
        if hough is None:
            break
        segments = hough.reshape(-1, 4).astype(np.float64)
        rows, columns = np.nonzero(edges)
        points = np.stack([columns, rows], axis=1).astype(np.float64)
        longest = segments[int(np.argmax(_lengths(segments)))]
        line, used = _refine(longest, points, CAMERA.border_width * size)
        edges[rows[used], columns[used]] = 0
        lines.append(line)
        if not used.any():
            break
    return np.array(lines).reshape(-1, 4)


def _refine(segment: np.ndarray, points: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares segment through the points within `width` px of a segment.

    Also returns those points, as a mask (n,) bool.
    """
    start, end = segment[:2], segment[2:]
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    offset = points - start
    position = offset @ along
    distance = offset @ np.array([-along[1], along[0]])
    near = (np.abs(distance) <= width) & (position >= -width) & (position <= length + width)
    if near.sum() < 6:
        return segment, near
    inside = points[near]
    centre = inside.mean(axis=0)
    direction = np.linalg.svd(inside - centre, full_matrices=False)[2][0]
    direction = direction if direction @ along >= 0 else -direction
    reach = (inside - centre) @ direction
    ends = [centre + reach.min() * direction, centre + reach.max() * direction]
    return np.concatenate(ends), near


class Segments:
    """Segments relative to the principal point, with their lengths, slants, weights and noise.

    `segments` (s, 4) float64 are ``x1 y1 x2 y2`` and `centre` is the middle of the photo, pixels.
    `weight` (s,) is each segment's weight. `end_noise`, (s,) or one value, is the error of the
    ends, pixels. `level` (s,) bool tells which segments are known to be horizontal in the world.
    """

    def __init__(
        self,
        segments: np.ndarray,
        centre: tuple[float, float],
        weight: np.ndarray,
        end_noise: np.ndarray | float = CAMERA.end_noise_px,
        level: np.ndarray | None = None,
    ):
        #: (s,) radians added to the residual to the vertical: large for known horizontal lines.
        self.off_vertical = np.zeros(len(segments)) if level is None else np.where(level, 3.0, 0.0)
        #: Square of half the photo's diagonal, which is the unit of radii.
        self.unit = max(centre[0] ** 2 + centre[1] ** 2, 1.0)
        shift = np.array([centre[0], centre[1]] * 2)
        self.points = segments - shift
        delta = self.points[:, 2:] - self.points[:, :2]
        self.length = np.maximum(np.hypot(delta[:, 0], delta[:, 1]), 1e-6)
        self.middle = (self.points[:, :2] + self.points[:, 2:]) / 2
        self.slant = np.arctan2(np.abs(delta[:, 0]), np.abs(delta[:, 1]))
        self.weight = weight
        self.noise = np.hypot(end_noise * 2.0 / self.length, CAMERA.angle_noise)
        self.coarse_noise = np.hypot(end_noise * 2.0 / self.length, CAMERA.coarse_noise)

    def rays(self, focal: float) -> tuple[np.ndarray, np.ndarray]:
        """Return plane normals n and middle rays m, both (s, 3) unit, for a focal length."""
        normal, middle = self.bent_rays(np.array([focal]), np.zeros(1))
        return normal[0], middle[0]

    def bent_rays(self, focal: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return plane normals n and middle rays m, both (k, s, 3) unit, for k hypotheses.

        `focal` (k,) is in pixels. `bend` (k,) is the lens distortion of the division model
        (Fitzgibbon, CVPR 2001): a point at radius r in the photo has the undistorted radius
        ``r / (1 + bend r^2)``, r in half diagonals of the photo.
        """
        x1, y1, x2, y2 = self.points.T
        first = 1.0 + bend[:, None] * ((x1**2 + y1**2) / self.unit)
        second = 1.0 + bend[:, None] * ((x2**2 + y2**2) / self.unit)
        middle = 1.0 + bend[:, None] * ((self.middle**2).sum(axis=1) / self.unit)
        scale = focal[:, None]
        across, down = scale * (y1 * second - first * y2), scale * (first * x2 - x1 * second)
        x, y = self.middle.T
        return _unit(across, down, x1 * y2 - y1 * x2), _unit(x, y, scale * middle)


def _unit(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return unit vectors (k, s, 3) of their components, each (s,) or (k, s)."""
    length = np.maximum(np.sqrt(x * x + y * y + z * z), 1e-12)
    return np.stack([x / length, y / length, z / length], axis=-1)


def sines(normal: np.ndarray, middle: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return sines (..., s, d) of the signed angles of segments against `directions` (..., 3, d).

    `normal` and `middle` (..., s, 3) are those of `Segments.rays`, directions unit vectors.
    """
    reach = np.sqrt(np.maximum(1.0 - (middle @ directions) ** 2, 1e-9))
    return np.asarray(np.clip(normal @ directions / reach, -1.0, 1.0))


def residuals(normal: np.ndarray, middle: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the signed angles, radians, whose sines :func:`sines` returns."""
    return np.asarray(np.arcsin(sines(normal, middle, directions)))


def weighted_segments(
    lines: np.ndarray, size: tuple[int, int], labels: np.ndarray | None
) -> Segments:
    """Return the segments (n, 4) of a photo of `size` (height, width) and of its mask, weighted.

    Long segments weigh more than short ones. Borders between surfaces weigh more than segments on a
    floor (herringbone, rugs) or on other things. The many parallel segments of a pattern (trellis
    wallpaper, diagonal tiles) weigh less than as many single ones.
    """
    rows, columns = size
    weight = _label_weight(lines, labels, size)
    noise, level = np.full(len(lines), CAMERA.end_noise_px), np.zeros(len(lines), dtype=bool)
    if labels is not None:
        small = cv2.resize(labels, (columns, rows), interpolation=cv2.INTER_NEAREST)
        borders = border_lines(small)
        lines = np.vstack([lines, borders])
        weight = np.concatenate([weight, np.full(len(borders), CAMERA.border_weight)])
        noise = np.concatenate([noise, np.full(len(borders), CAMERA.border_noise_px)])
        level = np.concatenate([level, np.ones(len(borders), dtype=bool)])
    weight = weight * np.sqrt(np.minimum(_lengths(lines) / columns, 0.3) / 0.06)
    weight = weight / np.sqrt(1.0 + _neighbours(lines, columns) / CAMERA.crowd)
    return Segments(lines, ((columns - 1) / 2, (rows - 1) / 2), weight, noise, level)


def _neighbours(lines: np.ndarray, columns: int) -> np.ndarray:
    """Return how many other segments are near and nearly parallel, Gaussian counts (n,) float64."""
    middle = (lines[:, :2] + lines[:, 2:]) / (2.0 * columns)
    along = lines[:, 2:] - lines[:, :2]
    angle = np.arctan2(along[:, 1], along[:, 0])
    turn = np.abs((angle[:, None] - angle + np.pi / 2) % np.pi - np.pi / 2) / CAMERA.crowd_angle
    apart = ((middle[:, None] - middle) ** 2).sum(axis=-1) / CAMERA.crowd_reach**2
    return np.asarray(np.exp(-0.5 * (apart + turn**2)).sum(axis=1) - 1.0)


def _label_weight(
    lines: np.ndarray, labels: np.ndarray | None, shape: tuple[int, int]
) -> np.ndarray:
    """Return each segment's weight by the labels on its two sides.

    `CAMERA.border_weight` between wall, floor and ceiling; 0.5 on floors and things; else 1.
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
        side_labels = labels[y.astype(int), x.astype(int)]
        sides.append(side_labels)
        other &= np.isin(side_labels, (OTHER, IGNORE)).mean(axis=0) > 0.5
        floor &= (side_labels == FLOOR).mean(axis=0) > 0.5
    border = (sides[0] != sides[1]) & (np.isin(sides, (FLOOR, WALL, CEILING)).all(axis=0))
    weight = np.where(other | floor, 0.5, 1.0)
    return np.where(border.mean(axis=0) > 0.5, CAMERA.border_weight, weight)
