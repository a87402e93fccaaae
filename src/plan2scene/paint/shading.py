"""Light within crops of one surface: find highlights, remove slow shading, average colour casts.

One crop cannot tell shading from slow variation of the material. Several crops can: the material
has the same power in all of them, and at middle frequencies there is only material. So each crop's
slow cosine terms are reduced to the power that the less shaded crops and the neighbouring
frequencies have, not to zero: stucco keeps its relief. Images are (n, s, s, 3) float sRGB in
[0, 1]; light is modelled as a factor on these values.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from scipy.fft import dctn, idctn

from plan2scene.colour import as_uint8, from_log_axes, log_axes, rgb_to_lab, srgb_to_linear


@dataclass(frozen=True)
class ShadingSettings:
    """How light is told from the material. Chosen on development crops, real and synthetic."""

    black: float = 4.0 / 255.0  #: sRGB that keeps logarithms finite
    slow: int = 14  #: cosine terms up to this index (half waves per crop) may hold light
    certain: int = 3  #: up to this index nearly all is light
    material_hue: float = 0.03  #: spread of slow log colour ratios of materials; mixed light: 0.1
    highlight: float = 0.2  #: log excess over the crop's median that only a highlight has
    added_white: float = 0.06  #: linear share of white that a highlight adds at least
    nearly_white: float = 0.35  #: the same on surfaces that are too bright for `highlight`
    outstanding: float = 2.0  #: if most crops have highlights: least peak over the median peak
    most: float = 0.6  #: a crop with a larger share of 'highlight' shows a bright pattern instead
    spot: float = 0.6  #: least added white of a small spot, where a floor mirrors a lamp
    spot_side: float = 0.12  #: largest side of a spot, as a share of the crop's side
    spots: int = 15  #: if a crop has more spots, they are its pattern
    white: float = 0.96  #: a crop's colour is burned out if its least channel (sRGB) is above this
    repair: float = 0.03  #: crops with less log light removed weigh about the same in brightness


_S = ShadingSettings()
UNREST_BLOCKS = 16  #: blocks along a crop whose colours :func:`unrest` compares
_CHI_SQUARE_MEDIAN = 0.455  # with one degree of freedom; median over mean
_GREY = np.array([0.299, 0.587, 0.114])  # of sRGB (ITU-R BT.601)


def log_luma(images: np.ndarray) -> np.ndarray:
    """Return the log of the grey value of (..., 3) images."""
    return np.log(images @ _GREY + _S.black)


def highlights(images: np.ndarray) -> np.ndarray:
    """Return (n, s, s) bool: pixels of highlights and of mirrored lamps.

    They are blobs far brighter than their crop, with white added: brighter light alone leaves the
    least channel of a dark or coloured surface low. Thin bright joints do not count. If most crops
    have such blobs, these are the pattern, except in crops where they are `outstanding`.
    """
    masks = np.zeros(images.shape[:3], dtype=bool)
    peaks = np.zeros(len(images))
    for k, image in enumerate(images):
        # Remove bright joints and dark ones.
        body = cv2.morphologyEx(as_uint8(image), cv2.MORPH_OPEN, np.ones((9, 9)))
        body = cv2.medianBlur(body, images.shape[1] // 10 | 1)
        body = cv2.GaussianBlur(body / 255.0, (0, 0), images.shape[1] / 40)
        excess, added = _light_and_white(body)
        peaks[k] = added.max()
        strong = (excess > _S.highlight) & (added > _S.added_white)
        core = (strong | ((excess > 0.0) & (added > _S.nearly_white))).astype(np.uint8)
        if core.any() and core.mean() < _S.most:
            wide = cv2.dilate(core, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9)))
            masks[k] = wide > 0
    if masks.any(axis=(1, 2)).mean() > 0.5:
        masks[peaks < _S.outstanding * np.median(peaks)] = False
    return masks | np.stack([_spots(image) for image in images])


def _light_and_white(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much each pixel (s, s) exceeds the median: log grey, linear share of white."""
    luma, floor = log_luma(image), srgb_to_linear(image.min(axis=2))
    usual = np.median(floor)
    return luma - np.median(luma), (floor - usual) / (1.0 - usual + 1e-3)


def _spots(image: np.ndarray) -> np.ndarray:
    """Return (s, s) bool: small spots of an image (s, s, 3) that are as white as mirrored lamps."""
    excess, added = _light_and_white(image)
    bright = (excess > _S.highlight) & (added > _S.spot)
    count, places, boxes, _ = cv2.connectedComponentsWithStats(bright.astype(np.uint8))
    small = boxes[:, 2:4].max(axis=1) <= _S.spot_side * len(image)
    spots = small[places]
    if count - 1 > _S.spots or not spots.any():
        return np.zeros_like(bright)
    ellipse = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))
    return np.asarray(cv2.dilate(spots.astype(np.uint8), ellipse) > 0)


def flatten(images: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return images (n, s, s, 3), sRGB in [0, 1], under even light; each keeps its median colour.

    Slow variation is removed from log brightness, and from the logs of red and blue over green
    if they vary more than in most materials: daylight and lamps mix on a wall. Highlights, `masks`
    (n, s, s), do not count in the estimate, and remain highlights.
    """
    # In place where possible: a house has a thousand crops, and to allocate copies takes longer
    # than to fill them.
    logs = images + _S.black
    np.log(logs, out=logs)
    red, blue = (_beyond_material(_slow(logs[..., k] - logs[..., 1], masks)) for k in (0, 2))
    green = -(0.299 * red + 0.114 * blue)  # a change of hue alone keeps the grey value
    np.add(green, red, out=logs[..., 0])
    logs[..., 1] = green
    np.add(green, blue, out=logs[..., 2])
    logs += _slow(log_luma(images), masks)[..., None]
    even = np.exp(np.negative(logs, out=logs), out=logs)
    even *= images
    return np.clip(even, 0.0, 1.0, out=even)


def _beyond_material(field: np.ndarray) -> np.ndarray:
    """Return slow colour fields (n, s, s) less the part that is material (a Wiener filter)."""
    power = (field**2).mean(axis=(1, 2), keepdims=True)
    return field * np.maximum(1.0 - _S.material_hue**2 / np.maximum(power, 1e-12), 0.0)


def _slow(values: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Return the part of log values (n, s, s) that is light, with median 0 in each crop."""
    even = np.stack([filled(*pair) for pair in zip(values, masks, strict=True)])
    terms = dctn(even, axes=(1, 2), norm="ortho")
    index = np.arange(even.shape[1])
    radius = np.hypot(index[:, None], index[None, :])
    light = np.zeros_like(terms)
    for ring, share in _shares(terms, radius):
        light[:, ring] = terms[:, ring] * share[:, None]
    field = idctn(light, axes=(1, 2), norm="ortho")
    return np.asarray(field - np.median(field, axis=(1, 2), keepdims=True))


def filled(luma: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return (s, s) log values with masked ones replaced by their surroundings' mean."""
    if not mask.any():
        return luma
    return np.where(mask, surroundings(luma, (~mask).astype(np.float64)), luma)


def surroundings(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the weighted mean (s, s) of the values around each pixel, over a tenth of the side."""
    sigma = values.shape[0] / 10
    total = cv2.GaussianBlur(values * weight, (0, 0), sigma)
    return total / np.maximum(cv2.GaussianBlur(weight, (0, 0), sigma), 1e-3)


def _shares(terms: np.ndarray, radius: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return rings of cosine terms, (s, s) bool, each with its share of light by crop, (n,)."""
    rings = [(radius >= k - 0.5) & (radius < k + 0.5) for k in range(1, 2 * _S.slow)]
    power = np.stack([(terms[:, ring] ** 2).mean(axis=1) for ring in rings])  # (rings, n)
    # A lattice pattern has few strong terms per ring; the median of the terms ignores them.
    middle = [np.median(terms[:, ring] ** 2) for ring in rings[_S.slow :]]
    beyond = float(np.median(middle)) / _CHI_SQUARE_MEDIAN
    result = []
    for k, (ring, ring_power) in enumerate(
        zip(rings[: _S.slow], power[: _S.slow], strict=True), start=1
    ):
        usual_power = beyond * (_S.slow / k) ** 0.5
        material = (
            usual_power
            if k <= _S.certain
            else max(usual_power, float(np.sort(ring_power)[len(ring_power) // 3]))
        )
        amplitude = np.sqrt(np.minimum(1.0, material / np.maximum(ring_power, 1e-12)))
        result.append((ring, 1.0 - amplitude))
    return result


def consensus(tones: np.ndarray, repair: np.ndarray) -> np.ndarray:
    """Return the colour (3,) that crops agree on; `tones` are their median colours (n, 3), sRGB.

    Colour casts go either way, so the mean chroma of the crops has the least error. Shading mostly
    darkens, some crops more than others, so brightness is a weighted mean: the smaller the standard
    deviation of the log light that was taken out of it, `repair` (n,), the more a crop weighs.
    Burned-out crops are left out; if they are half or more of the crops (a white surface), the
    result is the median of all.
    """
    burned = tones.min(axis=1) > _S.white
    if 2 * burned.sum() >= len(tones):
        return np.median(tones, axis=0)
    axes = log_axes(np.maximum(tones[~burned], 1 / 255))
    mean = axes.mean(axis=0)
    mean[0] = np.average(axes[:, 0], weights=1.0 / (_S.repair + repair[~burned]) ** 2)
    return np.minimum(from_log_axes(mean), 1.0)


def smooth_field(values: np.ndarray) -> np.ndarray:
    """Return the quadratic surface that fits most of (h, w) values, float64.

    Least squares, repeated with less weight on values far from the fit (Huber), so that an object
    or a joint does not bend it. The Huber threshold follows the median of the residuals, which
    scipy.optimize.least_squares cannot do.
    """
    basis, flat = _quadratic(*values.shape), values.reshape(-1)
    fit, weight = flat, np.ones_like(flat)
    for number in range(3):
        if number:
            off = np.abs(flat - fit)
            knee = 1.5 * np.median(off) + 1e-6
            weight = np.minimum(1.0, knee / np.maximum(off, 1e-9))
        scaled = basis * weight[:, None]
        fit = basis @ np.linalg.solve(basis.T @ scaled + 1e-9 * np.eye(6), scaled.T @ flat)
    return fit.reshape(values.shape)


@cache
def _quadratic(height: int, width: int) -> np.ndarray:
    """Return the six terms of a quadratic surface at each of (height, width) values, (n, 6)."""
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1).reshape(-1, 6)


def unrest(image: np.ndarray) -> float:
    """Return how much the blocks of a crop (n, n, 3) uint8 sRGB vary: root mean square, L*a*b*.

    Smooth shading is removed first.
    """
    small = cv2.resize(image, (UNREST_BLOCKS, UNREST_BLOCKS), interpolation=cv2.INTER_AREA)
    lab = rgb_to_lab(small / 255.0)
    rest = [lab[..., k] - smooth_field(lab[..., k]) for k in range(3)]
    return float(np.sqrt(np.square(rest).sum(axis=0).mean()))
