"""The part of a picture that the plan is on, turned straight and brought to one size."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.labels import DOOR, OUTSIDE, PASSAGE, WINDOW
from plan2scene_app.tracing.scale import DOOR_WIDTH

#: Pixels a metre that the network is at its best at, and the most pixels of a side.
PPM, LARGEST = 32.0, 1280
#: Metres of paper kept around a plan.
AROUND = 1.2
#: Metres of a home's longer side, and how far (natural logarithm) homes are from it.
USUAL_SIZE, SIZE_SPREAD = 11.0, 0.4
#: Turns below this (degrees) stay.
LEAST_TURN = 0.25


@dataclass(frozen=True)
class Frame:
    """A straightened part of a picture; `matrix` (2, 3) takes the picture's pixels to its own."""

    image: np.ndarray  #: (h, w, 3) uint8
    matrix: np.ndarray

    @property
    def zoom(self) -> float:
        """Pixels of the frame for one of the picture."""
        return float(np.sqrt(abs(np.linalg.det(self.matrix[:, :2]))))

    def of_picture(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 2) of the picture in the frame."""
        return np.asarray(points @ self.matrix[:, :2].T + self.matrix[:, 2])

    def to_picture(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 2) of the frame in the picture."""
        return np.asarray((points - self.matrix[:, 2]) @ np.linalg.inv(self.matrix[:, :2]).T)


def whole(image: np.ndarray, long_side: int) -> Frame:
    """Return a whole picture with its longer side at `long_side` pixels."""
    zoom = long_side / max(image.shape[:2])
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how)
    return Frame(small, np.array([[zoom, 0, 0], [0, zoom, 0]], float))


def main_direction(walls: np.ndarray) -> float:
    """Return by how many degrees, -45 to 45, walls (h, w; probabilities) are turned clockwise."""
    smooth = cv2.GaussianBlur(walls.astype(np.float32), (0, 0), 1.2)
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    strength = gx**2 + gy**2
    angles = np.degrees(np.arctan2(gy, gx)) % 90
    counts, edges = np.histogram(angles, bins=360, range=(0, 90), weights=strength)
    kernel = np.exp(-0.5 * (np.arange(-12, 13) / 4) ** 2)
    padded = np.concatenate([counts[-12:], counts, counts[:12]])
    peak = edges[int(np.convolve(padded, kernel, "valid").argmax())]
    off = (angles - peak + 45) % 90 - 45
    near = np.abs(off) < 3
    total = float(strength[near].sum())
    angle = peak + (float((off * strength)[near].sum()) / total if total else 0.0)
    return float((angle + 45) % 90 - 45)


def first_scale(structure: np.ndarray) -> float:
    """Return about how many pixels a metre of a structure (h, w) has: by its doors and its size."""
    places, count = ndimage.label(structure == DOOR, np.ones((3, 3)))
    widths = [max(b.stop - b.start for b in box) for box in ndimage.find_objects(places, count)]
    widths = [width for width in widths if width >= 6]
    rows, columns = np.nonzero(_largest_part(structure != OUTSIDE))
    size = max(float(np.ptp(rows)), float(np.ptp(columns)), 1.0) if len(rows) else 1.0
    usual, spread = np.log(size / USUAL_SIZE), SIZE_SPREAD
    if not widths:
        return float(np.exp(usual))
    # Half of a door is found more often than two doors as one.
    doors, unsure = np.log(np.percentile(widths, 70) / DOOR_WIDTH), 0.15 + 0.4 / len(widths)
    weights = np.array([1 / spread**2, 1 / unsure**2])
    return float(np.exp((weights * [usual, doors]).sum() / weights.sum()))


def straightened(image: np.ndarray, first: Frame, structure: np.ndarray, angle: float) -> Frame:
    """Return the plan of a picture at the network's size, by its structure in a first frame."""
    shown = np.isin(structure, (DOOR, WINDOW, PASSAGE)) | (structure > PASSAGE) | (structure == 1)
    rows, columns = np.nonzero(_largest_part(shown))
    points = first.to_picture(np.c_[columns, rows].astype(float))
    ppm = first_scale(structure) / first.zoom
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, s], [-s, c]]) if abs(angle) >= LEAST_TURN else np.eye(2)
    turned = points @ turn.T
    low, high = turned.min(0) - AROUND * ppm, turned.max(0) + AROUND * ppm
    zoom = min(PPM / ppm, LARGEST / float((high - low).max()), 3.0)
    return warped(image, turn, low, high, zoom)


def warped(
    image: np.ndarray, turn: np.ndarray, low: np.ndarray, high: np.ndarray, zoom: float
) -> Frame:
    """Return what lies between two corners of a turned picture, `zoom` times as large."""
    size = np.maximum(32, np.ceil((high - low) * zoom)).astype(int)
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how)
    matrix = np.c_[turn, -low * zoom]
    paper = np.median(np.r_[image[0], image[-1], image[:, 0], image[:, -1]], axis=0)
    seen = cv2.warpAffine(
        small,
        matrix,
        (int(size[0]), int(size[1])),
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=[float(v) for v in paper],
    )
    return Frame(seen, np.c_[turn * zoom, -low * zoom])


def _largest_part(shown: np.ndarray) -> np.ndarray:
    """Return the pixels of parts that are not small beside the largest (letters, stains)."""
    places, count = ndimage.label(shown, np.ones((3, 3)))
    if count < 2:
        return shown
    sizes = np.bincount(places.ravel())[1:]
    kept = np.flatnonzero(sizes >= 0.12 * sizes.max()) + 1
    return np.isin(places, kept)
