"""Surface maps: one image for a whole surface, quilted from crops without repeating.

Crops of a surface at the photos' own resolution are brought to one light, scale and direction.
Patches of them, aligned with the pattern's lattice, are quilted on a grid as large as the surface.
Floors, or ceilings, of one material that runs on through rooms share one map.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any

import cv2
import numpy as np

from plan2scene.colour import median_colour
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes, jpeg_bytes, window_counts
from plan2scene.paint.light import recoloured
from plan2scene.paint.shading import log_luma
from plan2scene.photos.patterns.bonds import PX_PER_M
from plan2scene.plans.surface_areas import Area, surface_areas
from plan2scene.seeds import generator
from plan2scene.textures.exemplar.lattice import straightened
from plan2scene.textures.exemplar.make import Pattern
from plan2scene.textures.laying import (
    LaidPattern,
    laid,
    laid_tile,
    pattern_of,
    with_joints,
)
from plan2scene.textures.quilting import Cell, Patches, Source, quilted
from plan2scene.textures.tiles import Tile


@dataclass(frozen=True)
class MapSettings:
    """Tuned constants. Chosen by looking at maps of development homes, real and synthetic."""

    px_per_m: float = 256.0  #: highest resolution of a map; less where the photos have less
    least_px_per_m: float = 32.0  #: lowest one, so that a colour border on a wall keeps its place
    finer: float = 1.2  #: resolution of a plane's finer direction over the mean of both
    unseen: float = 0.7  #: root mean square, sRGB levels, up to which lost detail is invisible
    steps: tuple[float, ...] = (0.75, 0.5, 0.375, 0.25, 0.1875)  #: shares of the resolution tried
    most_crops: int = 20  #: largest number of crops in a map
    enough_m2: float = 1.5  #: once the crops show this area, no more planes of photos are added
    level_m: float = 0.15  #: slower variations (sigma) are levelled: a quilt would scatter them
    smooth_px: float = 6.0  #: sigma, crop pixels, of the filter that compares a crop's light
    step_m: float = 0.3  #: distance between patches, where the crops are large enough
    overlap_m: float = 0.1  #: width of their overlap, where the crops are large enough
    most_patches: int = 500  #: largest number to choose from, since each pair's cost is computed
    share: float = 0.85  #: largest side of a patch without a lattice, over its source's side
    least_patch_px: int = 12  #: least side of a patch
    phases: int = 48  #: number of bins of a period
    most_px: int = 4096  #: largest side of a map: every graphics processor can hold it
    quality: int = 88  #: quality of the JPEG files
    spread: float = 2.5  #: largest area of the rectangle around rooms of one map, over their areas


MAPS = MapSettings()


@dataclass(frozen=True, eq=False)
class Detail:
    """The sources of a map."""

    sources: list[Source]  #: float sRGB in [0, 1] at `px_per_m`, the best first
    px_per_m: float
    resolved: float  #: median over the crops of their photo pixels per metre
    #: (float, float): Periods of the lattice along x and y, pixels; NaN for none
    periods: tuple[float, float]
    #: (n, 3) float: Number of the photo's plane that each source shows, and its middle there,
    #: pixels (x, y)
    origins: np.ndarray
    turned: np.ndarray  #: (n,) bool: Whether each source is turned by 90 degrees against its plane


def detail_of_pattern(pattern: Pattern, size_m: float) -> Detail:
    """Return the sources of a map from the crops of a tile.

    `size_m` is the side that the tile covers; it gives the scale where no crop has a known one.
    """
    if not np.isfinite(pattern.size_m):
        side = size_m / float(np.sqrt(pattern.cut.wide * pattern.cut.high))
        pattern = replace(pattern, size_m=side)
    pattern = replace(pattern, order=various(pattern))
    resolved = float(np.median([_resolved(pattern, k) for k in pattern.order]))
    px_per_m = float(np.clip(MAPS.finer * resolved, MAPS.least_px_per_m, MAPS.px_per_m))
    sources = _sources(pattern, px_per_m)
    share = seen_share(sources)
    if share < 1.0:
        px_per_m = max(share * px_per_m, MAPS.least_px_per_m)
        sources = _sources(pattern, px_per_m)
    work = round(pattern.size_m * px_per_m)
    cut = pattern.cut
    periods = [work / n if n else float("nan") for n in (cut.columns, cut.rows)]
    origins = _origins(pattern) * [1.0, px_per_m, px_per_m]
    turned = pattern.turned[pattern.order]
    return Detail(sources, px_per_m, resolved, (periods[0], periods[1]), origins, turned)


def various(pattern: Pattern) -> list[int]:
    """Return the crops of a map, from planes that show much of the surface sharply.

    Photos differ in noise and sharpness, so planes are added only until they show enough. Within a
    plane the largest crops come first, and the best among equally large ones.
    """
    planes: dict[str, list[int]] = {}
    for k in pattern.order:
        planes.setdefault(pattern.crops[k].plane, []).append(k)
    areas = {name: _covered_m2(pattern, members) for name, members in planes.items()}

    def worth(name: str) -> float:
        density = float(np.median([_resolved(pattern, k) for k in planes[name]]))
        return -min(areas[name], MAPS.enough_m2) * density

    chosen: list[int] = []
    covered_m2 = 0.0
    for name in sorted(planes, key=worth):
        sides = {k: -round(float(pattern.sides[k]), 1) for k in planes[name]}
        chosen += sorted(planes[name], key=lambda k: sides[k])[: MAPS.most_crops - len(chosen)]
        covered_m2 += areas[name]
        if covered_m2 >= MAPS.enough_m2 or len(chosen) >= MAPS.most_crops:
            break
    return chosen


def _covered_m2(pattern: Pattern, members: Sequence[int]) -> float:
    """Return the area of the rectangle around crops of a plane, square metres."""
    middles = np.array([pattern.crops[k].centre for k in members])
    half = pattern.size_m * np.array([pattern.sides[k] for k in members])[:, None] / 2
    return float(((middles + half).max(axis=0) - (middles - half).min(axis=0)).prod())


def _origins(pattern: Pattern) -> np.ndarray:
    """Return plane and middle (n, 3), metres, of the crops used; unknown planes are distinct."""
    numbers: dict[str, int] = {}
    rows = []
    for k in pattern.order:
        crop = pattern.crops[k]
        name = crop.plane or f"crop {k}"
        rows.append((numbers.setdefault(name, len(numbers)), *crop.centre))
    return np.array(rows, dtype=np.float64)


def detail_of_tile(tile: np.ndarray, size_m: float) -> Detail:
    """Return a periodic tile (s, s, 3) uint8, repeated 2 x 2, as the only source of a map."""
    image = np.tile(tile, (2, 2, 1)).astype(np.float32) / 255.0
    resolved = tile.shape[0] / size_m
    scale = min(1.0, MAPS.px_per_m / resolved)
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
    """Return the crops that are used, straightened, at `px_per_m`."""
    work = max(8, round(pattern.size_m * px_per_m))
    return levelled([_source(pattern, k, work) for k in pattern.order], px_per_m)


def _source(pattern: Pattern, k: int, work: int) -> Source:
    """Return a crop straightened for a tile of `work` px, at the photo's own resolution."""
    crop = pattern.crops[k]
    if not crop.detail:
        return pattern.source(k, work)
    image, small = image_from_bytes(crop.detail) / 255.0, crop.image / 255.0
    if pattern.turned[k]:
        image, small = np.rot90(image), np.rot90(small)
    even, plain = (cv2.GaussianBlur(i, (0, 0), MAPS.smooth_px) for i in (pattern.flat[k], small))
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
    """Return the sources without variations slower than `MAPS.level_m`.

    Each channel is multiplied by (its mean over all sources) / (its mean nearby).
    """
    near = [_nearby(source, MAPS.level_m * px_per_m) for source in sources]
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
    """Return the least share of the resolution, at most 1, that keeps all visible detail."""
    share = 1.0
    for step in MAPS.steps:
        if max(_lost(source, step) for source in sources[:3]) > MAPS.unseen:
            break
        share = step
    return share


def _lost(source: Source, step: float) -> float:
    """Return the root mean square error of a source at a lower resolution, sRGB levels."""
    height, width = source.valid.shape
    size = (max(1, round(width * step)), max(1, round(height * step)))
    small = cv2.resize(source.image, size, interpolation=cv2.INTER_AREA)
    back = cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)
    lost = (255.0 * (back - source.image))[source.valid]
    return float(np.sqrt((lost**2).mean())) if lost.size else 0.0


def cell(px_per_m: float, period: float, side: float) -> Cell:
    """Return how patches lie along an axis of sources that are `side` px long.

    With a `period` (px; NaN for none) patches are a whole number of periods apart.
    """
    overlap = MAPS.overlap_m * px_per_m
    step = MAPS.step_m * px_per_m
    if math.isfinite(period):
        step = max(1, round(step / period)) * period
        overlap = min(overlap, 0.5 * step)
    else:
        scale = min(1.0, MAPS.share * side / (step + overlap))
        scale = max(scale, MAPS.least_patch_px / (step + overlap))
        step, overlap = step * scale, overlap * scale
    return Cell(step, max(3, round(overlap)), period)


def cut_patches(detail: Detail, rng: np.random.Generator) -> Patches | None:
    """Return patches of the sources of a map; None if no source holds a whole patch.

    If there are more than `MAPS.most_patches`, `rng` draws some of them.
    """
    sources, px_per_m, periods = detail.sources, detail.px_per_m, detail.periods
    sides = [np.median([s.valid.shape[axis] for s in sources]) for axis in (0, 1)]
    down, across = cell(px_per_m, periods[1], sides[0]), cell(px_per_m, periods[0], sides[1])
    shifts = [_phases(sources, axis, c.period) for axis, c in ((0, down), (1, across))]
    places = []
    for k, source in enumerate(sources):
        rows = _starts(source.valid.shape[0], down, shifts[0][k])
        columns = _starts(source.valid.shape[1], across, shifts[1][k])
        if not len(rows) or not len(columns):
            continue
        counts = window_counts(source.valid, down.side, across.side)
        r, c = np.nonzero(counts[np.ix_(rows, columns)] == down.side * across.side)
        of_source = np.stack([np.full(len(r), k), rows[r], columns[c]], axis=1)
        places.append(
            _drawn(of_source, max(1, math.ceil(2 * MAPS.most_patches / len(sources))), rng)
        )
    corners = np.concatenate(places) if places else np.zeros((0, 3), int)
    if not len(corners):
        return None
    images = [np.rint(255 * np.clip(s.image, 0, 1)).astype(np.uint8) for s in sources]
    corners = _drawn(corners, MAPS.most_patches, rng)
    return Patches(images, corners, _middles(detail, corners, down, across), down, across)


def _middles(detail: Detail, places: np.ndarray, down: Cell, across: Cell) -> np.ndarray:
    """Return plane and middle (n, 3), px, of patches at `places` (n, 3), as of :class:`Patches`."""
    source = places[:, 0]
    sizes = np.array([s.valid.shape for s in detail.sources])[source]
    y = places[:, 1] + (down.side - sizes[:, 0]) / 2
    x = places[:, 2] + (across.side - sizes[:, 1]) / 2
    turned = detail.turned[source]
    right, below = np.where(turned, -y, x), np.where(turned, x, y)
    return detail.origins[source] + np.stack([np.zeros(len(x)), right, below], axis=1)


def _drawn(places: np.ndarray, most: int, rng: np.random.Generator) -> np.ndarray:
    """Return at most `most` rows, drawn by `rng`, in their order."""
    if len(places) <= most:
        return places
    return places[np.sort(rng.choice(len(places), most, replace=False))]


def _starts(length: int, axis: Cell, shift: float) -> np.ndarray:
    """Return where patches may begin in a source of `length` px."""
    last = length - axis.side
    if last < 0:
        return np.zeros(0, int)
    if not math.isfinite(axis.period):
        stride = max(1, min(axis.side // 12, last // 6))
        return np.arange(0, last + 1, stride)
    # So that a joint of the lattice lies in the middle of the patches' overlap.
    first = (shift - axis.overlap / 2) % axis.period
    starts = np.rint(np.arange(first, last + 1, axis.period)).astype(int)
    return starts[starts <= last]


def _phases(sources: Sequence[Source], axis: int, period: float) -> np.ndarray:
    """Return where each source's first joint lies along an axis, (n,) px; 0 without a period."""
    if not math.isfinite(period):
        return np.zeros(len(sources))
    profiles = np.stack([_profile(source, axis, period) for source in sources])
    spectra = np.fft.rfft(profiles, axis=1)
    shared, shifts = profiles[0], np.zeros(len(sources), int)
    for _ in range(3):
        match = np.fft.irfft(spectra.conj() * np.fft.rfft(shared), n=MAPS.phases, axis=1)
        shifts = match.argmax(axis=1)
        shared = np.mean([np.roll(p, s) for p, s in zip(profiles, shifts, strict=True)], axis=0)
    joint = int(np.abs(shared - np.median(shared)).argmax())
    return ((joint - shifts) % MAPS.phases + 0.5) * period / MAPS.phases


def _profile(source: Source, axis: int, period: float) -> np.ndarray:
    """Return a source's mean log grey value over one period, (`MAPS.phases`,), of mean 0."""
    luma = log_luma(np.clip(source.image, 0, 1))
    slow = cv2.GaussianBlur(luma, (0, 0), max(period / 3, 1.0))
    weight = source.valid.sum(axis=1 - axis)
    line = ((luma - slow) * source.valid).sum(axis=1 - axis)
    bins = (np.arange(len(line)) * MAPS.phases / period).astype(int) % MAPS.phases
    total = np.bincount(bins, line, MAPS.phases)
    count = np.bincount(bins, weight, MAPS.phases)
    profile = np.divide(total, count, out=np.zeros(MAPS.phases), where=count > 0)
    return np.asarray(profile - profile.mean())


@dataclass(frozen=True)
class SurfaceMap:
    """One image for a whole surface."""

    jpeg: bytes  #: sRGB
    area: Area  #: the area that it covers in the mesh's texture coordinates, metres
    #: px_per_m, photo_px_per_m: pixels per metre of the map, and of the photos of the surface
    px_per_m: float
    photo_px_per_m: float
    pattern: str = ""  #: kind and size of its units (planks, tiles), in words; empty for none

    @classmethod
    def of(
        cls, image: np.ndarray, area: Area, photo_px_per_m: float, pattern: str = ""
    ) -> SurfaceMap:
        """Return the map of an image (h, w, 3) uint8 sRGB that covers an area."""
        jpeg, px_per_m = jpeg_bytes(image, quality=MAPS.quality), image.shape[1] / area.size[0]
        return cls(jpeg, area, px_per_m, photo_px_per_m, pattern)

    def facts(self) -> dict[str, Any]:
        """Return its entry in ``maps.json``."""
        named: dict[str, Any] = {"pattern": self.pattern} if self.pattern else {}
        return named | {
            "origin_m": [round(value, 6) for value in self.area.low],
            "extent_m": [round(value, 6) for value in self.area.size],
            "px_per_m": round(self.px_per_m, 2),
            "photo_px_per_m": round(self.photo_px_per_m, 2),
        }


@dataclass(frozen=True, eq=False)
class MappedSurface:
    """A surface that gets a map: its tile, its area, the material that it shares (or empty)."""

    key: SurfaceKey
    tile: Tile
    area: Area
    material: str


def house_maps(
    house: House,
    tiles: Mapping[SurfaceKey, Tile],
    materials: Mapping[SurfaceKey, str],
    patterns: Mapping[SurfaceKey, LaidPattern],
    *,
    seed: int,
) -> dict[SurfaceKey, SurfaceMap]:
    """Return the maps of all surfaces that have faces.

    A map has the colour of its tile and is quilted from the crops that the tile was quilted from,
    or from the tile itself where there are none. `materials` name what a surface shares with other
    rooms. Floors with a pattern (:func:`patterns_of_floors`) are laid from whole units, or get
    joints alone. Patches are drawn by (seed, house, room, surface).
    """
    areas = surface_areas(house)
    surfaces = [
        MappedSurface(key, tiles[key], areas[key], materials.get(key, ""))
        for key in house.surface_keys()
        if key in tiles and key in areas
    ]
    maps: dict[SurfaceKey, SurfaceMap] = {}
    details: dict[int, Detail] = {}
    floors = [surface for surface in surfaces if surface.key.surface == "floor"]
    everywhere = reduce(Area.union, (floor.area for floor in floors)) if floors else None
    for surface in floors:
        if surface.key in patterns and patterns[surface.key].units:
            maps[surface.key] = _laid(surface, patterns[surface.key], seed, everywhere)
    for group in joined(surface for surface in surfaces if surface.key not in maps):
        detail = _detail(group[0].tile, details)
        rng = generator(seed, "maps", house.id, *group[0].key)
        for key, image, area, resolved in _images(group, detail, rng):
            words = ""
            if key in patterns:
                image, area = with_joints(patterns[key], image, area, everywhere)
                words = patterns[key].words
            maps[key] = SurfaceMap.of(image, area, resolved, words)
    pixels = sum(m.area.square_m * m.px_per_m**2 for m in maps.values())
    _log = logging.getLogger("plan2scene")
    _log.info("house %s: %d surface maps, %.1f Mpx", house.id, len(maps), pixels / 1e6)
    return maps


def patterns_of_floors(
    house: House, tiles: Mapping[SurfaceKey, Tile], patterns: Mapping[SurfaceKey, LaidPattern]
) -> dict[SurfaceKey, LaidPattern]:
    """Return the pattern by which each floor is laid.

    Floors of the same crops are laid alike, bathrooms apart from the other rooms.
    """
    floors = [key for key in house.surface_keys() if key.surface == "floor" and key in tiles]
    wet = {room.id: "Bathroom" in room.types for room in house.rooms}
    floor_patterns = {}
    for key in floors:
        alike_floors = (
            other
            for other in floors
            if tiles[other].pattern is tiles[key].pattern is not None
            and wet[other.room_id] == wet[key.room_id]
        )
        pattern = pattern_of(patterns, key, *alike_floors)
        if pattern is not None:
            floor_patterns[key] = pattern
    return floor_patterns


def tile_of_pattern(tile: Tile, pattern: LaidPattern, size_m: float, seed: int) -> Tile:
    """Return a floor's tile laid by its pattern, of about `size_m` metres and in its colour."""
    colour = median_colour(tile.image)
    image, size_m = laid_tile(pattern, size_m, tile.image.shape[0], colour, seed)
    image = recoloured(image, colour, median_colour(image))
    source = f"{pattern.words}, laid"
    return replace(tile, image=image, size_m=size_m, source=source, tiles_by_construction=True)


def _laid(
    surface: MappedSurface, pattern: LaidPattern, seed: int, whole: Area | None
) -> SurfaceMap:
    """Return the map of a floor that is laid by a pattern, in the colour of its tile.

    `whole` holds all floors of the house.
    """
    colour = median_colour(surface.tile.image)
    image, area = laid(pattern, surface.area, colour, seed, whole)
    image = _fitting(recoloured(image, colour, median_colour(image[::3, ::3])))
    return SurfaceMap.of(image, area, min(PX_PER_M, image.shape[1] / area.size[0]), pattern.words)


def joined(surfaces: Iterable[MappedSurface]) -> list[list[MappedSurface]]:
    """Return groups of surfaces that share a map: floors and ceilings that run on through doors.

    A group has one material and pattern, and its surfaces are near each other. Walls are unrolled
    room by room and share no map.
    """
    groups: list[list[MappedSurface]] = []
    for surface in surfaces:
        for group in groups:
            if _runs_on(group[0], surface):
                areas = [member.area for member in (*group, surface)]
                whole = reduce(Area.union, areas)
                if whole.square_m <= MAPS.spread * sum(area.square_m for area in areas):
                    group.append(surface)
                    break
        else:
            groups.append([surface])
    return groups


def _runs_on(first: MappedSurface, second: MappedSurface) -> bool:
    """Return whether two surfaces are of one material that runs through doors."""
    return (
        first.key.surface == second.key.surface != "wall"
        and first.material == second.material != ""
        and first.tile.pattern is second.tile.pattern is not None
    )


def _detail(tile: Tile, made: dict[int, Detail]) -> Detail:
    """Return the sources of a tile's map, computed once for each pattern."""
    if tile.pattern is None:
        return detail_of_tile(tile.image, tile.size_m)
    if id(tile.pattern) not in made:
        made[id(tile.pattern)] = detail_of_pattern(tile.pattern, tile.size_m)
    return made[id(tile.pattern)]


def _images(
    group: Sequence[MappedSurface], detail: Detail, rng: np.random.Generator
) -> Iterator[tuple[SurfaceKey, np.ndarray, Area, float]]:
    """Yield each surface of a group, its image, the image's area, the photos' pixels per metre."""
    whole, tile = reduce(Area.union, (surface.area for surface in group)), group[0].tile
    patches = cut_patches(detail, rng)
    if patches is None:  # no crop holds a whole patch, but the tile repeated 2 x 2 does
        yield from _images(group, detail_of_tile(tile.image, tile.size_m), rng)
        return
    scale = detail.px_per_m
    width, height = (int(np.ceil(side * scale)) for side in whole.size)
    if tile.regular:
        side = round(tile.size_m * scale)
        image = cv2.resize(tile.image, (side, side), interpolation=cv2.INTER_AREA)
        canvas = np.tile(image, (height // side + 1, width // side + 1, 1))
    else:
        canvas = quilted(patches, height, width, rng)
    median = median_colour(canvas[::3, ::3])
    for surface in group:
        image, area = _part(canvas, whole.low, surface.area, scale)
        image = _fitting(recoloured(image, median_colour(surface.tile.image), median))
        yield surface.key, image, area, detail.resolved


def _part(
    canvas: np.ndarray, origin: tuple[float, float], area: Area, scale: float
) -> tuple[np.ndarray, Area]:
    """Return the pixels of a canvas that cover an area, and the exact area of these pixels."""
    low = [int((area.low[k] - origin[k]) * scale) for k in (0, 1)]
    size = [int(np.ceil(side * scale)) + 1 for side in area.size]
    part = canvas[low[1] : low[1] + size[1], low[0] : low[0] + size[0]]
    corner = (origin[0] + low[0] / scale, origin[1] + low[1] / scale)
    far = (corner[0] + part.shape[1] / scale, corner[1] + part.shape[0] / scale)
    return part, Area(corner, far)


def _fitting(image: np.ndarray) -> np.ndarray:
    """Return an image no larger than `MAPS.most_px`."""
    scale = MAPS.most_px / max(image.shape[:2])
    if scale >= 1.0:
        return image
    size = (max(1, int(image.shape[1] * scale)), max(1, int(image.shape[0] * scale)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
