"""Straight line segments of a photo, behind one function."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

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
