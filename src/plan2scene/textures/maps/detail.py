"""Crops of a surface at the photos' own resolution, brought to one light, scale and direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.images import image_from_bytes
from plan2scene.textures.exemplar.make import Pattern
from plan2scene.textures.exemplar.straighten import straightened
from plan2scene.textures.quilting import Source

#: Pixels per metre of a map where the photos have as many.
PX_PER_M = 256.0
#: What a map has at least, so that a wall's edge of colour stays where it is.
LEAST_PX_PER_M = 32.0
#: The finer direction of a plane seen at a slant has so many times the mean photo pixels.
_FINER = 1.2
#: Root mean square in sRGB levels below which detail is not seen, and left away.
_UNSEEN = 0.7
_STEPS = (0.75, 0.5, 0.375, 0.25, 0.1875)
#: Crops that a map is made of, at most, and what they show together where the photos show as much.
MOST_CROPS, ENOUGH_M2 = 20, 1.5
#: Variations slower than this (sigma) are levelled: patches of a quilt would scatter them, metres.
LEVEL_M = 0.15
_SMOOTH = 6.0  # px of a crop: the light's changes are slower


@dataclass(frozen=True, eq=False)
class Detail:
    """The sources of a map.

    Attributes
    ----------
    sources : list of Source
        Float sRGB in [0, 1] at `px_per_m`, the best first.
    px_per_m : float
    resolved : float
        Photo pixels per metre that the crops have, in the median.
    periods : (float, float)
        Of the lattice along x and y, pixels; NaN for none.
    origins : (n, 3) float
        Number of the photo's plane that each source shows, and its middle there, pixels (x, y).
    turned : (n,) bool
        Which sources are turned by 90 degrees against their plane.
    """

    sources: list[Source]
    px_per_m: float
    resolved: float
    periods: tuple[float, float]
    origins: np.ndarray
    turned: np.ndarray


def detail_of_pattern(pattern: Pattern, size_m: float) -> Detail:
    """Return the sources that a tile's crops give.

    `size_m` is what the tile covers: the scale where no crop knows its own.
    """
    if not np.isfinite(pattern.size_m):
        side = size_m / float(np.sqrt(pattern.cut.wide * pattern.cut.high))
        pattern = replace(pattern, size_m=side)
    pattern = replace(pattern, order=various(pattern))
    resolved = float(np.median([_resolved(pattern, k) for k in pattern.order]))
    px_per_m = float(np.clip(_FINER * resolved, LEAST_PX_PER_M, PX_PER_M))
    sources = _sources(pattern, px_per_m)
    share = seen_share(sources)
    if share < 1.0:
        px_per_m = max(share * px_per_m, LEAST_PX_PER_M)
        sources = _sources(pattern, px_per_m)
    work = round(pattern.size_m * px_per_m)
    cut = pattern.cut
    periods = [work / n if n else float("nan") for n in (cut.columns, cut.rows)]
    origins = _origins(pattern) * [1.0, px_per_m, px_per_m]
    turned = pattern.turned[pattern.order]
    return Detail(sources, px_per_m, resolved, (periods[0], periods[1]), origins, turned)


def various(pattern: Pattern) -> list[int]:
    """Return the crops of a map: of planes that show much of the surface, and sharply.

    Photos differ in noise and sharpness, so planes are added only until they show `ENOUGH_M2`; of
    each plane the largest crops, of equals the best first.
    """
    planes: dict[str, list[int]] = {}
    for k in pattern.order:
        planes.setdefault(pattern.crops[k].plane, []).append(k)
    areas = {name: _shown_m2(pattern, members) for name, members in planes.items()}

    def worth(name: str) -> float:
        density = float(np.median([_resolved(pattern, k) for k in planes[name]]))
        return -min(areas[name], ENOUGH_M2) * density

    chosen: list[int] = []
    shown = 0.0
    for name in sorted(planes, key=worth):
        sides = {k: -round(float(pattern.sides[k]), 1) for k in planes[name]}
        chosen += sorted(planes[name], key=lambda k: sides[k])[: MOST_CROPS - len(chosen)]
        shown += areas[name]
        if shown >= ENOUGH_M2 or len(chosen) >= MOST_CROPS:
            break
    return chosen


def _shown_m2(pattern: Pattern, members: Sequence[int]) -> float:
    """Return the area of the rectangle around crops of a plane, square metres."""
    middles = np.array([pattern.crops[k].centre for k in members])
    half = pattern.size_m * np.array([pattern.sides[k] for k in members])[:, None] / 2
    return float(((middles + half).max(axis=0) - (middles - half).min(axis=0)).prod())


def _origins(pattern: Pattern) -> np.ndarray:
    """Return plane and middle (n, 3) of the crops that take part, metres; apart where unknown."""
    numbers: dict[str, int] = {}
    rows = []
    for k in pattern.order:
        crop = pattern.crops[k]
        name = crop.plane or f"crop {k}"
        rows.append((numbers.setdefault(name, len(numbers)), *crop.centre))
    return np.array(rows, dtype=np.float64)


def detail_of_tile(tile: np.ndarray, size_m: float) -> Detail:
    """Return a tile (s, s, 3) uint8 that repeats as the only source, laid out twice each way."""
    image = np.tile(tile, (2, 2, 1)).astype(np.float32) / 255.0
    resolved = tile.shape[0] / size_m
    scale = min(1.0, PX_PER_M / resolved)
    source = Source(image, np.ones(image.shape[:2], bool))
    scale *= seen_share([source])
    if scale < 1.0:
        side = max(8, round(image.shape[0] * scale))
        image = cv2.resize(image, (side, side), interpolation=cv2.INTER_AREA)
        source = Source(image, np.ones(image.shape[:2], bool))
    nothing = (float("nan"), float("nan"))
    whole = image.shape[0] / (2 * size_m), resolved, nothing
    return Detail([source], *whole, np.zeros((1, 3)), np.zeros(1, bool))


def _resolved(pattern: Pattern, k: int) -> float:
    """Return the photo pixels per metre of a crop of a pattern, no more than its image has."""
    crop = pattern.crops[k]
    size_m = pattern.sides[k] * pattern.size_m
    side = crop.image.shape[0]
    sharp = crop.sharpness if np.isfinite(crop.sharpness) else 1.0
    return side * (sharp if crop.detail else min(sharp, 1.0)) / size_m


def _sources(pattern: Pattern, px_per_m: float) -> list[Source]:
    """Return the crops that take part, straightened, at `px_per_m`."""
    work = max(8, round(pattern.size_m * px_per_m))
    return levelled([_source(pattern, k, work) for k in pattern.order], px_per_m)


def _source(pattern: Pattern, k: int, work: int) -> Source:
    """Return a crop straightened for a tile of `work` px, of the photo's own pixels."""
    crop = pattern.crops[k]
    if not crop.detail:
        return pattern.source(k, work)
    image, small = image_from_bytes(crop.detail) / 255.0, crop.image / 255.0
    if pattern.turned[k]:
        image, small = np.rot90(image), np.rot90(small)
    even, plain = (cv2.GaussianBlur(i, (0, 0), _SMOOTH) for i in (pattern.flat[k], small))
    side = image.shape[0]
    gain = cv2.resize(even / np.maximum(plain, 1 / 255), (side, side))
    mask = cv2.resize(pattern.masks[k].astype(np.uint8), (side, side)) > 0
    lattice, scale = pattern.lattices[k], side / small.shape[0]
    periods = (lattice.periods[0] * scale, lattice.periods[1] * scale)
    return straightened(
        np.clip(image * gain, 0.0, 1.0),
        mask,
        float(pattern.sides[k]),
        replace(lattice, periods=periods),
        pattern.cut,
        work,
    )


def levelled(sources: Sequence[Source], px_per_m: float) -> list[Source]:
    """Return the sources with one colour everywhere, but for what varies faster than `LEVEL_M`.

    Each channel is scaled by its mean over all sources over its mean nearby.
    """
    near = [_nearby(source, LEVEL_M * px_per_m) for source in sources]
    level = np.mean([n[s.valid].mean(axis=0) for n, s in zip(near, sources, strict=True)], axis=0)
    gains = (level / np.maximum(n, 1 / 255) for n in near)
    return [
        replace(source, image=(source.image * gain).astype(np.float32))
        for source, gain in zip(sources, gains, strict=True)
    ]


def _nearby(source: Source, sigma: float) -> np.ndarray:
    """Return the mean colour of a source's valid pixels near each, (h, w, 3) float32."""
    height, width = source.valid.shape
    scale = min(1.0, 4.0 / sigma)
    size = (max(2, round(width * scale)), max(2, round(height * scale)))
    weight = source.valid.astype(np.float32)
    total = cv2.resize(source.image * weight[..., None], size, interpolation=cv2.INTER_AREA)
    weight = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
    total, weight = (
        cv2.GaussianBlur(a, (0, 0), sigma * scale, borderType=cv2.BORDER_CONSTANT)
        for a in (total, weight)
    )
    mean = total / np.maximum(weight, 1e-3)[..., None]
    return np.asarray(cv2.resize(mean, (width, height), interpolation=cv2.INTER_LINEAR))


def seen_share(sources: Sequence[Source]) -> float:
    """Return the share of the resolution below which nothing visible is lost, at most 1."""
    share = 1.0
    for step in _STEPS:
        if max(_lost(source, step) for source in sources[:3]) > _UNSEEN:
            break
        share = step
    return share


def _lost(source: Source, step: float) -> float:
    """Return what of a source a lower resolution loses, root mean square in sRGB levels."""
    height, width = source.valid.shape
    size = (max(1, round(width * step)), max(1, round(height * step)))
    small = cv2.resize(source.image, size, interpolation=cv2.INTER_AREA)
    back = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)
    lost = (255.0 * (back - source.image))[source.valid]
    return float(np.sqrt((lost**2).mean())) if lost.size else 0.0
