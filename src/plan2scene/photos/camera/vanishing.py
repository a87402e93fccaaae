"""Line segments against directions of space, and first guesses of a photo's Manhattan frame.

A segment and the camera centre span a plane with unit normal n. A line along the unit direction
d (camera axes) gives n . d = 0; the residual used here is the angle by which the segment would
have to turn about the ray m through its middle, ``asin(|n . d| / |m x d|)``. All segments vote
for the three orthogonal directions of a room at once, for every focal length of a grid, because
one closed form from two vanishing points is lost as soon as one of them is near infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Horizontal fields of view that are searched (and up to the prior's, if beyond), degrees.
FOV_RANGE_DEG = (30.0, 115.0)
N_FOCAL = 19
N_HEADING = 45
N_PAIRS = 300
N_VERTICALS = 5
#: Segments that vote for the first guesses, those that weigh most.
N_VOTERS = 160
#: Largest roll and pitch believed of a photo of a room, degrees, and how far a vertical line may
#: lean in the photo then.
MAX_ROLL_DEG = 25.0
MAX_PITCH_DEG = 35.0
MAX_SLANT_DEG = 45.0
#: Angular noise of a segment: END_NOISE pixels over its length, and never below ANGLE_NOISE.
END_NOISE = 1.0
ANGLE_NOISE = np.radians(0.35)
COARSE_NOISE = np.radians(1.6)
#: What an unlikely focal length (log ratio 0.3 to the prior) costs a guess, share of the votes.
FOCAL_PENALTY = 0.02


class Segments:
    """Segments relative to the principal point with what every hypothesis needs of them.

    Parameters
    ----------
    segments : (s, 4) float64
        ``x1 y1 x2 y2``, pixels.
    centre : (float, float)
        Principal point, the middle of the photo, pixels.
    weight : (s,) float64
        What each segment counts.
    end_noise : (s,) float64 or float
        How far its ends may be off, pixels.
    level : (s,) bool, optional
        Segments known to be horizontal in the world.
    """

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
        #: Half the photo's diagonal squared: the unit of radii.
        self.unit = max(centre[0] ** 2 + centre[1] ** 2, 1.0)
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
        normal, middle = self.bent_rays(np.array([focal]), np.zeros(1))
        return normal[0], middle[0]

    def bent_rays(self, focal: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return n and m, both (k, s, 3) unit, for k focal lengths and lens distortions.

        `bend` is that of the division model (Fitzgibbon, CVPR 2001): a point at radius r seen
        through the lens belongs at ``r / (1 + bend r^2)``, r in half diagonals of the photo.
        """
        x1, y1, x2, y2 = self.points.T
        first = 1.0 + bend[:, None] * ((x1**2 + y1**2) / self.unit)
        second = 1.0 + bend[:, None] * ((x2**2 + y2**2) / self.unit)
        middle = 1.0 + bend[:, None] * ((self.middle**2).sum(axis=1) / self.unit)
        scale = focal[:, None]
        level = np.broadcast_to(x1 * y2 - y1 * x2, first.shape)
        across = [scale * (y1 * second - first * y2), scale * (first * x2 - x1 * second)]
        normals = np.dstack([*across, level])
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
        ahead = scale * middle
        rays = np.dstack(np.broadcast_arrays(*self.middle.T, ahead))
        return normals, rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def residuals(normal: np.ndarray, middle: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return signed angles (..., s, d), radians, of segments against unit `directions` (..., 3, d).

    `normal` and `middle` (..., s, 3) are those of `Segments.rays`.
    """
    off = normal @ directions
    reach = np.sqrt(np.maximum(1.0 - (middle @ directions) ** 2, 1e-9))
    return np.asarray(np.arcsin(np.clip(off / reach, -1.0, 1.0)))


@dataclass(frozen=True)
class Guess:
    """A Manhattan frame at a focal length, and the share of votes for it.

    Columns of `axes` are the world's x, y (up), z in camera axes.
    """

    score: float
    axes: np.ndarray
    focal: float


def first_guesses(
    segments: Segments, width: int, focals: np.ndarray, prior: float, seed: int
) -> list[list[Guess]]:
    """Return the guesses per focal length, the most consistent first.

    `width` of the photo, `focals` (k,) and `prior`, the most likely of them, are pixels; `seed`
    is that of the pairs drawn for the vertical vanishing point.
    """
    verticals = _verticals(segments, width, np.random.default_rng(seed))
    headings = np.linspace(0.0, np.pi / 2, N_HEADING, endpoint=False)
    weight = segments.weight * np.minimum(segments.length, 0.25 * width)
    voters = np.argsort(-weight, kind="stable")[:N_VOTERS]
    weight = weight[voters] / weight[voters].sum()
    noise, off_vertical = segments.coarse_noise[voters, None], segments.off_vertical[voters]
    found = []
    for focal in focals.tolist():
        normal, middle = (rays[voters] for rays in segments.rays(focal))
        penalty = FOCAL_PENALTY * (np.log(focal / prior) / 0.3) ** 2
        guesses = []
        for point in verticals:
            up, first, second = _frames(point, focal / width, headings)
            off = np.abs(residuals(normal, middle, np.hstack([first, second, up[:, None]])))
            upright = off[:, -1] + off_vertical
            off = np.minimum(off[:, :N_HEADING], off[:, N_HEADING:-1])
            off = np.minimum(off, upright[:, None])
            score = weight @ np.exp(-0.5 * (off / noise) ** 2)
            best = int(np.argmax(score))
            axes = np.stack([first[:, best], up, second[:, best]], axis=1)
            guesses.append(Guess(float(score[best]) - penalty, axes, focal))
        found.append(sorted(guesses, key=lambda guess: -guess.score))
    return found


def _frames(
    point: np.ndarray, focal: float, headings: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return up (3,) of a vertical vanishing point and both horizontal axes (3, n) per heading."""
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
    leaning = segments.slant < np.radians(MAX_SLANT_DEG)
    upright = np.nonzero(leaning & (segments.off_vertical == 0.0))[0]
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
    turn = toward[..., 0] * along[:, 1] - toward[..., 1] * along[:, 0]
    turn /= np.linalg.norm(toward, axis=2) * np.linalg.norm(along, axis=1) + 1e-12
    noise = segments.coarse_noise[upright] / 2
    score = (chance * np.exp(-0.5 * (turn / noise) ** 2)).sum(axis=1)
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
