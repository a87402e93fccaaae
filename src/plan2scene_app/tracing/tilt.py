"""How a photographed page is tilted, by the plan's own lines where its edges are not in the photo.

Lines of a plan have two directions at right angles. The rotation of the page is sought for which
the lines, carried back onto the page, lie along these.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

from plan2scene.photos.camera.lines import detect_segments
from plan2scene_app.tracing.sheet import SHEET, Sheet


@dataclass(frozen=True)
class TiltSettings:
    """Constants of tilted pages. Source: set by hand on simulated photos of four plans."""

    side_px: int = 1200  #: longer side that the page is reduced to
    shortest: float = 0.03  #: shortest line that counts, share of the longer side
    least_lines: int = 12
    straight: float = 0.02  #: sine of an angle below which a line lies along a direction
    least: float = 1.5  #: degrees of tilt below which a page is left as it is, ...
    most: float = 35.0  #: ... or above which the estimate is not believed
    gain: float = 0.1  #: least share of the lines' length that lies along only after the rotation


TILT = TiltSettings()


def find_tilt(page: np.ndarray) -> Sheet | None:
    """Return a page (h, w, 3) uint8 that a camera saw from aside as a sheet; None if it did not.

    The sheet holds the whole page, so its corners may lie beyond the picture.
    """
    zoom = min(1.0, TILT.side_px / max(page.shape[:2]))
    small = cv2.resize(page, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    height, width = small.shape[:2]
    longer = max(height, width)
    lines = detect_segments(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY)).reshape(-1, 2, 2)
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    lines = lines[lengths >= TILT.shortest * longer]
    lengths = lengths[lengths >= TILT.shortest * longer]
    if len(lines) < TILT.least_lines:
        return None
    middle = np.array([width - 1, height - 1]) / 2
    ends = (lines - middle) / (SHEET.focal * longer)
    weights = np.sqrt(lengths / lengths.mean())

    def off(turn: np.ndarray) -> np.ndarray:
        start, end = np.moveaxis(_on_page(ends, turn), 1, 0)
        return np.asarray(np.sin(2 * np.arctan2(*(end - start).T[::-1])) / 2)

    def along(turn: np.ndarray) -> float:
        return float(np.average(np.abs(off(turn)) < TILT.straight, weights=lengths))

    first = np.array([0.0, 0.0, _main_direction(lines, lengths)])
    found = least_squares(
        lambda turn: weights * off(turn), first, loss="soft_l1", f_scale=TILT.straight
    ).x
    tilt = np.degrees(np.arccos(_rotation(found)[2, 2]))
    if not TILT.least <= tilt <= TILT.most or along(found) < along(first) + TILT.gain:
        return None
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    flat = _on_page((corners - middle) / (SHEET.focal * longer), found)
    (left, top), (right, bottom) = flat.min(axis=0), flat.max(axis=0)
    box = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    rays = np.c_[box, np.ones(4)] @ _rotation(found).T
    seen = rays[:, :2] / rays[:, 2:] * SHEET.focal * longer + middle
    size = np.array([right - left, bottom - top]) * SHEET.focal * longer / zoom
    return Sheet((seen + 0.5) / zoom - 0.5, (round(float(size[0])), round(float(size[1]))))


def _rotation(turn: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) of a page by angles about its own x, y and z, radians."""
    tilt = cv2.Rodrigues(np.array([turn[0], turn[1], 0.0]))[0]
    return np.asarray(tilt @ cv2.Rodrigues(np.array([0.0, 0.0, turn[2]]))[0])


def _on_page(points: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return places (..., 2) on a page at distance 1 that the camera sees at `points` (..., 2)."""
    rays = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1) @ _rotation(turn)
    return np.asarray(rays[..., :2] / np.maximum(rays[..., 2:], 1e-3))


def _main_direction(lines: np.ndarray, lengths: np.ndarray) -> float:
    """Return the angle, -pi/4 to pi/4, along or across which most of the lines' length lies."""
    angle = np.arctan2(*(lines[:, 1] - lines[:, 0]).T[::-1])
    return float(np.angle((lengths * np.exp(4j * angle)).sum()) / 4)
