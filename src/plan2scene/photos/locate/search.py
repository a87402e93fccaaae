"""Search a room for the pose at which the plan agrees best with a mask: coarse to fine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon

from plan2scene.photos.locate.likelihood import Profile, agreement
from plan2scene.photos.locate.locate_settings import LOCATE, Grid
from plan2scene.photos.locate.plan_view import RoomShape, dominant_direction, look

#: Offsets (x, z) that one step of the refinement tries, in units of the step.
_AROUND = np.array([(i, j) for i in (0, -1, 1) for j in (0, -1, 1)], dtype=np.float64)


@dataclass(frozen=True)
class Hypothesis:
    """The best pose near a peak of one heading in one room."""

    room_id: str
    #: Plan azimuth minus azimuth in the Manhattan frame of the spot's first photo, radians.
    turn: float
    #: x, y, z of the camera, metres.
    position: tuple[float, float, float]
    #: Mean log probability of a pixel's label, plus the weighted log prior of the height.
    score: float


@dataclass(frozen=True)
class HeightPrior:
    """Gaussian prior of a camera's height, metres."""

    mean: float = LOCATE.height_m
    spread: float = LOCATE.height_spread_m

    def log(self, heights: np.ndarray) -> np.ndarray:
        """Return the weighted log prior at heights, as it is added to the score."""
        return np.asarray(-0.5 * LOCATE.prior_weight * ((heights - self.mean) / self.spread) ** 2)


@dataclass(frozen=True)
class View:
    """One photo of a spot: its mask, binned by direction, with a large and a small blur."""

    coarse: Profile
    fine: Profile
    #: Turn of the photo's Manhattan frame minus that of the spot's first photo, quarter turns.
    quarters: int = 0


class RoomSearch:
    """Scores of the poses on a coarse grid of a room against masks; refined on demand."""

    def __init__(
        self,
        shapes: Mapping[str, RoomShape],
        room_id: str,
        polygon: Polygon,
        views: Sequence[View],
        grid: Grid,
    ) -> None:
        """Score the grid against `views`, the photos that were taken from one spot."""
        self._shapes, self.room_id, self._views = shapes, room_id, views
        self._polygon = polygon
        shape = shapes[room_id]
        self._grid = grid_of(polygon, grid)
        heights = [height for height in LOCATE.heights_m if height < 0.9 * shape.height]
        self._heights = np.array(heights or [0.6 * shape.height])
        first = dominant_direction(shape)
        self._turns = [first + quarter * np.pi / 2 for quarter in range(4)]
        coarse = [view.coarse for view in views]
        self._rough = [
            self._scores(coarse, turn, self._grid, self._heights) for turn in self._turns
        ]

    def best(self, prior: HeightPrior) -> list[Hypothesis]:
        """Return the refined peaks of the four headings, the best first."""
        hypotheses = [
            self._refined(turn, point, level, prior)
            for turn, rough in zip(self._turns, self._rough, strict=True)
            for point, level in _peaks(self._grid, rough + prior.log(self._heights))
        ]
        return sorted(hypotheses, key=lambda item: -item.score)

    def best_score(self, prior: HeightPrior) -> float:
        """Return the score of the highest peak on the grid, refined."""
        scores = np.array(self._rough) + prior.log(self._heights)
        turn, point, level = np.unravel_index(int(np.argmax(scores)), scores.shape)
        return self._refined(self._turns[turn], int(point), int(level), prior).score

    def _refined(self, turn: float, point: int, level: int, prior: HeightPrior) -> Hypothesis:
        """Return the pose that a pattern search from a point of the grid reaches.

        The score is not smooth, and it is cheapest to compute for many positions at once, while
        scipy's optimisers try one position at a time.
        """
        inner = self._polygon.buffer(-LOCATE.least_clearance_m)
        highest = self._shapes[self.room_id].height - 0.2
        eye_position = np.array([self._grid[point, 0], self._heights[level], self._grid[point, 1]])
        step, best = LOCATE.first_step_m, -np.inf
        fine = [view.fine for view in self._views]
        while step > LOCATE.last_step_m:
            eyes = eye_position[[0, 2]] + step * _AROUND
            kept = shapely.contains_xy(inner, eyes[:, 0], eyes[:, 1])
            kept[0] = True
            eyes = eyes[kept]
            heights = np.clip(eye_position[1] + step * np.array([0.0, -1.0, 1.0]), 0.4, highest)
            values = self._scores(fine, turn, eyes, heights) + prior.log(heights)
            row, column = np.unravel_index(int(np.argmax(values)), values.shape)
            if values[row, column] <= best + 1e-9:
                step /= 2
                continue
            best = float(values[row, column])
            eye_position = np.array([eyes[row, 0], heights[column], eyes[row, 1]])
            if row == 0 and column == 0:
                step /= 2
        x, y, z = eye_position.tolist()
        return Hypothesis(self.room_id, turn, (x, y, z), best)

    def _scores(
        self, profiles: Sequence[Profile], turn: float, eyes: np.ndarray, heights: np.ndarray
    ) -> np.ndarray:
        """Return the agreement (p, c) of eyes (p, 2) at heights (c,) with the views' profiles.

        The views' agreements are added and divided by the square root of their number, so that the
        random error of a score does not depend on that number.
        """
        total = np.zeros((len(eyes), len(heights)))
        for view, profile in zip(self._views, profiles, strict=True):
            columns = len(profile.azimuth)
            azimuth = profile.azimuth + turn + view.quarters * np.pi / 2
            at, ways = np.repeat(eyes, columns, axis=0), np.tile(azimuth, len(eyes))
            sight = look(self._shapes, self.room_id, at, ways)
            total += agreement(profile, self._shapes, self.room_id, sight, heights)
        return total / np.sqrt(len(profiles))


def grid_of(polygon: Polygon, grid: Grid) -> np.ndarray:
    """Return points (p, 2) of a room where a camera may stand, metres; at least one."""
    inner = polygon.buffer(-LOCATE.clearance_m)
    if not inner.is_empty:
        step = float(np.clip((inner.area / grid.points) ** 0.5, *grid.side_m))
        x0, z0, x1, z1 = inner.bounds
        xs, zs = _ticks(x0, x1, step), _ticks(z0, z1, step)
        points = np.stack(np.meshgrid(xs, zs), axis=-1).reshape(-1, 2)
        inside = shapely.contains_xy(inner, points[:, 0], points[:, 1])
        if inside.any():
            return np.asarray(points[inside])
    point = (polygon if inner.is_empty else inner).representative_point()
    return np.array([[point.x, point.y]])


def _ticks(low: float, high: float, step: float) -> np.ndarray:
    """Cut an interval into equal parts about `step` long and return their midpoints."""
    count = max(1, round((high - low) / step))
    return low + (np.arange(count) + 0.5) * (high - low) / count


def _peaks(grid: np.ndarray, scores: np.ndarray) -> list[tuple[int, int]]:
    """Return indices (point, height) of the best scores (p, c) at least `apart_m` apart in plan."""
    left = scores.max(axis=1)
    peaks: list[tuple[int, int]] = []
    while len(peaks) < LOCATE.peaks and np.isfinite(left).any():
        index = int(np.argmax(left))
        peaks.append((index, int(np.argmax(scores[index]))))
        left[np.linalg.norm(grid - grid[index], axis=1) < LOCATE.apart_m] = -np.inf
    return peaks
