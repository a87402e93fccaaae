"""Light of the photos of a house: one for all, with what each photo deviates from it.

A photo's colours are albedo times light. One photo cannot tell them apart (the paper's failure: a
blue-tinted photo gives blue walls); the photos of a house together with what is known of rooms
can: a room's wall is one colour in all its photos, ceilings are nearly white, walls pale more often
than not. In log colours all of this is linear, so that the light is the solution of one
least-squares problem (maximum a posteriori under normal priors, Huber weights).

The model is hierarchical: a photo's light is the house's and a deviation whose prior is narrow, so
that only surfaces seen in several photos bring it about. What paint usually looks like moves the
house's light, which keeps the rooms' colours apart as the photos show them.

All colours here are linear RGB. Axes of log colours: brightness (mean of log R, G, B), red
(log R - log G), blue (log B - log G).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.colour import (
    as_uint8,
    from_log_axes,
    linear_to_srgb,
    log_axes,
    srgb_to_linear,
)
from plan2scene.photos.crops.filter import CLIPPED_LEVELS, inner_mask, unclipped
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL

#: Surfaces smaller than this share of the photo tell nothing.
MIN_SHARE = 0.005
_LABELS = {"floor": FLOOR, "wall": WALL, "ceiling": CEILING}
#: Mean and standard deviation of albedo on the three axes: white ceilings, walls of any paint,
#: floors of wood, stone or carpet.
ALBEDO = {
    "ceiling": ((-0.16, 0.12), (0.01, 0.04), (-0.02, 0.05)),
    "wall": ((-0.5, 0.6), (0.05, 0.2), (-0.06, 0.22)),
    "floor": ((-1.2, 0.8), (0.3, 0.4), (-0.4, 0.5)),
}
#: The same of the light of a photo: cameras keep highlights, so white paint is below white.
LIGHT = ((-0.45, 0.4), (0.0, 0.2), (0.0, 0.2))
#: Standard deviations of a photo's light about the house's. Chosen on real flats: narrower leaves
#: the photos' differences, wider ones take the rooms' own colours for light.
DEVIATION = (0.1, 0.05, 0.05)
#: How much the light on one surface differs from the photo's (standard deviations).
LOCAL_LIGHT = {
    "ceiling": (0.15, 0.05, 0.06),
    "wall": (0.12, 0.05, 0.06),
    "floor": (0.2, 0.12, 0.15),
}
#: Residuals beyond this many standard deviations count less.
HUBER = 1.5
#: Largest correction: of brightness, and of red or blue against green (log).
MAX_EXPOSURE, MAX_BALANCE = np.log(2.5), 0.6
#: Linear value that the brightest of the house's surfaces have at most once corrected; beyond it
#: corrected values bend towards `_CLIPPED`, which none crosses.
KNEE = 0.7
_BRIGHTEST = 90.0  # percentile of surfaces that `KNEE` holds for
_CLIPPED = float(srgb_to_linear(np.array(CLIPPED_LEVELS[1] / 255.0)))

#: What the crops show: the photos' own colours, or those under one light for the house.
COLOURS = ("photo", "corrected")


@dataclass(frozen=True)
class SurfaceColour:
    """Colour of a surface in a photo."""

    photo: str
    room_id: str
    surface: str
    #: (3,): Median linear RGB of its pixels.
    colour: tuple[float, float, float]


def surface_colours(
    image: np.ndarray, labels: np.ndarray, photo: str, rooms: Sequence[str], edges: np.ndarray
) -> list[SurfaceColour]:
    """Return the colours of the surfaces of a photo, for each room that it shows.

    `image` (h, w, 3) uint8 sRGB, `labels` (h, w) uint8 (0 other, 1 floor, 2 wall, 3 ceiling),
    `edges` (h, w) bool as of :func:`plan2scene.photos.crops.filter.strong_edges`; clipped pixels
    and borders are left aside.
    """
    usable = unclipped(image)
    found = []
    for surface, label in _LABELS.items():
        mask = labels == label
        inner = inner_mask(mask, edges) & usable
        if inner.sum() < MIN_SHARE * labels.size or inner.sum() < 0.2 * mask.sum():
            continue
        red, green, blue = (float(v) for v in np.median(srgb_to_linear(image[inner]), axis=0))
        found += [SurfaceColour(photo, room, surface, (red, green, blue)) for room in rooms]
    return found


def estimate_light(colours: Sequence[SurfaceColour]) -> dict[str, np.ndarray]:
    """Return the light (3,) of each photo, linear RGB, 1 for light that shows albedo as it is.

    `colours` are those of all photos of a house. Unknown are the log light of the house, each
    photo's deviation from it and the log albedo of each surface (room and kind); observed is
    their sum. A surface of two photos ties their deviations together; the priors `ALBEDO`, `LIGHT`
    and `DEVIATION` decide what no surface ties.
    """
    photos = sorted({item.photo for item in colours})
    surfaces = sorted({(item.room_id, item.surface) for item in colours})
    if not photos:
        return {}
    column = {name: k for k, name in enumerate([*photos, *surfaces], start=1)}
    logs = log_axes(np.array([item.colour for item in colours]))
    axes = np.zeros((len(photos), 3))
    for axis in range(3):
        prior = [LIGHT[axis]] + [(0.0, DEVIATION[axis])] * len(photos)
        prior += [ALBEDO[kind][axis] for _, kind in surfaces]
        noise = np.array([LOCAL_LIGHT[item.surface][axis] for item in colours])
        design = np.zeros((len(colours), 1 + len(column)))
        design[:, 0] = 1.0
        for row, item in enumerate(colours):
            design[row, column[item.photo]] = 1.0
            design[row, column[item.room_id, item.surface]] = 1.0
        solved = _robust_map(design, logs[:, axis], noise, np.array(prior))
        axes[:, axis] = solved[0] + solved[1 : 1 + len(photos)]
    light = from_log_axes(axes)
    return {photo: light[k] for k, photo in enumerate(photos)}


def house_gains(
    lights: Mapping[str, np.ndarray], colours: Sequence[SurfaceColour]
) -> dict[str, np.ndarray]:
    """Return the factors (3,) on each photo's linear RGB that take its light away, bounded.

    One factor for the house's brightness keeps its surfaces below `KNEE`.
    """
    if not lights:
        return {}
    axes = {photo: -log_axes(light) for photo, light in lights.items()}
    bounds = np.array([MAX_EXPOSURE, MAX_BALANCE, MAX_BALANCE])
    gains = {
        photo: from_log_axes(np.clip(wanted, -bounds, bounds)) for photo, wanted in axes.items()
    }
    lit = [(np.array(item.colour) * gains[item.photo]).max() for item in colours]
    level = min(1.0, KNEE / float(np.percentile(lit, _BRIGHTEST)))
    return {photo: gain * level for photo, gain in gains.items()}


def relight(image: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return an image (h, w, 3) uint8 sRGB with its linear RGB times `gains` (3,).

    A channel that is made brighter than `KNEE` bends: a pixel that is not clipped
    (`CLIPPED_LEVELS`) does not become so, a clipped one stays as it is.
    """
    if np.array_equal(gains, np.ones(3)):
        return image
    linear = srgb_to_linear(image)
    channels = [_bent(linear[..., k], float(gains[k])) for k in range(3)]
    return as_uint8(linear_to_srgb(np.stack(channels, axis=-1)))


def _bent(values: np.ndarray, gain: float) -> np.ndarray:
    """Return linear values (h, w) times a gain, on from `KNEE` bent to meet at `_CLIPPED`.

    The bend is rational, of slope 1 at the knee.
    """
    if gain <= 1.0:
        return values * gain
    width = _CLIPPED - KNEE
    over = np.maximum(values * gain - KNEE, 0.0) / width
    most = (_CLIPPED * gain - KNEE) / width
    bent = KNEE + width * over / (1.0 + over * (most - 1.0) / most)
    lit = np.where(over > 0.0, bent, values * gain)
    return np.where(values < _CLIPPED, lit, values)


def _robust_map(
    design: np.ndarray, observed: np.ndarray, noise: np.ndarray, prior: np.ndarray
) -> np.ndarray:
    """Return x (n,) that is most likely: design x + noise = observed, x normal about the prior.

    `design` (m, n), `observed` and `noise` (m,), `prior` (n, 2) mean and standard deviation.
    """
    inverse = 1.0 / prior[:, 1] ** 2
    weight = np.ones(len(observed))
    x = prior[:, 0]
    for _ in range(10):
        scaled = design.T * (weight / noise**2)
        x = np.linalg.solve(
            scaled @ design + np.diag(inverse), scaled @ observed + inverse * prior[:, 0]
        )
        off = np.abs(design @ x - observed) / noise
        weight = np.minimum(1.0, HUBER / np.maximum(off, 1e-9))
    return x
