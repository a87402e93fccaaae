"""Line segments of a photo and of its label mask, and what each tells of the camera.

A segment and the camera centre span a plane with unit normal n. A line along the unit direction
d (camera axes) gives n . d = 0; the residual used here is the angle by which the segment would
have to turn about the ray m through its middle, ``asin(|n . d| / |m x d|)``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.io import read_parquet, write_parquet
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL

#: The segments' file in a masks folder.
SEGMENTS = "segments.parquet"
#: Photos are reduced to this width or height (the larger) before the camera's segments are found.
WORKING_SIDE = 800
#: Segments that give the camera, the longest.
MAX_SEGMENTS = 320
#: Segments shorter than this many pixels carry no direction and are dropped.
MIN_LENGTH = 12.0
#: Lines along label borders: at most so many, shortest length and width of the strip whose border
#: pixels belong to one line, as shares of the photo's width.
MAX_BORDERS = 12
BORDER_LENGTH = 0.08
BORDER_WIDTH = 0.01


def detect_segments(grey: np.ndarray, min_length: float = MIN_LENGTH) -> np.ndarray:
    """Return the line segments of a grey image, longest first.

    `grey` is (h, w) uint8, `min_length` pixels; the segments are (n, 4) float64, ``x1 y1 x2 y2``
    in pixels, (0, 0) the centre of the top left pixel. OpenCV's detector (von Gioi et al., LSD,
    2012).
    """
    found = cv2.createLineSegmentDetector().detect(np.ascontiguousarray(grey))[0]
    segments = np.zeros((0, 4)) if found is None else found.reshape(-1, 4).astype(np.float64)
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    order = np.argsort(-length, kind="stable")
    return segments[order[length[order] >= min_length]]


#: Columns of segments.parquet that hold a segment's ends.
_ENDS = ["x1", "y1", "x2", "y2"]


@dataclass(frozen=True, eq=False)
class PhotoSegments:
    """Line segments of a photo, ``x1 y1 x2 y2``, the longest first; the masks stage finds them."""

    #: (height, width) of the reduced photo that `camera` was found in.
    size: tuple[int, int]
    #: (n, 4) float64, pixels of the reduced photo: they give the camera.
    camera: np.ndarray
    #: (m, 4) float64, pixels of the photo: long ones, which tell the way that a wall faces.
    walls: np.ndarray
    #: Pixels of the photo per pixel of the reduced one.
    scale: float = 1.0


def find_segments(image: np.ndarray) -> PhotoSegments:
    """Return the line segments of a photo (h, w, 3) uint8 sRGB."""
    height, width = image.shape[:2]
    scale = min(1.0, WORKING_SIDE / max(height, width))
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    whole = detect_segments(grey, width / 25)
    if scale < 1.0:
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    camera = detect_segments(grey)[:MAX_SEGMENTS]
    return PhotoSegments((grey.shape[0], grey.shape[1]), camera, whole, width / grey.shape[1])


def write_segments(path: str | Path, segments: Mapping[str, PhotoSegments]) -> None:
    """Write the segments of a house's photos, in pixels of the photos (docs/conventions.md)."""
    import pandas as pd

    frames = []
    for photo, found in segments.items():
        camera = (found.camera + 0.5) * found.scale - 0.5
        for use, ends in (("camera", camera), ("walls", found.walls)):
            frame = pd.DataFrame(ends.astype(np.float32), columns=_ENDS)
            frames.append(frame.assign(photo=photo, use=use))
    table = pd.concat(frames) if frames else pd.DataFrame(columns=["photo", "use", *_ENDS])
    write_parquet(path, table[["photo", "use", *_ENDS]], {})


def read_segments(path: str | Path, use: str) -> dict[str, np.ndarray]:
    """Return photo -> segments (n, 4) float64, pixels, for a use: ``camera`` or ``walls``."""
    table, _ = read_parquet(path)
    return {
        str(photo): rows[_ENDS].to_numpy(np.float64)
        for photo, rows in table[table["use"] == use].groupby("photo")
    }


def border_lines(labels: np.ndarray, pairs: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return long lines along the borders between labels, however ragged; longest first.

    `labels` is (h, w) uint8, `pairs` are those whose common borders count. The lines are (n, 4)
    float64, ``x1 y1 x2 y2`` in pixels: least-squares lines through stretches of border, at most
    `MAX_BORDERS`.
    """
    edges = np.zeros(labels.shape, dtype=np.uint8)
    for first, second in pairs:
        for one, other in ((first, second), (second, first)):
            near = cv2.dilate((labels == other).astype(np.uint8), np.ones((3, 3), np.uint8))
            edges |= near & (labels == one).astype(np.uint8)
    size = labels.shape[1]
    lines: list[np.ndarray] = []
    for _ in range(MAX_BORDERS):
        found = cv2.HoughLinesP(
            edges,
            1.0,
            np.pi / 180,
            threshold=max(8, round(0.03 * size)),
            minLineLength=BORDER_LENGTH * size,
            maxLineGap=0.04 * size,
        )
        if found is None:
            break
        segments = found.reshape(-1, 4).astype(np.float64)
        length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
        rows, columns = np.nonzero(edges)
        points = np.stack([columns, rows], axis=1).astype(np.float64)
        line, used = _refine(segments[int(np.argmax(length))], points, BORDER_WIDTH * size)
        edges[rows[used], columns[used]] = 0
        lines.append(line)
        if not used.any():
            break
    return np.array(lines).reshape(-1, 4)


def _refine(segment: np.ndarray, points: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the least-squares segment through the points within `width` px, and those points.

    The points come as a mask (n,) bool.
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


#: Angular noise of a segment: END_NOISE pixels over its length, and never below ANGLE_NOISE.
END_NOISE = 1.0
ANGLE_NOISE = np.radians(0.35)
COARSE_NOISE = np.radians(1.6)


class Segments:
    """Segments relative to the principal point with what every hypothesis needs of them.

    Parameters
    ----------
    segments : (s, 4) float64
        ``x1 y1 x2 y2``, pixels.
    centre : (float, float)
        Principal point, the middle of the photo, pixels.
    weight : (s,) float64
        What each segment counts.
    end_noise : (s,) float64 or float
        How far its ends may be off, pixels.
    level : (s,) bool, optional
        Segments known to be horizontal in the world.
    """

    def __init__(
        self,
        segments: np.ndarray,
        centre: tuple[float, float],
        weight: np.ndarray,
        end_noise: np.ndarray | float = END_NOISE,
        level: np.ndarray | None = None,
    ):
        #: (s,) radians added to a segment's angle to the vertical: known horizontal lines.
        self.off_vertical = np.zeros(len(segments)) if level is None else np.where(level, 3.0, 0.0)
        #: Half the photo's diagonal squared: the unit of radii.
        self.unit = max(centre[0] ** 2 + centre[1] ** 2, 1.0)
        shift = np.array([centre[0], centre[1]] * 2)
        self.points = segments - shift
        delta = self.points[:, 2:] - self.points[:, :2]
        self.length = np.maximum(np.hypot(delta[:, 0], delta[:, 1]), 1e-6)
        self.middle = (self.points[:, :2] + self.points[:, 2:]) / 2
        self.slant = np.arctan2(np.abs(delta[:, 0]), np.abs(delta[:, 1]))
        self.weight = weight
        self.noise = np.hypot(end_noise * 2.0 / self.length, ANGLE_NOISE)
        self.coarse_noise = np.hypot(end_noise * 2.0 / self.length, COARSE_NOISE)

    def rays(self, focal: float) -> tuple[np.ndarray, np.ndarray]:
        """Return plane normals n and middle rays m, both (s, 3) unit, for a focal length."""
        normal, middle = self.bent_rays(np.array([focal]), np.zeros(1))
        return normal[0], middle[0]

    def bent_rays(self, focal: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return n and m, both (k, s, 3) unit, for k focal lengths and lens distortions.

        `bend` is that of the division model (Fitzgibbon, CVPR 2001): a point at radius r seen
        through the lens belongs at ``r / (1 + bend r^2)``, r in half diagonals of the photo.
        """
        x1, y1, x2, y2 = self.points.T
        first = 1.0 + bend[:, None] * ((x1**2 + y1**2) / self.unit)
        second = 1.0 + bend[:, None] * ((x2**2 + y2**2) / self.unit)
        middle = 1.0 + bend[:, None] * ((self.middle**2).sum(axis=1) / self.unit)
        scale = focal[:, None]
        level = np.broadcast_to(x1 * y2 - y1 * x2, first.shape)
        across = [scale * (y1 * second - first * y2), scale * (first * x2 - x1 * second)]
        normals = np.dstack([*across, level])
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        ahead = scale * middle
        rays = np.dstack(np.broadcast_arrays(*self.middle.T, ahead))
        return normals, rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def residuals(normal: np.ndarray, middle: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return signed angles (..., s, d), radians, of segments against unit `directions` (..., 3, d).

    `normal` and `middle` (..., s, 3) are those of `Segments.rays`.
    """
    off = normal @ directions
    reach = np.sqrt(np.maximum(1.0 - (middle @ directions) ** 2, 1e-9))
    return np.asarray(np.arcsin(np.clip(off / reach, -1.0, 1.0)))


#: Weight of a line along a border between wall and floor or ceiling, and of the photo's own lines
#: there; how far its ends may be off, pixels.
BORDER_WEIGHT = 2.0
BORDER_NOISE = 4.0
#: Neighbours of nearly the same direction among which a segment still counts in full; how far they
#: may be (share of the photo's width), and their direction (radians).
CROWD = 2.0
CROWD_REACH = 0.2
CROWD_ANGLE = np.radians(8.0)


def weighted_segments(
    lines: np.ndarray, size: tuple[int, int], labels: np.ndarray | None
) -> Segments:
    """Return the segments (n, 4) of a photo of (height, width), and of its mask, with weights.

    Long segments say more than short ones, borders between surfaces more than what lies on a
    floor (herringbone, rugs) or on other things, and the many parallel segments of a pattern
    (trellis wallpaper, diagonal tiles) less than as many single ones.
    """
    rows, columns = size
    weight = _label_weight(lines, labels, size)
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
