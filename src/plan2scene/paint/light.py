"""The model of light: the log of an observed colour is a sum of paint, light and exposure.

One photo cannot separate its light from the paint that it shows (the paper's failure: a blue-tinted
photo gives blue walls). All photos of a house together with a prior of homes can: a surface has one
paint in all its photos, ceilings are nearly white, a room has one light. In log colours a surface
in a photo is a sum of terms:

    usual paint + house's light + kind in this house + room's light + own paint + photo's light

Each term has a normal prior (:class:`LightPrior`), so the likeliest terms solve a least-squares
problem (maximum a posteriori). Two functions use the model: :func:`estimate_light` gives the light
of each photo, :func:`expected_colours` the colour of each surface, observed or not.

Colours are linear RGB unless said otherwise. Axes of log colours: brightness, red, blue
(:func:`plan2scene.colour.log_axes`), natural logarithms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.colour import (
    CLIPPED_LEVELS,
    LUMINANCE,
    as_uint8,
    from_log_axes,
    linear_to_srgb,
    log_axes,
    median_colour,
    srgb_to_linear,
)
from plan2scene.house import SURFACES
from plan2scene.paint.observations import HouseColours, SurfaceColour

Axes = tuple[float, float, float]
_ZERO: Axes = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LightPrior:
    """Standard deviations of the terms on the three axes, natural log; by floor, wall, ceiling."""

    own: tuple[Axes, Axes, Axes]  #: of a surface's own paint
    noise: tuple[Axes, Axes, Axes]  #: of the light on the part of a surface that one photo shows
    house: Axes  #: house, house_mean: light and exposure of all photos of a house
    house_mean: Axes = _ZERO
    photo: Axes = _ZERO  #: light of a photo relative to the house's
    #: of the common colour offset of all surfaces of a kind in a house
    kind: tuple[Axes, Axes, Axes] = (_ZERO, _ZERO, _ZERO)
    room: Axes = _ZERO  #: light of a room relative to the house's
    #: mean paint, in :func:`estimate_light`; :func:`expected_colours` gets it as `usual`
    paint_mean: tuple[Axes, Axes, Axes] = (_ZERO, _ZERO, _ZERO)
    #: residuals beyond so many standard deviations count less; infinite for plain least squares
    huber: float = np.inf


#: For the light of photos. Paint: floors of wood, stone or carpet, walls of any paint, white
#: ceilings. Cameras keep highlights unclipped, so white paint is below white. `photo` was chosen
#: on real flats: if smaller, photos still differ; if larger, rooms' own colours count as light.
PHOTO_LIGHT = LightPrior(
    own=((0.8, 0.4, 0.5), (0.6, 0.2, 0.22), (0.12, 0.04, 0.05)),
    noise=((0.2, 0.12, 0.15), (0.12, 0.05, 0.06), (0.15, 0.05, 0.06)),
    house=(0.4, 0.2, 0.2),
    house_mean=(-0.45, 0.0, 0.0),
    photo=(0.1, 0.05, 0.05),
    paint_mean=((-1.2, 0.3, -0.4), (-0.5, 0.05, -0.06), (-0.16, 0.01, -0.02)),
    huber=1.5,
)
#: For the colours of surfaces relative to the usual ones of other houses. The noise is that of one
#: photo; `house` leaves exposure open. Chosen on synthetic homes and real flats (development).
SURFACE_COLOURS = LightPrior(
    own=((0.5, 0.3, 0.3), (0.25, 0.12, 0.14), (0.2, 0.08, 0.08)),
    noise=((0.3, 0.1, 0.12), (0.3, 0.1, 0.12), (0.3, 0.1, 0.12)),
    house=(1.0, 0.4, 0.4),
    kind=((0.5, 0.3, 0.3), (0.3, 0.15, 0.15), (0.2, 0.06, 0.08)),
    room=(0.15, 0.1, 0.08),
)


@dataclass(frozen=True)
class GainLimits:
    """Bounds of the gains that photos get. Chosen by looking at real flats."""

    #: Largest correction of brightness, and of red or blue against green, natural log.
    exposure: float = float(np.log(2.5))
    balance: float = 0.6
    #: Largest linear value of corrected surfaces. :func:`relight` compresses values beyond it, so
    #: that none crosses the upper of `CLIPPED_LEVELS`.
    knee: float = 0.7
    #: This percentile of the surfaces (by their largest channel) is kept below `knee`.
    brightest: float = 90.0


GAINS = GainLimits()
_CLIPPED = float(srgb_to_linear(np.array(CLIPPED_LEVELS[1] / 255.0)))
#: Least linear value of a channel that colours are divided by.
_BLACK = 1e-3
#: Largest ratio of two channels' gains at which channels are scaled. Beyond it, noise of a nearly
#: black channel would become blotches of its colour. Light alone gives less in most photos, 3.2 in
#: one of a panelled listing (development).
_TURNED = 3.0


@dataclass(frozen=True, eq=False)
class LogSums:
    """Observed log values that are sums of terms: ``observed = design @ terms + noise``."""

    design: np.ndarray  #: (m, t) float64
    #: observed, noise: (m, 3) float64: Log colours on the axes, and the standard deviations of
    #: their noise
    observed: np.ndarray
    noise: np.ndarray
    #: mean, deviation: (t, 3) float64: Normal priors of the terms; a deviation of 0 fixes a term
    mean: np.ndarray
    deviation: np.ndarray

    def terms(self) -> np.ndarray:
        """Return the likeliest terms (t, 3) (best linear unbiased prediction).

        Robinson 1991, DOI 10.1214/ss/1177011926.
        """
        result = self.mean.copy()
        for axis in range(3):
            weighted = self.design * self.deviation[:, axis] ** 2
            pull = np.linalg.inv(self._covariance(axis)) @ self._away(axis)
            result[:, axis] += weighted.T @ pull
        return result

    def left_out(self) -> np.ndarray:
        """Return the value (m, 3) that all other observations predict for each observation."""
        result = self.observed.copy()
        for axis in range(3):
            inverse = np.linalg.inv(self._covariance(axis))
            result[:, axis] -= inverse @ self._away(axis) / np.diag(inverse)
        return result

    def robust_terms(self, huber: float) -> np.ndarray:
        """Return the likeliest terms (t, 3) where residuals beyond `huber` deviations count less.

        Huber 1964, DOI 10.1214/aoms/1177703732.
        """
        from scipy.optimize import least_squares  # slow to import, and most jobs do not need it

        count, result = len(self.observed), self.mean.copy()

        def loss(squares: np.ndarray) -> np.ndarray:
            far = squares > 1.0
            far[count:] = False  # the priors stay normal
            root = np.sqrt(np.where(far, squares, 1.0))
            value = np.where(far, 2.0 * root - 1.0, squares)
            return np.stack([value, 1.0 / root, np.where(far, -0.5 / root**3, 0.0)])

        for axis in range(3):
            scale = self.deviation[:, axis]
            noise = self.noise[:, axis]
            jacobian = np.vstack([self.design * scale / noise[:, None], np.eye(len(scale))])
            wanted = np.concatenate([self._away(axis) / noise, np.zeros(len(scale))])
            solved = least_squares(
                lambda x, a=jacobian, b=wanted: a @ x - b,
                np.zeros(len(scale)),
                jac=lambda x, a=jacobian: a,
                loss=loss,
                f_scale=huber,
                xtol=1e-12,
                ftol=1e-12,
                gtol=1e-12,
            )
            result[:, axis] += scale * solved.x
        return result

    def _away(self, axis: int) -> np.ndarray:
        """Return the observations (m,) less the values that the priors' means predict."""
        return np.asarray(self.observed[:, axis] - self.design @ self.mean[:, axis])

    def _covariance(self, axis: int) -> np.ndarray:
        """Return the covariance (m, m) of the observations."""
        terms = (self.design * self.deviation[:, axis] ** 2) @ self.design.T
        return np.asarray(terms + np.diag(self.noise[:, axis] ** 2))


def estimate_light(colours: Sequence[SurfaceColour]) -> dict[str, np.ndarray]:
    """Return the light (3,) of each photo, linear RGB, 1 for light that shows paint as it is.

    `colours` are those of all photos of a house. A surface in two photos ties their light together.
    Photos without a common surface are tied by the prior alone: it prefers a change of the house's
    light to changes of single photos, so that rooms' colours stay as different as in the photos.
    """
    prior = PHOTO_LIGHT
    photos = sorted({item.photo for item in colours})
    surfaces = sorted({(item.room_id, item.surface) for item in colours})
    if not photos:
        return {}
    row = {name: k for k, name in enumerate([*photos, *surfaces], start=1)}
    design = np.zeros((len(colours), 1 + len(row)))
    design[:, 0] = 1.0  # the house's light
    for k, item in enumerate(colours):
        design[k, [row[item.photo], row[item.room_id, item.surface]]] = 1.0
    kinds = [SURFACES.index(kind) for _, kind in surfaces]
    still = np.zeros((len(photos), 3))
    sums = LogSums(
        design,
        log_axes(np.array([item.colour for item in colours])),
        np.array([prior.noise[SURFACES.index(item.surface)] for item in colours]),
        np.vstack([prior.house_mean, still, np.array(prior.paint_mean)[kinds]]),
        np.vstack([prior.house, still + prior.photo, np.array(prior.own)[kinds]]),
    )
    terms = sums.robust_terms(prior.huber)
    return dict(zip(photos, from_log_axes(terms[0] + terms[1 : 1 + len(photos)]), strict=True))


def house_gains(
    lights: Mapping[str, np.ndarray], colours: Sequence[SurfaceColour]
) -> dict[str, np.ndarray]:
    """Return the factors (3,) on each photo's linear RGB that remove its light, within `GAINS`.

    One more factor, the same for all photos, keeps surfaces below :attr:`GainLimits.knee`.
    """
    if not lights:
        return {}
    bounds = np.array([GAINS.exposure, GAINS.balance, GAINS.balance])
    gains = {
        photo: from_log_axes(np.clip(-log_axes(light), -bounds, bounds))
        for photo, light in lights.items()
    }
    lit = [(np.array(item.colour) * gains[item.photo]).max() for item in colours]
    level = min(1.0, GAINS.knee / float(np.percentile(lit, GAINS.brightest)))
    return {photo: gain * level for photo, gain in gains.items()}


def expected_colours(
    observed: HouseColours, usual: np.ndarray, *, as_if_unseen: bool = False
) -> np.ndarray:
    """Return the sRGB (n, 3, 3) in [0, 1] that every surface of n rooms is expected to have.

    A surface that is well seen keeps its colour; one of which few pixels are seen, or none, follows
    its kind in the house and its room's light. `usual` is the sRGB (n, 3, 3) of such surfaces in
    other houses. With `as_if_unseen`, each surface is predicted without its own observation.
    """
    prior = SURFACE_COLOURS
    size, rooms = observed.photos.size, len(observed.photos)
    room, kind = np.divmod(np.arange(size), len(SURFACES))
    values = log_axes(srgb_to_linear(np.clip(usual, 0.0, 1.0))).reshape(-1, 3)
    photos = observed.photos.reshape(-1)
    seen_indices = np.flatnonzero(photos > 0)
    if len(seen_indices):
        light = [np.ones((size, 1)), np.eye(rooms)[room]]
        design = np.hstack([*light, np.eye(len(SURFACES))[kind], np.eye(size)])
        deviation = np.vstack(
            [
                prior.house,
                np.tile(prior.room, (rooms, 1)),
                prior.kind,
                np.array(prior.own)[kind],
            ]
        )
        sums = LogSums(
            design[seen_indices],
            log_axes(observed.colours.reshape(-1, 3)[seen_indices]) - values[seen_indices],
            np.array(prior.noise)[kind[seen_indices]] / np.sqrt(photos[seen_indices, None]),
            np.zeros_like(deviation),
            deviation,
        )
        expected = design @ sums.terms()
        if as_if_unseen:
            expected[seen_indices] = sums.left_out()
        values = values + expected
    return linear_to_srgb(np.minimum(from_log_axes(values), 1.0)).reshape(usual.shape)


def relight(image: np.ndarray, gains: np.ndarray, knee: float = GAINS.knee) -> np.ndarray:
    """Return an image (h, w, 3) uint8 sRGB with its linear RGB times `gains` (3,).

    A gain above 1 compresses values beyond `knee` (linear): a value that is not clipped
    (`CLIPPED_LEVELS`) does not become so, a clipped one stays as it is.
    """
    if np.array_equal(gains, np.ones(3)):
        return image
    levels = srgb_to_linear(np.arange(256, dtype=np.uint8))
    table = np.stack([_bent(levels, float(gain), knee) for gain in gains], axis=-1)
    return np.asarray(cv2.LUT(image, as_uint8(linear_to_srgb(table))[:, None]))


def repainted(image: np.ndarray, gains: np.ndarray, knee: float = GAINS.knee) -> np.ndarray:
    """Return a texture (h, w, 3) uint8 sRGB in another paint: its linear RGB times `gains` (3,).

    It is as by :func:`relight`, unless one channel's gain is more than 3 times another's: then the
    texture gets one hue and keeps the brightness of its pattern.
    """
    if gains.max() > _TURNED * gains.min():
        bright = srgb_to_linear(image) @ LUMINANCE
        colour = gains * np.maximum(srgb_to_linear(median_colour(image)), _BLACK)
        one_hue = colour * (bright / max(float(np.median(bright)), _BLACK))[..., None]
        return as_uint8(linear_to_srgb(np.minimum(one_hue, _CLIPPED)))
    return relight(image, gains, knee)


def _bent(values: np.ndarray, gain: float, knee: float) -> np.ndarray:
    """Return linear values times a gain; beyond the knee a curve maps them to below `_CLIPPED`.

    The curve is a rational function with slope 1 at the knee. It leaves clipped values unchanged.
    """
    if gain <= 1.0:
        return values * gain
    width = _CLIPPED - knee
    over = np.maximum(values * gain - knee, 0.0) / width
    most = (_CLIPPED * gain - knee) / width
    bent = knee + width * over / (1.0 + over * (most - 1.0) / most)
    lit = np.where(over > 0.0, bent, values * gain)
    return np.where(values < _CLIPPED, lit, values)


def recoloured(
    image: np.ndarray, colour: np.ndarray, median: np.ndarray | None = None
) -> np.ndarray:
    """Return an image (h, w, 3) uint8 sRGB with another median `colour` (3,), sRGB in [0, 1].

    It is as if another pigment with the same grain reflected the light (:func:`repainted`); no
    channel burns out. `median` is what counts as the image's own median colour.
    """
    before = median_colour(image) if median is None else median
    wanted, own = (np.maximum(srgb_to_linear(c), _BLACK) for c in (colour, before))
    return repainted(image, wanted / own)
