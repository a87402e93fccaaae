"""Manhattan frame of a photo from its line segments: rotation and focal length together.

A segment and the camera centre span a plane with unit normal n. A line along the unit direction
d (camera axes) gives n . d = 0; the residual used here is the angle by which the segment would
have to turn about the ray m through its middle, ``asin(|n . d| / |m x d|)``. All segments vote
for the three orthogonal directions of a room at once, for every focal length of a grid, because
one closed form from two vanishing points is lost as soon as one of them is near infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

#: Horizontal fields of view that are searched (and up to the prior's, if beyond), degrees.
FOV_RANGE_DEG = (35.0, 100.0)
N_FOCAL = 15
N_HEADING = 60
N_PAIRS = 240
N_VERTICALS = 4
#: Largest roll and pitch believed of a photo of a room, degrees.
MAX_ROLL_DEG = 15.0
MAX_PITCH_DEG = 32.0
#: Spread of the priors: log of the focal length, pitch and roll (radians).
SIGMA_LOG_FOCAL = 0.30
SIGMA_PITCH = np.radians(12.0)
SIGMA_ROLL = np.radians(4.0)
#: Angular noise of a segment: END_NOISE pixels over its length, and never below ANGLE_NOISE.
END_NOISE = 1.0
ANGLE_NOISE = np.radians(0.35)
COARSE_NOISE = np.radians(1.6)


@dataclass(frozen=True)
class Manhattan:
    """A fitted frame.

    Parameters
    ----------
    axes : (3, 3) float64
        Columns are the world's x, y (up), z in camera axes: the world-to-camera rotation.
    focal : float
        Focal length, pixels.
    counts : (3,) int
        Segments that agree with x, y, z.
    share : float
        Share of the segments' weight that agrees with one of the three.
    log_focal_sd : float
        Standard deviation of log(focal) that the segments alone leave.
    """

    axes: np.ndarray
    focal: float
    counts: tuple[int, int, int]
    share: float
    log_focal_sd: float


class Segments:
    """Segments relative to the principal point with what every hypothesis needs of them."""

    def __init__(
        self,
        segments: np.ndarray,
        centre: tuple[float, float],
        weight: np.ndarray,
        end_noise: np.ndarray | float = END_NOISE,
        level: np.ndarray | None = None,
    ):
        #: (s,) radians added to a segment's angle to the vertical: known horizontal lines.
        self.off_vertical = np.zeros(len(segments)) if level is None else np.where(level, 3.0, 0.0)
        shift = np.array([centre[0], centre[1]] * 2)
        self.points = segments - shift
        delta = self.points[:, 2:] - self.points[:, :2]
        self.length = np.maximum(np.hypot(delta[:, 0], delta[:, 1]), 1e-6)
        self.middle = (self.points[:, :2] + self.points[:, 2:]) / 2
        self.slant = np.arctan2(np.abs(delta[:, 0]), np.abs(delta[:, 1]))
        self.weight = weight
        self.noise = np.hypot(end_noise * 2.0 / self.length, ANGLE_NOISE)
        self.coarse_noise = np.hypot(end_noise * 2.0 / self.length, COARSE_NOISE)

    def rays(self, focal: float) -> tuple[np.ndarray, np.ndarray]:
        """Return plane normals n and middle rays m, both (s, 3) unit, for a focal length."""
        one = np.ones((len(self.points), 1))
        first = np.hstack([self.points[:, :2] / focal, one])
        second = np.hstack([self.points[:, 2:] / focal, one])
        normal = np.cross(first, second)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        middle = np.hstack([self.middle / focal, one])
        return normal, middle / np.linalg.norm(middle, axis=1, keepdims=True)


def residuals(normal: np.ndarray, middle: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return signed angles (s, d), radians, of segments against unit `directions` (3, d)."""
    off = normal @ directions
    reach = np.sqrt(np.maximum(1.0 - (middle @ directions) ** 2, 1e-9))
    return np.arcsin(np.clip(off / reach, -1.0, 1.0))


def fit_manhattan(
    segments: Segments, width: int, prior: float, seed: int, *, fixed: bool = False
) -> Manhattan | None:
    """Return the best Manhattan frame and focal length, or None without enough segments.

    Parameters
    ----------
    segments : Segments
        Line segments about the principal point.
    width : int
        Width of the photo, pixels.
    prior : float
        Focal length at the centre of the prior, pixels.
    seed : int
        Seed of the pairs drawn for the vertical vanishing point.
    fixed : bool
        The focal length is `prior`; only the rotation is sought.
    """
    if len(segments.points) < 8:
        return None
    rng = np.random.default_rng(seed)
    starts = _coarse(segments, width, prior, rng, fixed)
    fits = [_refine(segments, axes, focal, prior, fixed) for axes, focal in starts]
    costs = [_cost(segments, axes, focal, prior) for axes, focal in fits]
    axes, focal = fits[int(np.argmin(costs))]
    return _describe(segments, axes, focal)


def _verticals(segments: Segments, width: int, rng: np.random.Generator) -> np.ndarray:
    """Return candidate vertical vanishing points (k, 3), homogeneous, in image widths."""
    upright = np.nonzero((segments.slant < np.radians(28.0)) & (segments.off_vertical == 0.0))[0]
    level = np.array([[0.0, 1.0, 0.0]])
    if len(upright) < 3:
        return level
    one = np.ones((len(upright), 1))
    points = segments.points[upright] / width
    lines = np.cross(np.hstack([points[:, :2], one]), np.hstack([points[:, 2:], one]))
    chance = segments.length[upright] * segments.weight[upright]
    pairs = rng.choice(len(upright), size=(N_PAIRS, 2), p=chance / chance.sum())
    found = np.cross(lines[pairs[:, 0]], lines[pairs[:, 1]])
    found = found[np.linalg.norm(found, axis=1) > 1e-9]
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    roll = np.arctan2(np.abs(found[:, 0]), np.abs(found[:, 1]))
    reach = np.hypot(found[:, 0], found[:, 1]) / np.maximum(np.abs(found[:, 2]), 1e-9)
    nearest = 0.5 / np.tan(np.radians(FOV_RANGE_DEG[1]) / 2) / np.tan(np.radians(MAX_PITCH_DEG))
    found = np.vstack([level, found[(roll < np.radians(MAX_ROLL_DEG)) & (reach > nearest)]])
    middle = segments.middle[upright] / width
    toward = found[:, None, :2] - middle[None] * found[:, None, 2:]
    along = points[:, 2:] - points[:, :2]
    sine = toward[..., 0] * along[:, 1] - toward[..., 1] * along[:, 0]
    sine /= np.linalg.norm(toward, axis=2) * np.linalg.norm(along, axis=1) + 1e-12
    noise = segments.coarse_noise[upright] / 2
    score = (chance * np.exp(-0.5 * (sine / noise) ** 2)).sum(axis=1)
    return _distinct(found, score)


def _distinct(found: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Return the best-scoring vanishing points that differ by more than about 1.5 degrees."""
    kept: list[np.ndarray] = []
    for index in np.argsort(-score, kind="stable"):
        point = found[index]
        if all(abs(float(point @ other)) < np.cos(np.radians(1.5)) for other in kept):
            kept.append(point)
        if len(kept) == N_VERTICALS:
            break
    return np.array(kept)


def _coarse(
    segments: Segments, width: int, prior: float, rng: np.random.Generator, fixed: bool
) -> list[tuple[np.ndarray, float]]:
    """Return the best start per (focal length, vertical) grid cell, the most consistent first."""
    believed = np.degrees(2 * np.arctan(width / 2 / prior))
    low, high = min(FOV_RANGE_DEG[0], believed), max(FOV_RANGE_DEG[1], believed)
    fovs = np.radians([believed] if fixed else np.linspace(low, high, N_FOCAL))
    headings = np.linspace(0.0, np.pi / 2, N_HEADING, endpoint=False)
    weight = segments.weight * np.minimum(segments.length, 0.25 * width)
    weight /= weight.sum()
    found: list[tuple[float, np.ndarray, float]] = []
    verticals = _verticals(segments, width, rng)
    for focal in width / 2 / np.tan(fovs / 2):
        normal, middle = segments.rays(float(focal))
        for point in verticals:
            up = np.array([point[0], point[1], point[2] * focal / width])
            up *= -np.sign(up[1]) / np.linalg.norm(up)
            ahead = np.array([0.0, 0.0, 1.0]) - up[2] * up
            ahead /= np.linalg.norm(ahead)
            side = np.cross(up, ahead)
            first = np.outer(side, np.cos(headings)) + np.outer(ahead, np.sin(headings))
            second = np.outer(-side, np.sin(headings)) + np.outer(ahead, np.cos(headings))
            off = np.minimum(
                np.abs(residuals(normal, middle, first)), np.abs(residuals(normal, middle, second))
            )
            upright = np.abs(residuals(normal, middle, up[:, None]))
            off = np.minimum(off, upright + segments.off_vertical[:, None])
            vote = np.exp(-0.5 * (off / segments.coarse_noise[:, None]) ** 2)
            score = weight @ vote - 0.02 * (np.log(focal / prior) / SIGMA_LOG_FOCAL) ** 2
            best = int(np.argmax(score))
            axes = np.stack([first[:, best], up, second[:, best]], axis=1)
            found.append((float(score[best]), axes, float(focal)))
    found.sort(key=lambda item: -item[0])
    return [(axes, focal) for _, axes, focal in found[:6]]


def _stack(
    segments: Segments, axes: np.ndarray, focal: float, prior: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return residuals over their noise to the nearest axis, that axis, and the prior's terms."""
    normal, middle = segments.rays(focal)
    off = residuals(normal, middle, axes)
    distance = np.abs(off)
    distance[:, 1] += segments.off_vertical
    nearest = np.argmin(distance, axis=1)
    scaled = off[np.arange(len(off)), nearest] / segments.noise
    up = axes[:, 1]
    believed = np.array(
        [
            np.log(focal / prior) / SIGMA_LOG_FOCAL,
            np.arcsin(np.clip(up[2], -1, 1)) / SIGMA_PITCH,
            np.arctan2(up[0], -up[1]) / SIGMA_ROLL,
        ]
    )
    return scaled, nearest, believed


def _turn(axes: np.ndarray, focal: float, step: np.ndarray) -> tuple[np.ndarray, float]:
    """Return a frame turned by a rotation vector, and its focal length times exp(step[3])."""
    return cv2.Rodrigues(step[:3].copy())[0] @ axes, float(focal * np.exp(step[3]))


def _loss(segments: Segments, scaled: np.ndarray) -> np.ndarray:
    """Return each segment's bounded cost: a segment that fits nothing costs a constant."""
    return segments.weight * (1.0 - np.exp(-0.5 * (scaled / 1.5) ** 2))


def _cost(segments: Segments, axes: np.ndarray, focal: float, prior: float) -> float:
    scaled, _, believed = _stack(segments, axes, focal, prior)
    return float(_loss(segments, scaled).sum() + 0.5 * (believed**2).sum())


def _jacobian(segments: Segments, axes: np.ndarray, focal: float, prior: float) -> np.ndarray:
    """Return derivatives (s + 3, 4) of residuals and prior terms, axes held per segment."""
    _, nearest, _ = _stack(segments, axes, focal, prior)
    rows = np.arange(len(nearest))
    columns = []
    for index in range(4):
        values = []
        for sign in (1.0, -1.0):
            step = np.zeros(4)
            step[index] = sign * 1e-5
            turned, other = _turn(axes, focal, step)
            normal, middle = segments.rays(other)
            off = residuals(normal, middle, turned)[rows, nearest] / segments.noise
            values.append(np.concatenate([off, _stack(segments, turned, other, prior)[2]]))
        columns.append((values[0] - values[1]) / 2e-5)
    return np.stack(columns, axis=1)


def _refine(
    segments: Segments, axes: np.ndarray, focal: float, prior: float, fixed: bool = False
) -> tuple[np.ndarray, float]:
    """Return the frame after reweighted Gauss-Newton steps; `fixed` keeps the focal length."""
    size = 3 if fixed else 4
    for scale in (5.0, 4.0, 3.0, 2.2, 1.5, 1.5, 1.5):
        scaled, _, believed = _stack(segments, axes, focal, prior)
        trust = segments.weight * np.exp(-0.5 * (scaled / scale) ** 2)
        trust = np.concatenate([trust, np.ones(3)])
        slope = _jacobian(segments, axes, focal, prior)[:, :size]
        normal = slope.T @ (trust[:, None] * slope) + 1e-6 * np.eye(size)
        step = np.zeros(4)
        step[:size] = -np.linalg.solve(
            normal, slope.T @ (trust * np.concatenate([scaled, believed]))
        )
        step = np.clip(step, -0.15, 0.15)
        axes, focal = _turn(axes, focal, step)
    return axes, focal


def refine_rotation(segments: Segments, axes: np.ndarray, focal: float) -> np.ndarray:
    """Return the frame refitted with the focal length held."""
    return _refine(segments, axes, focal, focal, fixed=True)[0]


def _describe(segments: Segments, axes: np.ndarray, focal: float) -> Manhattan:
    """Return the frame with its support and the focal length's standard deviation."""
    scaled, nearest, _ = _stack(segments, axes, focal, focal)
    fits = np.abs(scaled) < 2.5
    trust = segments.weight * np.exp(-0.5 * (scaled / 1.5) ** 2)
    slope = _jacobian(segments, axes, focal, focal)[: len(scaled)]
    information = slope.T @ (trust[:, None] * slope) + 1e-9 * np.eye(4)
    weight = segments.weight * segments.length
    counts = [int((fits & (nearest == axis)).sum()) for axis in range(3)]
    return Manhattan(
        axes=axes,
        focal=focal,
        counts=(counts[0], counts[1], counts[2]),
        share=float(weight[fits].sum() / weight.sum()),
        log_focal_sd=float(np.sqrt(np.linalg.inv(information)[3, 3])),
    )
