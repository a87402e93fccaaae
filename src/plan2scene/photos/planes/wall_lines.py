"""Walls that the feet and tops seen in a photo suggest, in plan view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.photos.planes.wall_borders import N_BINS, Borders

#: `WallLine.axis` of a wall that faces neither Manhattan direction.
OWN = 2
MAX_CANDIDATES = 8
#: Bins with a foot or top that suggest a wall.
MIN_SUPPORT = 4
UNSEEN_DISTANCES_M = (3.0, 2.2, 1.6, 1.1, 0.7, 0.4)
DISTANCE_RANGE_M = (0.3, 15.0)
#: Cosine to a wall's direction below which no wall is believed (about 85 degrees from its normal).
MIN_FACING = 0.08
#: A wall with a normal of its own: neighbouring bins that must show a straight foot, how far from
#: straight (radians as seen), least angle to the Manhattan directions, and how many are kept.
OWN_BINS = N_BINS // 10
OWN_NOISE = np.radians(0.4)
OWN_ANGLE = np.radians(12.0)
MAX_OWN = 4


@dataclass(frozen=True)
class WallLine:
    """The wall ``outward . (x, z) = distance``, metres from the camera.

    `outward` is a unit vector away from the camera; `seen` tells whether the wall's foot or top
    was seen.
    """

    outward: tuple[float, float]
    distance: float
    seen: bool

    @property
    def axis(self) -> int:
        """Return 0 for a wall x = +-d, 1 for z = +-d, `OWN` for another."""
        return next((axis for axis in (0, 1) if abs(self.outward[axis]) == 1.0), OWN)

    def meets(self, other: WallLine) -> np.ndarray | None:
        """Return the corner (x, z) with another wall; None for (nearly) parallel ones."""
        normals = np.array([self.outward, other.outward])
        if abs(float(np.linalg.det(normals))) < 0.1:
            return None
        return np.asarray(np.linalg.solve(normals, [self.distance, other.distance]))


#: Outward directions of Manhattan walls.
DIRECTIONS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
#: Walls for where neither foot nor top is seen: the farthest that no wall pixel contradicts fits.
UNSEEN_LINES = tuple(
    WallLine(outward, distance, False) for outward in DIRECTIONS for distance in UNSEEN_DISTANCES_M
)


def likely_walls(borders: Borders, distances: np.ndarray) -> list[WallLine]:
    """Return the walls that most feet and tops lie on, the best supported first.

    `distances` (b, 2) are those of foot and top from the camera on the plan, metres, NaN where
    not seen. Walls with a normal of their own come last.
    """
    found: list[tuple[float, WallLine]] = []
    for outward in DIRECTIONS:
        facing = borders.direction @ np.array(outward)
        offset = (distances * facing[:, None])[facing > MIN_FACING]
        offset = np.sort(offset[~np.isnan(offset)])
        low, high = DISTANCE_RANGE_M
        offset = offset[(offset >= low) & (offset <= high)]
        found += [
            (count, WallLine(outward, distance, True))
            for count, distance in _peaks(offset)
            if count >= MIN_SUPPORT
        ]
    found.sort(key=lambda item: -item[0])
    return [line for _, line in found[:MAX_CANDIDATES]] + _own_walls(borders, distances)


def _peaks(offset: np.ndarray) -> list[tuple[int, float]]:
    """Return (count, median) of the densest groups of sorted distances within +-6 %."""
    groups: list[tuple[int, float]] = []
    left = offset
    while len(left) >= MIN_SUPPORT and len(groups) < 4:
        first = np.searchsorted(left, left / 1.06)
        last = np.searchsorted(left, left * 1.06, side="right")
        best = int(np.argmax(last - first))
        group = left[first[best] : last[best]]
        groups.append((len(group), float(np.median(group))))
        left = np.concatenate([left[: first[best]], left[last[best] :]])
    return groups


def _own_walls(borders: Borders, distances: np.ndarray) -> list[WallLine]:
    """Return walls with normals of their own: straight feet along a third direction.

    Tops are not asked: masks round off the corners of a ceiling, where nothing stands before it.
    """
    reach = distances[:, 0]
    points = borders.direction * reach[:, None]
    known = np.isfinite(reach) & (reach < DISTANCE_RANGE_M[1])
    found: list[tuple[int, WallLine]] = []
    for start in range(0, N_BINS - OWN_BINS + 1, OWN_BINS // 4):
        inside = known.copy()
        inside[:start] = inside[start + OWN_BINS :] = False
        if inside.sum() < 0.8 * OWN_BINS:
            continue
        line = _straight(points[inside])
        if line is None:
            continue
        facing = borders.direction @ np.array(line.outward)
        expected = line.distance / np.where(facing > MIN_FACING, facing, np.nan)
        off = np.abs(np.arctan(borders.foot) - np.arctan(borders.foot * reach / expected))
        if (off[inside] < OWN_NOISE).mean() > 0.8:
            found.append((int((known & (off < 2 * OWN_NOISE)).sum()), line))
    found.sort(key=lambda item: -item[0])
    kept: list[WallLine] = []
    for _, line in found:
        if len(kept) < MAX_OWN and not any(_alike(line, other) for other in kept):
            kept.append(line)
    return kept


def _straight(points: np.ndarray) -> WallLine | None:
    """Return the line through points (n, 2); None for one along a Manhattan direction."""
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre, full_matrices=False)[2][1]
    distance = float(normal @ centre)
    if distance < 0:
        normal, distance = -normal, -distance
    low, high = DISTANCE_RANGE_M
    if np.abs(normal).max() > np.cos(OWN_ANGLE) or not low <= distance <= high:
        return None
    return WallLine((float(normal[0]), float(normal[1])), distance, True)


def _alike(line: WallLine, other: WallLine) -> bool:
    """Tell whether two walls are one: within 8 degrees and 8 % of the distance."""
    turn = float(np.dot(line.outward, other.outward))
    return turn > np.cos(np.radians(8.0)) and abs(line.distance / other.distance - 1) < 0.08
