"""Paint of a house's surfaces and light of its photos, estimated together.

A photo shows paint times light times exposure. In log colours (:func:`plan2scene.colour.log_axes`:
brightness, red, blue) an observation is a sum::

    observed = house's light + room's light + photo's light + surface's paint + noise

The sum alone does not determine its terms; a prior of homes does (:class:`PaintPrior`). Paint is of
one of three sorts, each with a normal distribution: white (most ceilings and walls), pale or grey,
or any colour. The light of a photo has a colour between lamp and sky. So a wall that looks blue
below a ceiling that looks white is blue, and one that looks blue below a ceiling that looks blue is
white in the light of the sky. The more the light of a photo varies between lamp and sky over its
walls, the less the colour of its ceiling counts.

Coloured walls reflect their colour onto each other and onto the ceiling, more where lamps light it
less. The model knows this: an orange tint of a white ceiling does not make the carpet below blue.

For a given sort of each surface the priors are normal, except those of floors and walls of any
colour, which vary more: these and the noise are Student's t. The likeliest terms are found by
iteratively reweighted least squares (Lange et al. 1989, DOI 10.1080/01621459.1989.10478852). A
search chooses the sorts: it changes that of one surface, or of all walls and ceilings of a room,
as long as the posterior grows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plan2scene.colour import from_log_axes, log_axes
from plan2scene.house import SURFACES, SurfaceKey

Axes = tuple[float, float, float]
#: Kinds of surfaces that are painted. The key of a door has the id of its opening as its room.
KINDS = (*SURFACES, "door")


@dataclass(frozen=True)
class PaintPrior:
    """What is known of paint, light and noise: natural logs on the axes brightness, red, blue.

    Kinds are in the order of :data:`KINDS`: floor, wall, ceiling, door leaf. White
    paint reflects about .82 (L* 92); doors that are not white are mostly of wood. The other figures
    were chosen on two real flats (development), those of doors on one.
    """

    #: White paint: mean and standard deviation.
    white: Axes = (float(np.log(0.82)), 0.01, -0.02)
    white_deviation: Axes = (0.06, 0.025, 0.035)
    #: Pale and grey paint, by kind: mean and standard deviation. Those of floors (stone, concrete,
    #: carpet) and their share were chosen on three real listings (development).
    pale: tuple[Axes, ...] = (
        (-1.2, 0.04, -0.08),
        (-0.7, 0.04, -0.08),
        (-0.7, 0.04, -0.08),
        (-0.7, 0.04, -0.08),
    )
    pale_deviation: tuple[Axes, ...] = (
        (0.7, 0.06, 0.09),
        (0.45, 0.06, 0.09),
        (0.45, 0.06, 0.09),
        (0.45, 0.06, 0.09),
    )
    #: Probability that a surface is white, and that it is pale or grey, by kind. `share_pale` and
    #: `pale` of walls and ceilings were chosen on 13 synthetic homes and the demo.
    share_white: tuple[float, ...] = (0.001, 0.75, 0.97, 0.7)
    share_pale: tuple[float, ...] = (0.3, 0.12, 0.02, 0.0)
    #: Other paint, by kind: mean and standard deviation.
    colour: tuple[Axes, ...] = (
        (-1.4, 0.3, -0.4),
        (-0.55, 0.1, -0.15),
        (-0.7, 0.2, -0.3),
        (-1.6, 0.5, -0.9),
    )
    colour_deviation: tuple[Axes, ...] = (
        (0.6, 0.35, 0.45),
        (0.6, 0.4, 0.5),
        (0.6, 0.4, 0.5),
        (0.35, 0.25, 0.35),
    )
    #: Standard deviation of an observation of weight `whole`, by kind: the light on the part seen.
    #: That of doors and `most_noise` were fitted to 115 leaves in photos of 43 synthetic homes.
    noise: tuple[Axes, ...] = (
        (0.3, 0.06, 0.08),
        (0.2, 0.04, 0.05),
        (0.25, 0.04, 0.05),
        (0.29, 0.09, 0.15),
    )
    #: Light on a kind of surface over the photo's, natural log: windows and lamps light walls and
    #: floors more than ceilings (ceiling over walls: -.5, -.3 on two real flats, .2 on a listing).
    lit: tuple[float, ...] = (0.0, 0.0, -0.2, 0.0)
    #: Observations of this weight (share of the photo's pixels) or more have that noise. In others
    #: it grows by the root of `whole` / weight, at most by a factor of `most_noise`.
    whole: float = 0.02
    most_noise: float = 2.3
    #: A ceiling may be lit from another side than the walls: `Observation.mixed`, but at most this,
    #: is added to its noise along `lamp`. Natural log; chosen on one real flat (development).
    most_mixed: float = 0.2
    #: This share of the colour of a room's walls (log red, blue) is added to the light on its walls
    #: and ceiling. Chosen on one real listing and the demo (development).
    bounce: float = 0.1
    #: Standard deviation of that share on a ceiling: some lamps light it directly, others only by
    #: way of the walls. Chosen on four synthetic homes of strong colours.
    bounce_deviation: float = 0.1
    #: Factor on the noise of a surface seen from another room: its room has its own light.
    other_room: float = 2.0
    #: Degrees of freedom of Student's t: of the noise, and of floors and walls of any colour.
    freedom: float = 6.0
    #: Standard deviations of light: brightness, along the axis from lamp to sky, across it.
    house: Axes = (0.8, 0.2, 0.06)
    photo: Axes = (0.3, 0.18, 0.06)
    #: The same of the light that all photos of a room share. Chosen on one real listing, the demo.
    room: Axes = (0.15, 0.08, 0.03)
    #: Mean of the house's light: cameras keep highlights unclipped, so white paint is below white.
    house_mean: Axes = (-0.35, 0.0, 0.0)
    #: Direction of (red, blue) from sky to lamp.
    lamp: tuple[float, float] = (0.507, -0.862)

    def light_precision(self, deviation: Axes) -> np.ndarray:
        """Return the inverse covariance (3, 3) of light, of a `deviation` such as `photo`."""
        along = np.array(self.lamp)
        across = np.array([-along[1], along[0]])
        precision = np.zeros((3, 3))
        precision[0, 0] = deviation[0] ** -2
        precision[1:, 1:] = np.outer(along, along) / deviation[1] ** 2
        precision[1:, 1:] += np.outer(across, across) / deviation[2] ** 2
        return precision


@dataclass(frozen=True)
class Observation:
    """The usual colour of a surface in a photo."""

    photo: str
    surface: SurfaceKey
    own: bool  #: whether it is seen from within the room
    weight: float  #: share of the photo's pixels, as in ``colours.parquet``
    colour: tuple[float, float, float]  #: (3,) float: Linear RGB
    #: how much the light in the photo varies between lamp and sky: standard deviation of the log
    #: colours along `PaintPrior.lamp` within its walls and ceilings
    mixed: float = 0.0
    lit_by: SurfaceKey | None = None  #: the walls that reflect their colour onto it
    room: str = ""  #: where the photo was taken: room of the largest surface seen from within


@dataclass(frozen=True, eq=False)
class HousePaint:
    """The likeliest paint and light."""

    #: dict of SurfaceKey to (3,) float64: Linear reflectance of every observed surface
    paint: Mapping[SurfaceKey, np.ndarray] = field(default_factory=dict)
    white: frozenset[SurfaceKey] = frozenset()  #: surfaces that are white
    #: dict of str to (3,) float64: Light times exposure of every photo, linear RGB: observed =
    #: paint * light
    light: Mapping[str, np.ndarray] = field(default_factory=dict)


def estimate_paint(
    observations: Sequence[Observation], prior: PaintPrior | None = None
) -> HousePaint:
    """Return the likeliest paint of all observed surfaces and light of all photos of a house."""
    if not observations:
        return HousePaint()
    problem = _Problem(observations, prior or PaintPrior())
    kinds = np.array([key.kind for key in problem.surfaces])
    best = max(
        (
            problem.climbed(np.where(white, _WHITE, _COLOUR))
            for white in (kinds != "floor", kinds == "ceiling", kinds == "")
        ),
        key=lambda solution: solution.value,
    )
    light = from_log_axes(problem.lights @ best.terms)
    paint = from_log_axes(best.terms[-len(problem.surfaces) :])
    return HousePaint(
        dict(zip(problem.surfaces, paint, strict=True)),
        frozenset(
            key for key, sort in zip(problem.surfaces, best.sort, strict=True) if sort == _WHITE
        ),
        dict(zip(problem.photos, light, strict=True)),
    )


#: Sorts of paint.
_COLOUR, _WHITE, _PALE = range(3)
#: A choice gets more rounds if its log posterior, after two, is less than this below the best.
_SCREEN = 2.0


@dataclass(frozen=True, eq=False)
class _Solution:
    """Log posterior (up to a constant), terms (t, 3), sorts (s,) int, observation weights (m,)."""

    value: float
    terms: np.ndarray
    sort: np.ndarray
    trust: np.ndarray


class _Problem:
    """The sum's terms, in order: the house's, photos' and rooms' light, the surfaces' paint."""

    def __init__(self, observations: Sequence[Observation], prior: PaintPrior) -> None:
        self.prior = prior
        self.photos = sorted({item.photo for item in observations})
        self.surfaces = sorted({item.surface for item in observations})
        rooms = sorted({(item.room,) for item in observations})
        row = {name: k for k, name in enumerate([*self.photos, *rooms, *self.surfaces], start=1)}
        #: (photos, t): 1 where a term is part of a photo's light, else 0.
        self.lights = np.zeros((len(self.photos), 1 + len(row)))
        self.lights[:, 0] = 1.0
        for item in observations:
            self.lights[row[item.photo] - 1, [row[item.photo], row[(item.room,)]]] = 1.0
        #: (3, m, t): by axis of colour, the factor of each term in each observation.
        self.design = np.zeros((3, len(observations), 1 + len(row)))
        for k, item in enumerate(observations):
            self.design[:, k] = self.lights[row[item.photo] - 1]
            self.design[:, k, row[item.surface]] = 1.0
            if item.lit_by is not None:
                self.design[1:, k, row[item.lit_by]] += prior.bounce
        self.observed = log_axes(np.array([item.colour for item in observations]))
        kind = [KINDS.index(item.surface.kind) for item in observations]
        self.observed[:, 0] -= np.array(prior.lit)[kind]
        weight = np.array([item.weight for item in observations])
        few = np.clip(np.sqrt(prior.whole / np.maximum(weight, 1e-9)), 1.0, prior.most_noise)
        few *= np.where([item.own for item in observations], 1.0, prior.other_room)
        covariance = ((np.array(prior.noise)[kind] * few[:, None]) ** 2)[:, :, None] * np.eye(3)
        mixed = np.minimum([item.mixed for item in observations], prior.most_mixed)
        mixed *= np.array(kind) == KINDS.index("ceiling")
        covariance[:, 1:, 1:] += np.outer(prior.lamp, prior.lamp) * mixed[:, None, None] ** 2
        self.covariance = covariance
        #: Observations of ceilings whose room's walls are observed, and the terms of these walls.
        lit = [(k, item) for k, item in enumerate(observations) if item.surface.kind == "ceiling"]
        self.tinted = [k for k, item in lit if item.lit_by is not None]
        self.lit_by = [row[item.lit_by] for _, item in lit if item.lit_by is not None]
        self.kind = kinds = np.array([KINDS.index(key.kind) for key in self.surfaces])
        alike = np.zeros((len(kinds), 1))
        means = np.array([prior.colour, prior.pale])[:, kinds]
        spreads = np.array([prior.colour_deviation, prior.pale_deviation])[:, kinds]
        #: By sort and surface: mean and deviation of paint, (3, s, 3), and log probability (3, s).
        self.means = np.array([means[0], prior.white + alike, means[1]])
        self.deviations = np.array([spreads[0], prior.white_deviation + alike, spreads[1]])
        white, pale = np.array(prior.share_white), np.array(prior.share_pale)
        with np.errstate(divide="ignore"):
            self.chance = np.log([1.0 - white - pale, white, pale])[:, kinds]
        self.light = [prior.light_precision(prior.house)]
        self.light += [prior.light_precision(prior.photo)] * len(self.photos)
        self.light += [prior.light_precision(prior.room)] * len(rooms)

    def climbed(self, sort: np.ndarray) -> _Solution:
        """Return the best solution that hill climbing over sorts reaches from a first choice."""
        rooms = sorted({key.room_id for key in self.surfaces})
        upright = [
            [k for k, key in enumerate(self.surfaces) if key.room_id == room and self.kind[k] > 0]
            for room in rooms
        ]
        moves = [([k], other) for k in range(len(self.surfaces)) for other in (1, 2)]
        moves += [(move, 1) for move in upright if len(move) > 1]
        best = self.solved(sort.copy(), np.ones(len(self.observed)), 12)
        grown, everywhere = True, np.arange(len(sort))
        while grown:
            grown = False
            for move, step in moves:
                turned = best.sort.copy()
                if len(move) == 1:
                    turned[move] = (turned[move] + step) % 3
                else:
                    turned[move] = _COLOUR if (turned[move] == _WHITE).all() else _WHITE
                if np.isinf(self.chance[turned, everywhere]).any():
                    continue
                other = self.solved(turned, best.trust, 2)
                if other.value > best.value - _SCREEN:
                    other = self.solved(turned, other.trust, 5)
                if other.value > best.value + 1e-6:
                    best, grown = other, True
        return best

    def solved(self, sort: np.ndarray, trust: np.ndarray, rounds: int) -> _Solution:
        """Return the likeliest terms for the sorts (s,) int of surfaces.

        `trust` (m,) are the first weights of the observations.
        """
        prior, count = self.prior, self.design.shape[2]
        paints = np.arange(count - len(self.surfaces), count)
        everywhere = np.arange(len(sort))
        mean, spread = self.means[sort, everywhere], self.deviations[sort, everywhere]
        squares, odd = np.zeros(len(self.observed)), np.zeros(len(self.surfaces))
        pull, tailed = np.ones(len(self.surfaces)), sort == _COLOUR
        tailed &= self.kind <= KINDS.index("wall")
        terms: np.ndarray = np.zeros((count, 3))
        for _ in range(rounds):
            covariance = self.covariance.copy()
            tint = prior.bounce_deviation * terms[self.lit_by, 1:]
            covariance[self.tinted, 1:, 1:] += tint[:, :, None] * tint[:, None, :]
            noise_precision = np.linalg.inv(covariance)
            left = np.zeros((count, 3, count, 3))
            right = np.zeros((count, 3))
            for k, precision in enumerate(self.light):
                left[k, :, k, :] = precision
            right[0] = self.light[0] @ prior.house_mean
            for axis in range(3):
                left[paints, axis, paints, axis] += pull / spread[:, axis] ** 2
                right[paints, axis] += pull * mean[:, axis] / spread[:, axis] ** 2
                for other in range(3):
                    weighted = self.design[axis].T * (trust * noise_precision[:, axis, other])
                    left[:, axis, :, other] += weighted @ self.design[other]
                    right[:, axis] += weighted @ self.observed[:, other]
            solved = np.linalg.solve(left.reshape(3 * count, -1), right.ravel())
            terms = solved.reshape(count, 3)
            residual = self.observed - np.einsum("amt,ta->ma", self.design, terms)
            squares = np.einsum("ma,mab,mb->m", residual, noise_precision, residual)
            trust = (prior.freedom + 3) / (prior.freedom + squares)
            odd = (((terms[paints] - mean) / spread) ** 2).sum(axis=1)
            pull = np.where(tailed, (prior.freedom + 3) / (prior.freedom + odd), 1.0)
        value = -0.5 * (prior.freedom + 3) * np.log1p(squares / prior.freedom).sum()
        value -= 0.5 * np.linalg.slogdet(covariance)[1].sum()
        away = terms[: len(self.light)].copy()
        away[0] -= prior.house_mean
        value -= 0.5 * sum(a @ p @ a for a, p in zip(away, self.light, strict=True))
        odd = np.where(tailed, (prior.freedom + 3) * np.log1p(odd / prior.freedom), odd)
        value -= 0.5 * odd.sum() + np.log(spread).sum()
        value += self.chance[sort, everywhere].sum()
        # The prior of floors and doors is wide, so each single tone is unlikely. To compare them
        # with white, integrate over all tones (Laplace's approximation: MacKay 1992, DOI
        # 10.1162/neco.1992.4.3.415).
        tones = paints[np.isin(self.kind, (KINDS.index("floor"), KINDS.index("door")))]
        value -= 0.5 * np.linalg.slogdet(left[tones, :, tones])[1].sum()
        return _Solution(float(value), terms, sort, trust)
