"""A mask as seen from its camera: labels by azimuth and elevation, and how likely each class is.

In one direction of the plan a room is a stack: floor, wall (and what an opening shows), ceiling.
Sums of log probabilities over elevation, kept for each class, give the likelihood of any stack by
a few look-ups.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.locate.likelihood import N_LABELS

#: Columns of pixels that are looked at, and the bins' sides in radians.
SAMPLED_COLUMNS = 200
AZIMUTH_STEP = np.radians(1.5)
ELEVATION_STEP = np.radians(0.75)
#: Elevations beyond this are left out, radians.
MAX_ELEVATION = np.radians(75.0)
#: No label is less likely than what an 8-bit file rounds to nothing.
LEAST = 0.5 / 255


@dataclass(frozen=True)
class Profile:
    """Labels of a photo by direction, in the photo's Manhattan frame.

    Attributes
    ----------
    azimuth : (a,) float64
        Middle of each column, ``(x, z) = (sin a, cos a)``, radians.
    lowest : float
        Elevation of the lower border of the first row, radians.
    sums : (classes, a, rows + 1) float64
        Sum of the log probability of the labels below each row's lower border, given each class;
        over all rows at the end. Pixels count 1 / all pixels.
    counts : (labels, a, rows) float64
        Share of the photo's pixels with each label.
    """

    azimuth: np.ndarray
    lowest: float
    sums: np.ndarray
    counts: np.ndarray

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.sums.shape[2]) - 1

    def row(self, slope: np.ndarray) -> np.ndarray:
        """Return the (fractional) border of rows at tangents of elevation."""
        rows = (np.arctan(slope) - self.lowest) / ELEVATION_STEP
        return np.asarray(np.clip(rows, 0.0, self.rows))

    def between(
        self, kind: int, column: np.ndarray, low: np.ndarray, high: np.ndarray
    ) -> np.ndarray:
        """Return the log probability (n,) of columns' labels between row borders, given a class."""
        return self._below(kind, column, high) - self._below(kind, column, low)

    def _below(self, kind: int, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        whole = np.minimum(row.astype(np.int64), self.rows - 1)
        sums = self.sums[kind]
        start = sums[column, whole]
        return np.asarray(start + (row - whole) * (sums[column, whole + 1] - start))


def label_counts(
    labels: np.ndarray, camera: Camera, probabilities: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return (labels, a, rows) counts by direction, azimuths (a,) and the lowest elevation.

    `labels` (h, w) uint8; values that are no label count nowhere. With `probabilities`
    (l, h', w') of the same view each pixel counts for every label, by how likely that is.
    """
    step = max(1.0, camera.width / SAMPLED_COLUMNS)
    columns = np.arange(step / 2, camera.width, step)
    rows = np.arange(step / 2, camera.height, step)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    values = labels[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    rays = camera.rays(pixels - 0.5)
    azimuth = np.arctan2(rays[:, 0], rays[:, 2])
    elevation = np.arcsin(np.clip(rays[:, 1], -1.0, 1.0))
    kept = (np.abs(elevation) < MAX_ELEVATION) & (values < N_LABELS)
    if not kept.any():
        return np.zeros((N_LABELS, 1, 1)), np.zeros(1), 0.0
    first = np.floor(azimuth[kept].min() / AZIMUTH_STEP)
    lowest = np.floor(elevation[kept].min() / ELEVATION_STEP)
    a = (azimuth[kept] / AZIMUTH_STEP - first).astype(int)
    e = (elevation[kept] / ELEVATION_STEP - lowest).astype(int)
    shape = (N_LABELS, int(a.max()) + 1, int(e.max()) + 1)
    counts = np.zeros(shape)
    if probabilities is None:
        np.add.at(counts, (values[kept].astype(int), a, e), 1.0)
    else:
        row, column = (
            np.minimum(at * new / old, new - 1).astype(int)
            for at, new, old in zip(
                pixels[kept].T[::-1], probabilities.shape[1:], labels.shape, strict=True
            )
        )
        likely = np.maximum(probabilities[:, row, column], LEAST)
        likely /= likely.sum(axis=0)
        for label, weights in enumerate(likely):
            np.add.at(counts[label], (a, e), weights)
    counts /= kept.sum()
    middles = (first + 0.5 + np.arange(shape[1])) * AZIMUTH_STEP
    return counts, middles, float(lowest * ELEVATION_STEP)


def make_profile(
    labels: np.ndarray,
    camera: Camera,
    table: np.ndarray,
    blur: float = 0.0,
    probabilities: np.ndarray | None = None,
) -> Profile:
    """Return the profile of a mask; `table` (classes, labels) log probabilities.

    `blur` is the spread in radians by which directions are uncertain; `probabilities` as of
    `label_counts`.
    """
    counts, azimuth, lowest = label_counts(labels, camera, probabilities)
    log = np.tensordot(table, counts, axes=(1, 0))
    if blur > 0.0:
        log = np.stack([_blurred(part, blur) for part in log])
    sums = np.concatenate([np.zeros((*log.shape[:2], 1)), np.cumsum(log, axis=2)], axis=2)
    return Profile(azimuth, lowest, sums, counts)


def _blurred(values: np.ndarray, spread: float) -> np.ndarray:
    """Return (a, rows) values blurred by a Gaussian of that spread, radians."""
    return np.asarray(
        cv2.GaussianBlur(
            values,
            (0, 0),
            sigmaX=spread / ELEVATION_STEP,
            sigmaY=spread / AZIMUTH_STEP,
            borderType=cv2.BORDER_REPLICATE,
        )
    )
