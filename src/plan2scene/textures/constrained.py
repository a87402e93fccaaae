"""Textures brought to a crop's own statistics: the method ``synth-large``.

A decoded tile has its colours and grain from eight numbers. Here it gets the power by sector of
the spectrum and the colour distribution of the crop itself, in turns (after Heeger and Bergen
1995, DOI 10.1145/218380.218446; colours by sliced optimal transport, Pitie et al. 2007,
DOI 10.1016/j.cviu.2006.11.011). Both act on the torus, so what tiled before tiles after.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.seeds import derive_seed
from plan2scene.textures.inputs import TextureInputs
from plan2scene.textures.tiles import Tile

_ROUNDS = 4
_TURNS = 8  # rotations of the colour space a round
_ORIENTATIONS = 8
_OTHERS = 5  # crops that help with the light
#: Frequencies below this many waves a tile are the light's as much as the texture's.
_SLOWEST = 1.5


def constrained_tiles(
    inputs: TextureInputs, tiles: Mapping[SurfaceKey, Tile]
) -> dict[SurfaceKey, Tile]:
    """Return decoded tiles with the statistics of the crop that each was decoded from."""
    images = {crop.crop_id: crop.image() for crop in inputs.crops}
    result = dict(tiles)
    for surface in inputs.surfaces:
        key, tile = surface.key, tiles[surface.key]
        if surface.source not in images or surface.tone is None:
            continue
        alike = [crop.crop_id for crop in inputs.crops if crop.key == key]
        others = [images[name] for name in alike if name != surface.source]
        even = even_crop(images[surface.source], others, surface.tone, len(tile.image))
        seed = derive_seed(inputs.settings.seed, inputs.data.files.house_id, *key, "statistics")
        matched = match_statistics(tile.image, even, seed)
        result[key] = replace(tile, image=matched, source=f"{tile.source}, its statistics")
    return result


def match_statistics(tile: np.ndarray, crop: np.ndarray, seed: int) -> np.ndarray:
    """Return a tile with the spectrum and the colours of a crop.

    Parameters
    ----------
    tile : (s, s, 3) uint8
        sRGB, repeating, at least 32 px.
    crop : (s, s, 3) uint8
        sRGB, of the same size; its light should be even.
    seed : int
        Of the rotations of the colour space.

    Returns
    -------
    (s, s, 3) uint8
    """
    if tile.shape != crop.shape or tile.shape[0] != tile.shape[1]:
        raise ValueError(f"expected equal square shapes, found {tile.shape} and {crop.shape}")
    rng = np.random.default_rng(seed)
    wanted = crop.reshape(-1, 3).astype(np.float64)
    mean, axes = _principal_axes(wanted)
    power = _sector_power((crop.astype(np.float64) - mean) @ axes)
    values = tile.astype(np.float64)
    for _ in range(_ROUNDS):
        values = _with_power((values - mean) @ axes, power) @ axes.T + mean
        flat = _with_colours(values.reshape(-1, 3), wanted, rng)
        values = flat.reshape(tile.shape)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def even_crop(
    crop: np.ndarray, others: Sequence[np.ndarray], tone: np.ndarray, size_px: int
) -> np.ndarray:
    """Return a crop under even light, (size, size, 3) uint8.

    Parameters
    ----------
    crop, others : (128, 128, 3) uint8
        The crop, and further crops of the surface that tell its shading from the material's.
    tone : (3,) float
        The surface's median colour, sRGB in [0, 1], that the crop is scaled to.
    """
    import cv2

    from plan2scene.colour import as_uint8
    from plan2scene.paint.shading import flatten, highlights
    from plan2scene.textures.exemplar.tone import toned

    images = np.stack([crop, *others[:_OTHERS]]) / 255.0
    flat = flatten(images, highlights(images))[0]
    even = as_uint8(toned(flat, np.asarray(tone)))
    if even.shape[0] == size_px:
        return even
    method = cv2.INTER_AREA if size_px < even.shape[0] else cv2.INTER_CUBIC
    return cv2.resize(even, (size_px, size_px), interpolation=method)


def _principal_axes(colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean (3,) and the principal axes (3, 3), as columns, of colours (n, 3)."""
    mean = colours.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((colours - mean).T))
    return mean, axes


@cache
def _sectors(size: int) -> np.ndarray:
    """Return (size, size // 2 + 1) int: a sector's number for each frequency, 0 for the slowest."""
    fy = np.fft.fftfreq(size, 1 / size)[:, None]
    fx = np.fft.rfftfreq(size, 1 / size)[None, :]
    radius = np.hypot(fx, fy)
    ring = np.where(
        radius < _SLOWEST, 0, 1 + np.floor(2.0 * np.log2(np.maximum(radius, _SLOWEST) / _SLOWEST))
    )
    angle = np.remainder(np.arctan2(fy, fx), np.pi) / np.pi * _ORIENTATIONS
    sector = np.round(angle).astype(np.int64) % _ORIENTATIONS
    return np.where(ring > 0, (ring.astype(np.int64) - 1) * _ORIENTATIONS + sector + 1, 0)


def _powers(spectrum: np.ndarray) -> np.ndarray:
    """Return mean power (sectors, 3) of a half spectrum (s, s // 2 + 1, 3)."""
    number = _sectors(spectrum.shape[0]).ravel()
    counts = np.bincount(number)
    flat = (np.abs(spectrum) ** 2).reshape(-1, 3)
    sums = np.stack([np.bincount(number, weights=flat[:, c]) for c in range(3)], axis=1)
    return sums / np.maximum(counts, 1)[:, None]  # small images leave sectors empty


def _sector_power(values: np.ndarray) -> np.ndarray:
    """Return the power by sector (sectors, 3) of an image that does not repeat, per its window."""
    size = values.shape[0]
    line = np.hanning(size + 2)[1:-1]
    window = np.outer(line, line)
    centred = values - np.average(values, axis=(0, 1), weights=np.repeat(window[..., None], 3, 2))
    spectrum = np.fft.rfft2(centred * window[..., None], axes=(0, 1))
    return _powers(spectrum) / (window**2).mean()


def _with_power(values: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Return an image (s, s, 3) on the torus with the power of each sector; the slowest stay."""
    spectrum = np.fft.rfft2(values, axes=(0, 1))
    gain = np.sqrt(power / np.maximum(_powers(spectrum), 1e-6))
    gain[0] = 1.0
    gain = np.clip(gain, 0.0, 8.0)
    return np.fft.irfft2(spectrum * gain[_sectors(values.shape[0])], values.shape[:2], axes=(0, 1))


def _with_colours(values: np.ndarray, wanted: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return colours (n, 3) whose distribution is nearly that of `wanted` (n, 3)."""
    values = values.copy()
    for _ in range(_TURNS):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        mine, theirs = values @ turn, wanted @ turn
        for axis in range(3):
            order = np.argsort(mine[:, axis], kind="stable")
            mine[order, axis] = np.sort(theirs[:, axis])
        values = mine @ turn.T
    return values
