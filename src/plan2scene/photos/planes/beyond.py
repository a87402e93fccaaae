"""What a photo shows beyond its room: through a door frame, or farther than the room is long.

For photos whose place in the plan is not known. A door is seen as floor that runs on beyond the
foot of a wall, or as a stretch of wall farther away between two stretches of one wall.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.planes.wall_lines import WallLine

#: How much farther than a wall what is seen through its door is, metres.
MIN_STEP_M = 0.3
#: Widest opening that counts as a door, metres.
MAX_DOOR_M = 2.6
#: Margin of distances: share, and metres.
MARGIN, MARGIN_M = 0.1, 0.1
#: Less than this share of a surface left, all of it is kept: its distances are wrong.
MIN_LEFT = 0.1


def room_reach(
    lines: Sequence[WallLine], path: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return metres (b,) that a room reaches in each direction, inf where no wall tells it.

    With the directions (b,) bool that look through a door whose wall goes on on both sides.

    Parameters
    ----------
    lines : sequence of WallLine
        Walls of the photo.
    path : (b,) int
        Wall that each bin of azimuth meets; -1 for none.
    direction : (b, 2) float64
        Unit (x, z) of each bin's middle.
    """
    seen = np.array([*(line.seen for line in lines), False])
    outward = np.array([line.outward for line in lines]).reshape(-1, 2)
    distance = np.array([line.distance for line in lines])
    away = distance / np.maximum(direction @ outward.T, 1e-3)
    met = np.column_stack([away, np.zeros(len(path))])[np.arange(len(path)), path]
    reach = np.where(seen[path], met, np.inf)
    through = np.zeros(len(path), bool)
    for index in np.flatnonzero(seen):
        own = np.flatnonzero(path == index)
        between = np.arange(own[0], own[-1] + 1) if len(own) else own
        for run in _runs(between[met[between] > away[between, index] + MIN_STEP_M]):
            ends = direction[run[[0, -1]]] * away[run[[0, -1]], index, None]
            if np.linalg.norm(ends[1] - ends[0]) < MAX_DOOR_M:
                reach[run] = np.minimum(reach[run], away[run, index])
                through[run] = True
    return reach, through


def within_room(
    mask: np.ndarray, camera: Camera, drop_m: float, reach: np.ndarray, longest_m: float
) -> np.ndarray:
    """Return the pixels (h, w) bool of a floor's or ceiling's mask that are not beyond the room.

    Parameters
    ----------
    mask : (h, w) bool
        Pixels of the surface.
    drop_m : float
        How far it is below the camera, metres; negative for a ceiling.
    reach : (h, w) float64
        `room_reach` of each pixel's direction.
    longest_m : float
        Longest line in the room, metres.
    """
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return mask
    rays = camera.rays(np.stack([columns, rows], axis=-1))
    fall = np.maximum(-rays[:, 1] * np.sign(drop_m), 1e-9)
    away = abs(drop_m) * np.hypot(rays[:, 0], rays[:, 2]) / fall
    limit = np.minimum(reach[rows, columns] + MARGIN_M, longest_m * (1 + MARGIN))
    near = away < limit
    if near.mean() < MIN_LEFT:
        return mask
    kept = np.zeros_like(mask)
    kept[rows[near], columns[near]] = True
    return kept


def _runs(numbers: np.ndarray) -> list[np.ndarray]:
    """Return sorted integers as runs of consecutive ones."""
    return [run for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1) if len(run)]
