"""Tiles decoded from embeddings: methods synth and naivesynth, and synth-large.

A decoded tile has its colours and grain from eight numbers. Method ``synth-large`` gives it the
crop's own power by sector of the spectrum and the crop's colour distribution, in turns (after
Heeger and Bergen 1995, DOI 10.1145/218380.218446; colours by sliced optimal transport, Pitie et al.
2007, DOI 10.1016/j.cviu.2006.11.011). Both keep a tile periodic.

Torch is imported only when something is decoded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np

from plan2scene.colour import as_uint8
from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.paint.shading import flatten, highlights
from plan2scene.seeds import derive_seed
from plan2scene.textures.exemplar.make import toned
from plan2scene.textures.inputs import KnownSurface, TextureInputs
from plan2scene.textures.seams import make_seamless
from plan2scene.textures.tiles import Tile


@dataclass(frozen=True)
class StatisticsSettings:
    """How a tile gets a crop's statistics. Chosen by looking at tiles of development crops."""

    rounds: int = 4  #: number of rounds; each matches the spectrum, then the colours
    turns: int = 8  #: rotations of the colour space per round
    orientations: int = 8  #: sectors of a half circle of the spectrum
    others: int = 5  #: largest number of other crops that help to find the light
    slowest: float = 1.5  #: least waves per tile that are matched; slower ones may be light


_S = StatisticsSettings()


def decoded_tiles(inputs: TextureInputs, model: str, column: str) -> Mapping[SurfaceKey, Tile]:
    """Return the tiles that weight file `model` decodes from a column of ``propagated.parquet``.

    Their noise derives from (seed, house, room, surface).
    """
    settings, image_cache = inputs.settings, inputs.data.decoded
    settings_key = inputs.models[model], settings.seed, settings.size_px
    codes = [getattr(surface, column).tobytes() for surface in inputs.surfaces]
    known_as = [
        (*settings_key, surface.key, code)
        for surface, code in zip(inputs.surfaces, codes, strict=True)
    ]
    new = [k for k, key in enumerate(known_as) if key not in image_cache]
    surfaces = [inputs.surfaces[k] for k in new]
    images, periodic = _decoded(inputs, model, column, surfaces, [()] * len(new))
    image_cache.update(
        (known_as[k], (image, periodic)) for k, image in zip(new, images, strict=True)
    )
    tiles = {}
    for surface, key in zip(inputs.surfaces, known_as, strict=True):
        image, periodic = image_cache[key]
        tiles[surface.key] = Tile(image, surface.size_m, surface.source, periodic)
    return tiles


def further_images(
    inputs: TextureInputs,
    model: str,
    column: str,
    keys: Sequence[SurfaceKey],
    count: int,
    *,
    seamless: bool,
) -> list[np.ndarray]:
    """Return `count` more images (size, size, 3) uint8 of each surface, grouped by surface.

    FID needs more images than its features have dimensions, and a test split has fewer surfaces
    (the paper takes 24 seeds). These images differ from the surface's tile (:func:`decoded_tiles`)
    in their noise only. With `seamless`, seams are repaired if the model's images do not tile.
    """
    surface_by_key = {surface.key: surface for surface in inputs.surfaces}
    places = [(surface_by_key[key], (k,)) for key in keys for k in range(1, count + 1)]
    surfaces, numbers = [s for s, _ in places], [k for _, k in places]
    images, periodic = _decoded(inputs, model, column, surfaces, numbers)
    if seamless and not periodic:
        return [make_seamless(image)[0] for image in images]
    return list(images)


def _decoded(
    inputs: TextureInputs,
    name: str,
    column: str,
    surfaces: Sequence[KnownSurface],
    numbers: Sequence[tuple[int, ...]],
) -> tuple[np.ndarray, bool]:
    """Return an image (n, size, size, 3) uint8 of each surface, and whether they tile.

    `numbers` go into the noise's seeds, so that images of one surface differ.
    """
    from plan2scene.textures.model.texture_model import decode_textures, load_texture_model

    size, house_id = inputs.settings.size_px, inputs.data.files.house_id
    if not surfaces:
        return np.zeros((0, size, size, 3), np.uint8), True
    model = load_texture_model(inputs.models[name])
    codes = np.stack([getattr(surface, column) for surface in surfaces])
    if codes.shape[1] != model.embedding_dim:
        raise InputError(
            f"{column} of length {model.embedding_dim}, the model's",
            str(codes.shape[1]),
            house=house_id,
        )
    seeds = [
        derive_seed(inputs.settings.seed, house_id, *surface.key, *number)
        for surface, number in zip(surfaces, numbers, strict=True)
    ]
    return decode_textures(model, codes, seeds, size), model.architecture.periodic


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
        other_images = [images[name] for name in alike if name != surface.source]
        even = even_crop(images[surface.source], other_images, surface.tone, len(tile.image))
        seed = derive_seed(inputs.settings.seed, inputs.data.files.house_id, *key, "statistics")
        matched = match_statistics(tile.image, even, seed)
        result[key] = replace(tile, image=matched, source=f"{tile.source}, its statistics")
    return result


def match_statistics(tile: np.ndarray, crop: np.ndarray, seed: int) -> np.ndarray:
    """Return a tile (s, s, 3) uint8 with the spectrum and the colours of a crop of the same size.

    Both are sRGB, at least 32 px. The tile is periodic; the crop's light should be even. `seed` is
    for the rotations of the colour space.
    """
    rng = np.random.default_rng(seed)
    target = crop.reshape(-1, 3).astype(np.float64)
    mean, axes = _principal_axes(target)
    power = _sector_power((crop.astype(np.float64) - mean) @ axes)
    values = tile.astype(np.float64)
    for _ in range(_S.rounds):
        values = _with_power((values - mean) @ axes, power) @ axes.T + mean
        flat = _with_colours(values.reshape(-1, 3), target, rng)
        values = flat.reshape(tile.shape)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def even_crop(
    crop: np.ndarray, others: Sequence[np.ndarray], tone: np.ndarray, size_px: int
) -> np.ndarray:
    """Return a crop (128, 128, 3) uint8 under even light, (size, size, 3) uint8.

    `others` are further crops of the surface; they help to separate shading from the material's own
    variation. The crop is scaled to `tone` (3,), the surface's median colour, sRGB in [0, 1].
    """
    images = np.stack([crop, *others[: _S.others]]) / 255.0
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
        radius < _S.slowest,
        0,
        1 + np.floor(2.0 * np.log2(np.maximum(radius, _S.slowest) / _S.slowest)),
    )
    angle = np.remainder(np.arctan2(fy, fx), np.pi) / np.pi * _S.orientations
    sector = np.round(angle).astype(np.int64) % _S.orientations
    return np.where(ring > 0, (ring.astype(np.int64) - 1) * _S.orientations + sector + 1, 0)


def _powers(spectrum: np.ndarray) -> np.ndarray:
    """Return mean power (sectors, 3) of a half spectrum (s, s // 2 + 1, 3)."""
    number = _sectors(spectrum.shape[0]).ravel()
    counts = np.bincount(number)
    flat = (np.abs(spectrum) ** 2).reshape(-1, 3)
    sums = np.stack([np.bincount(number, weights=flat[:, c]) for c in range(3)], axis=1)
    return sums / np.maximum(counts, 1)[:, None]  # small images leave sectors empty


def _sector_power(values: np.ndarray) -> np.ndarray:
    """Return the power by sector (sectors, 3) of a windowed image, which need not be periodic."""
    size = values.shape[0]
    line = np.hanning(size + 2)[1:-1]
    window = np.outer(line, line)
    centred = values - np.average(values, axis=(0, 1), weights=np.repeat(window[..., None], 3, 2))
    spectrum = np.fft.rfft2(centred * window[..., None], axes=(0, 1))
    return _powers(spectrum) / (window**2).mean()


def _with_power(values: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Return a periodic image (s, s, 3) given the power of each sector, except the slowest."""
    spectrum = np.fft.rfft2(values, axes=(0, 1))
    gain = np.sqrt(power / np.maximum(_powers(spectrum), 1e-6))
    gain[0] = 1.0
    gain = np.clip(gain, 0.0, 8.0)
    return np.fft.irfft2(spectrum * gain[_sectors(values.shape[0])], values.shape[:2], axes=(0, 1))


def _with_colours(values: np.ndarray, target: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return colours (n, 3) with nearly the distribution of `target` (n, 3)."""
    values = values.copy()
    for _ in range(_S.turns):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        mine, theirs = values @ turn, target @ turn
        for axis in range(3):
            order = np.argsort(mine[:, axis], kind="stable")
            mine[order, axis] = np.sort(theirs[:, axis])
        values = mine @ turn.T
    return values
