"""Manhattan frame of a photo from its line segments: rotation and focal length together.

All segments vote for the three orthogonal directions of a room at once, for every focal length of
a grid. (The closed form from two vanishing points fails when one of them is near infinity.) The
best guesses are refined in parallel, a few of them with the focal length free. Their costs give the
probability of each focal length, and so the certainty of the best one. It is low, for example, for
a photo that looks straight at a wall, because that fits every focal length.

The refinement is a Gauss-Newton iteration of our own: scipy.optimize.least_squares takes one
hypothesis at a time and has no redescending loss.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from plan2scene.photos.camera.lines import CAMERA, Segments, residuals, sines


@dataclass(frozen=True)
class Guess:
    """A Manhattan frame at a focal length, and its score: share of the votes less a penalty.

    Columns of `axes` are the world's x, y (up), z in camera axes.
    """

    score: float
    axes: np.ndarray
    focal: float


def first_guesses(
    segments: Segments, width: int, focals: np.ndarray, prior: float
) -> list[list[Guess]]:
    """Return the guesses for each focal length, those with the best score first.

    `width` of the photo, `focals` (k,) and `prior`, the most likely focal length, are in pixels.
    """
    verticals = _verticals(segments, width, np.random.default_rng(0))
    headings = np.linspace(0.0, np.pi / 2, CAMERA.n_heading, endpoint=False)
    weight = segments.weight * np.minimum(segments.length, 0.25 * width)
    voters = np.argsort(-weight, kind="stable")[: CAMERA.n_voters]
    weight = weight[voters] / weight[voters].sum()
    noise, off_vertical = segments.coarse_noise[voters, None], segments.off_vertical[voters]
    by_focal = []
    for focal in focals.tolist():
        normal, middle = (rays[voters] for rays in segments.rays(focal))
        penalty = CAMERA.focal_penalty * (np.log(focal / prior) / 0.3) ** 2
        guesses = []
        for point in verticals:
            up, first, second = _frames(point, focal / width, headings)
            off = np.abs(sines(normal, middle, np.hstack([first, second, up[:, None]])))
            level = np.minimum(off[:, : CAMERA.n_heading], off[:, CAMERA.n_heading : -1])
            off = np.minimum(np.arcsin(level), (np.arcsin(off[:, -1]) + off_vertical)[:, None])
            score = weight @ np.exp(-0.5 * (off / noise) ** 2)
            best = int(np.argmax(score))
            axes = np.stack([first[:, best], up, second[:, best]], axis=1)
            guesses.append(Guess(float(score[best]) - penalty, axes, focal))
        by_focal.append(sorted(guesses, key=lambda guess: -guess.score))
    return by_focal


def _frames(
    point: np.ndarray, focal: float, headings: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the axes of a vertical vanishing point: up (3,), two level ones (3, n) by heading."""
    up = np.array([point[0], point[1], point[2] * focal])
    up *= -np.sign(up[1]) / np.linalg.norm(up)
    ahead = np.array([0.0, 0.0, 1.0]) - up[2] * up
    ahead /= np.linalg.norm(ahead)
    side = np.cross(up, ahead)
    first = np.outer(side, np.cos(headings)) + np.outer(ahead, np.sin(headings))
    second = np.outer(-side, np.sin(headings)) + np.outer(ahead, np.cos(headings))
    return up, first, second


def _verticals(segments: Segments, width: int, rng: np.random.Generator) -> np.ndarray:
    """Return candidate vertical vanishing points (k, 3), homogeneous, in image widths."""
    leaning = segments.slant < np.radians(CAMERA.max_slant_deg)
    upright = np.nonzero(leaning & (segments.off_vertical == 0.0))[0]
    level = np.array([[0.0, 1.0, 0.0]])
    if len(upright) < 3:
        return level
    one = np.ones((len(upright), 1))
    points = segments.points[upright] / width
    lines = np.cross(np.hstack([points[:, :2], one]), np.hstack([points[:, 2:], one]))
    chance = segments.length[upright] * segments.weight[upright]
    pairs = rng.choice(len(upright), size=(CAMERA.n_pairs, 2), p=chance / chance.sum())
    crossings = np.cross(lines[pairs[:, 0]], lines[pairs[:, 1]])
    crossings = crossings[np.linalg.norm(crossings, axis=1) > 1e-9]
    crossings /= np.linalg.norm(crossings, axis=1, keepdims=True)
    roll = np.arctan2(np.abs(crossings[:, 0]), np.abs(crossings[:, 1]))
    reach = np.hypot(crossings[:, 0], crossings[:, 1]) / np.maximum(np.abs(crossings[:, 2]), 1e-9)
    nearest = (
        0.5
        / np.tan(np.radians(CAMERA.fov_range_deg[1]) / 2)
        / np.tan(np.radians(CAMERA.max_pitch_deg))
    )
    crossings = np.vstack(
        [level, crossings[(roll < np.radians(CAMERA.max_roll_deg)) & (reach > nearest)]]
    )
    middle = segments.middle[upright] / width
    toward = crossings[:, None, :2] - middle[None] * crossings[:, None, 2:]
    along = points[:, 2:] - points[:, :2]
    turn = toward[..., 0] * along[:, 1] - toward[..., 1] * along[:, 0]
    turn /= np.linalg.norm(toward, axis=2) * np.linalg.norm(along, axis=1) + 1e-12
    noise = segments.coarse_noise[upright] / 2
    score = (chance * np.exp(-0.5 * (turn / noise) ** 2)).sum(axis=1)
    return _distinct(crossings, score)


def _distinct(points: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Return the best-scoring vanishing points that differ by more than about 1.5 degrees."""
    kept: list[np.ndarray] = []
    for index in np.argsort(-score, kind="stable"):
        point = points[index]
        if all(abs(float(point @ other)) < np.cos(np.radians(1.5)) for other in kept):
            kept.append(point)
        if len(kept) == CAMERA.n_verticals:
            break
    return np.array(kept)


N_PARAMETERS, N_TURNS = 5, 3  #: Rotation vector (3), log focal length, bend, in this order


@dataclass(frozen=True)
class Manhattan:
    """A fitted frame."""

    #: (3, 3) float64, columns are the world's x, y (up), z in camera axes: the world-to-camera
    #: rotation.
    axes: np.ndarray
    focal: float  #: focal length, pixels
    bend: float  #: lens distortion, see `Segments.bent_rays`
    counts: tuple[int, int, int]  #: (3,) int: Number of inlier segments of x, y, z
    share: float  #: share of the inliers of all three axes, by weight times length
    log_focal_sd: float = 0.0  #: standard deviation of log(focal) given the segments and the prior
    #: Probability that the true focal length is within `CAMERA.right_within` of `focal`.
    certainty: float = 1.0


class _State(NamedTuple):
    """k hypotheses: axes (k, 3, 3), log focal length (k,), distortion (k,)."""

    axes: np.ndarray
    log_focal: np.ndarray
    bend: np.ndarray

    def take(self, index: int) -> _State:
        return _State(*(values[index : index + 1] for values in self))

    def joined(self, other: _State) -> _State:
        return _State(*map(np.concatenate, zip(self, other, strict=True)))

    def turned(self, step: np.ndarray) -> _State:
        """Return the state moved by steps (k, 5) or (5,): rotation vector, log focal, bend."""
        steps = np.broadcast_to(step, (len(self.axes), N_PARAMETERS))
        turns = [cv2.Rodrigues(s[:3])[0] for s in np.atleast_2d(np.ascontiguousarray(step))]
        bend = np.clip(self.bend + steps[:, 4], *CAMERA.bend_range)
        return _State(np.stack(turns) @ self.axes, self.log_focal + steps[:, 3], bend)


def fit_manhattan(
    segments: Segments, width: int, prior: float, *, fixed: bool = False
) -> Manhattan | None:
    """Return the best Manhattan frame and focal length, or None without enough segments.

    `width` of the photo and `prior`, the most likely focal length, are in pixels. With `fixed` the
    focal length stays `prior`; only the rotation and the distortion are estimated.
    """
    if len(segments.points) < 8:
        return None
    low, high = (width / 2 / np.tan(np.radians(fov) / 2) for fov in CAMERA.fov_range_deg[::-1])
    grid = np.geomspace(min(low, prior), max(high, prior), CAMERA.n_focal)
    guesses = first_guesses(segments, width, np.array([prior]) if fixed else grid, prior)
    ranked_guesses = sorted((guess for group in guesses for guess in group), key=lambda g: -g.score)
    if fixed:
        fixed_guesses, free = ranked_guesses[: CAMERA.n_free], []
    else:
        fixed_guesses, free = [group[0] for group in guesses], ranked_guesses[: CAMERA.n_free]
    axes, focals = zip(*((guess.axes, guess.focal) for guess in fixed_guesses + free), strict=True)
    state = _State(np.stack(axes), np.log(focals), np.zeros(len(axes)))
    moves = np.ones((len(state.bend), N_PARAMETERS))
    moves[: len(fixed_guesses), 3] = 0.0
    state = _refine(segments, state, prior, moves)
    cost = _cost(segments, state, prior)
    best = int(np.argmin(cost))
    if not fixed and best < len(fixed_guesses):
        again = _refine(segments, state.take(best), prior, np.ones((1, N_PARAMETERS)))
        state = state.joined(again)
        cost = np.concatenate([cost, _cost(segments, again, prior)])
        best = int(np.argmin(cost))
    frame = _describe(segments, state.take(best))
    if fixed:
        return frame
    spread, certainty = _certainty(state.log_focal, cost, best, np.log(grid))
    return replace(frame, log_focal_sd=spread, certainty=certainty)


def refine_rotation(segments: Segments, frame: Manhattan, focal: float) -> np.ndarray:
    """Return the frame's axes refitted at another focal length."""
    state = _State(frame.axes[None], np.log([focal]), np.array([frame.bend]))
    moves = np.array([[1.0, 1.0, 1.0, 0.0, 0.0]])
    return _refine(segments, state, focal, moves).axes[0]


def _rays(segments: Segments, state: _State) -> tuple[np.ndarray, np.ndarray]:
    """Return plane normals and middle rays (k, s, 3) of the segments for each hypothesis."""
    return segments.bent_rays(np.exp(state.log_focal), state.bend)


def _scaled(
    segments: Segments,
    state: _State,
    nearest: np.ndarray | None = None,
    rays: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals (k, s) to the nearest axis, divided by their noise, and that axis (k, s).

    `nearest` (k, s), if given, sets the axes. `rays` are those of :func:`_rays`, if known already.
    """
    normal, middle = _rays(segments, state) if rays is None else rays
    if nearest is None:
        off = residuals(normal, middle, state.axes)
        distance = np.abs(off)
        distance[..., 1] += segments.off_vertical
        nearest = np.argmin(distance, axis=-1)
        nearest_residuals = np.take_along_axis(off, nearest[..., None], axis=-1)[..., 0]
        return nearest_residuals / segments.noise, nearest
    axis = state.axes.transpose(0, 2, 1)[np.arange(len(nearest))[:, None], nearest]
    off = residuals(normal[..., None, :], middle[..., None, :], axis[..., None])[..., 0, 0]
    return off / segments.noise, nearest


def _priors(state: _State, prior: float) -> np.ndarray:
    """Return the prior's terms (k, 4): focal length, pitch, roll, distortion, over their spread."""
    up = state.axes[:, :, 1]
    return np.stack(
        [
            (state.log_focal - np.log(prior)) / CAMERA.sigma_log_focal,
            np.arcsin(np.clip(up[:, 2], -1, 1)) / CAMERA.sigma_pitch,
            np.arctan2(up[:, 0], -up[:, 1]) / CAMERA.sigma_roll,
            state.bend / CAMERA.sigma_bend,
        ],
        axis=1,
    )


def _cost(segments: Segments, state: _State, prior: float) -> np.ndarray:
    """Return minus the log probability (k,); the cost of a segment is bounded (outliers)."""
    scaled, _ = _scaled(segments, state)
    lost = CAMERA.cost_width**2 * (1.0 - np.exp(-0.5 * (scaled / CAMERA.cost_width) ** 2))
    focal, pitch, roll, bend = _priors(state, prior).T
    tilt = 2.0 * np.log1p(0.25 * pitch**2) + 2.0 * np.log1p(0.25 * roll**2)
    return np.asarray(
        (segments.weight * lost).sum(axis=1) / CAMERA.correlation
        + tilt
        + 0.5 * (focal**2 + bend**2)
    )


def _refine(segments: Segments, state: _State, prior: float, moves: np.ndarray) -> _State:
    """Return the state after reweighted Gauss-Newton steps of the parameters that may move.

    `moves` (k, 5) is 1 for those parameters, 0 for the held ones.
    """
    damping = np.eye(N_PARAMETERS)[None] * (1.0 - moves + 1e-6)[:, None]
    for width in CAMERA.reweighting:
        rays = _rays(segments, state)
        scaled, nearest = _scaled(segments, state, rays=rays)
        believed = _priors(state, prior)
        slope, belief_slope = _jacobian(segments, state, prior, nearest, rays)
        slope, belief_slope = slope * moves[:, None], belief_slope * moves[:, None]
        trust = segments.weight * np.exp(-0.5 * (scaled / width) ** 2) / CAMERA.correlation
        belief = 1.0 / (1.0 + 0.25 * believed**2)
        belief[:, [0, 3]] = 1.0
        weighted = slope * trust[..., None]
        weighted_belief = belief_slope * belief[..., None]
        normal = weighted.transpose(0, 2, 1) @ slope
        normal += weighted_belief.transpose(0, 2, 1) @ belief_slope + damping
        right = np.einsum("ksi,ks->ki", weighted, scaled)
        right += np.einsum("ksi,ks->ki", weighted_belief, believed)
        step = -np.linalg.solve(normal, right[..., None])[..., 0]
        state = state.turned(np.clip(step, -0.15, 0.15) * moves)
    return state


def _jacobian(
    segments: Segments,
    state: _State,
    prior: float,
    nearest: np.ndarray,
    rays: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives (k, s, 5) of residuals and (k, 4, 5) of the prior's terms."""
    columns, beliefs = [], []
    for index in range(N_PARAMETERS):
        step = np.zeros(N_PARAMETERS)
        step[index] = CAMERA.difference
        ahead, behind = state.turned(step), state.turned(-step)
        same = rays if index < N_TURNS else None  # a rotation does not change the camera's rays
        change = _scaled(segments, ahead, nearest, same)[0]
        change = change - _scaled(segments, behind, nearest, same)[0]
        columns.append(change / (2 * CAMERA.difference))
        beliefs.append((_priors(ahead, prior) - _priors(behind, prior)) / (2 * CAMERA.difference))
    return np.stack(columns, axis=-1), np.stack(beliefs, axis=-1)


def _certainty(
    log_focal: np.ndarray, cost: np.ndarray, best: int, grid: np.ndarray
) -> tuple[float, float]:
    """Return the standard deviation of log(focal) and the probability that the best is right.

    The cheapest hypothesis at a focal length counts; between focal lengths costs are interpolated.
    """
    kept: list[tuple[float, float]] = []
    for index in np.argsort(log_focal, kind="stable"):
        point = (float(log_focal[index]), float(cost[index]))
        if kept and point[0] - kept[-1][0] < 0.01:
            kept[-1] = min(kept[-1], point, key=lambda item: item[1])
        else:
            kept.append(point)
    known, costs = np.array(kept).T
    fine = np.linspace(grid[0], grid[-1], 400)
    chance = np.exp(cost[best] - np.interp(fine, known, costs))
    chance /= chance.sum()
    mean = float(chance @ fine)
    near = np.abs(fine - log_focal[best]) < np.log(CAMERA.right_within)
    return float(np.sqrt(chance @ (fine - mean) ** 2)), float(chance[near].sum())


def _describe(segments: Segments, state: _State) -> Manhattan:
    """Return the hypothesis of a state with k = 1 as a frame, with its inliers."""
    scaled, nearest = (values[0] for values in _scaled(segments, state))
    fits = np.abs(scaled) < CAMERA.agrees
    weight = segments.weight * segments.length
    counts = [int((fits & (nearest == axis)).sum()) for axis in range(3)]
    return Manhattan(
        axes=state.axes[0],
        focal=float(np.exp(state.log_focal[0])),
        bend=float(state.bend[0]),
        counts=(counts[0], counts[1], counts[2]),
        share=float(weight[fits].sum() / weight.sum()),
    )
