"""Straight line segments of a photo, behind one function."""

from __future__ import annotations

import cv2
import numpy as np

#: Segments shorter than this many pixels carry no direction and are dropped.
MIN_LENGTH = 12.0


def detect_segments(grey: np.ndarray, min_length: float = MIN_LENGTH) -> np.ndarray:
    """Return the line segments of a grey image, longest first.

    Parameters
    ----------
    grey : (h, w) uint8
        The image; a colour photo's luma does.
    min_length : float
        Shortest segment kept, pixels.

    Returns
    -------
    (n, 4) float64
        ``x1 y1 x2 y2`` in pixels, (0, 0) the centre of the top left pixel.

    Notes
    -----
    OpenCV's detector (von Gioi et al., LSD, 2012) where the wheel has it; otherwise Hough
    segments whose direction is refined by least squares on the edge pixels around them.
    """
    if hasattr(cv2, "createLineSegmentDetector"):
        found = cv2.createLineSegmentDetector().detect(np.ascontiguousarray(grey))[0]
        segments = np.zeros((0, 4)) if found is None else found.reshape(-1, 4).astype(np.float64)
    else:
        segments = hough_segments(grey, min_length)
    length = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    order = np.argsort(-length, kind="stable")
    return segments[order[length[order] >= min_length]]


def hough_segments(grey: np.ndarray, min_length: float = MIN_LENGTH) -> np.ndarray:
    """Return Hough segments refined on their edge pixels; same units as `detect_segments`."""
    smooth = cv2.GaussianBlur(grey, (5, 5), 1.0)
    edges = cv2.Canny(smooth, 40, 110, L2gradient=True)
    found = cv2.HoughLinesP(
        edges, 1.0, np.pi / 360, threshold=25, minLineLength=max(min_length, 20.0), maxLineGap=3
    )
    if found is None:
        return np.zeros((0, 4))
    rows, columns = np.nonzero(edges)
    points = np.stack([columns, rows], axis=1).astype(np.float64)
    refined = [_refine(segment, points) for segment in found.reshape(-1, 4).astype(np.float64)]
    return np.array(refined).reshape(-1, 4)


def _refine(segment: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the least-squares segment through the edge points within 1.5 px of `segment`."""
    start, end = segment[:2], segment[2:]
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    offset = points - start
    position = offset @ along
    distance = offset @ np.array([-along[1], along[0]])
    near = (np.abs(distance) <= 1.5) & (position >= -1.0) & (position <= length + 1.0)
    if near.sum() < 6:
        return segment
    inside = points[near]
    centre = inside.mean(axis=0)
    direction = np.linalg.svd(inside - centre, full_matrices=False)[2][0]
    direction = direction if direction @ along >= 0 else -direction
    reach = (inside - centre) @ direction
    return np.concatenate([centre + reach.min() * direction, centre + reach.max() * direction])
