"""What a label mask and its lines say about walls, by azimuth: feet, tops, facing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.camera.vanishing import Segments, residuals
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL

#: Azimuth bins over the width of a photo.
N_BINS = 240
#: Widest strip of other things (cornice, skirting) between a wall and its floor or ceiling, share
#: of the photo's height.
GAP_SHARE = 0.03
#: Angle within which a segment runs along an axis, radians.
SEGMENT_NOISE = np.radians(2.0)


@dataclass(frozen=True)
class Borders:
    """Borders of the wall mask per azimuth bin."""

    #: (b, 2) float64: Unit (x, z) of the bin's middle.
    direction: np.ndarray
    #: foot, top: (b,) float64: Slope (rise over horizontal distance) of the wall's foot (< 0) and
    #: top (> 0); NaN where not seen.
    foot: np.ndarray
    top: np.ndarray
    #: (b, 2) float64: Lowest and highest slope of wall pixels; NaN where there are none.
    reach: np.ndarray
    #: (h, w) int: Bin of each pixel.
    bins: np.ndarray

    @property
    def azimuth(self) -> np.ndarray:
        """Return the azimuth (b,) of each bin's middle, radians from z towards x."""
        return np.arctan2(self.direction[:, 0], self.direction[:, 1])


def find_borders(labels: np.ndarray, camera: Camera) -> Borders:
    """Return feet and tops of the wall mask by azimuth."""
    rows, columns = labels.shape
    x, y = np.meshgrid(np.arange(columns, dtype=np.float64), np.arange(rows, dtype=np.float64))
    rays = camera.rays(np.stack([x, y], axis=-1))
    azimuth = np.arctan2(rays[..., 0], rays[..., 2])
    slope = rays[..., 1] / np.maximum(np.hypot(rays[..., 0], rays[..., 2]), 1e-9)
    low, high = float(azimuth.min()), float(azimuth.max())
    width = max((high - low) / N_BINS, 1e-9)
    bins = np.clip(((azimuth - low) / width).astype(int), 0, N_BINS - 1)
    middle = low + (np.arange(N_BINS) + 0.5) * width
    wall = labels == WALL
    gap = max(1, round(GAP_SHARE * rows))
    foot = _borders_on(labels, FLOOR, gap)
    top = _borders_on(labels[::-1], CEILING, gap)[::-1]
    foot &= slope < -0.02
    top &= slope > 0.02
    reach = np.stack([_by_bin(bins, slope, wall, 2.0), _by_bin(bins, slope, wall, 98.0)], axis=1)
    return Borders(
        direction=np.stack([np.sin(middle), np.cos(middle)], axis=1),
        foot=_by_bin(bins, slope, foot, 50.0),
        top=_by_bin(bins, slope, top, 50.0),
        reach=reach,
        bins=bins,
    )


def _borders_on(labels: np.ndarray, below: int, gap: int) -> np.ndarray:
    """Return the wall pixels (h, w) with label `below` under them, at most `gap` rows further.

    What is between is another thing or ignored: skirting, cornice, a cable.
    """
    wall = labels == WALL
    found = np.zeros_like(wall)
    between = wall[:-1].copy()
    for step in range(1, gap + 1):
        reached = labels[step:]
        found[:-step] |= between & (reached == below)
        between = (between & ((reached == OTHER) | (reached == IGNORE)))[:-1]
    return found


def _by_bin(bins: np.ndarray, values: np.ndarray, chosen: np.ndarray, q: float) -> np.ndarray:
    """Return the q-th percentile of the chosen values of each bin, NaN where there are none."""
    result = np.full(N_BINS, np.nan)
    where, value = bins[chosen], values[chosen]
    order = np.lexsort((value, where))
    where, value = where[order], value[order]
    found, start, count = np.unique(where, return_index=True, return_counts=True)
    result[found] = value[start + ((count - 1) * q / 100.0).round().astype(int)]
    return result


def facing_votes(
    segments: np.ndarray | None, labels: np.ndarray, camera: Camera, bins: np.ndarray
) -> np.ndarray:
    """Return (b, 2): horizontal segments along z and along x on walls, by bin.

    A segment along z lies on a wall that faces x (axis 0), one along x on a wall that faces z.
    """
    votes = np.zeros((N_BINS, 2))
    if segments is None or not len(segments):
        return votes
    lines = Segments(segments, (camera.cx, camera.cy), np.ones(len(segments)))
    off = np.abs(residuals(*lines.rays(camera.focal_px), camera.matrix))
    rows, columns = labels.shape
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / lines.length[:, None]
    middle = start + along / 2
    touches = np.zeros(len(segments), dtype=bool)
    for side in (-4.0, 4.0):
        point = np.round(middle + side * across).astype(int)
        x, y = np.clip(point[:, 0], 0, columns - 1), np.clip(point[:, 1], 0, rows - 1)
        touches |= labels[y, x] == WALL
    for axis, other in ((2, 0), (0, 2)):
        clear = (off[:, axis] < SEGMENT_NOISE) & (off[:, other] > 3 * SEGMENT_NOISE)
        clear &= touches & (off[:, 1] > 3 * SEGMENT_NOISE)
        for first, last in segments[clear].reshape(-1, 2, 2).round().astype(int):
            ends = [
                bins[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)] for x, y in (first, last)
            ]
            votes[min(ends) : max(ends) + 1, 0 if axis == 2 else 1] += 1.0
    return votes
