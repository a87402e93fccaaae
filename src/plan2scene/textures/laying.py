"""Floors laid from whole planks and tiles that were cut out of photos.

The rows follow the plan's grid, not the room's, so planks run on through doors. A place gets one of
the units that were last used farthest away, each time mirrored or turned differently.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import groupby
from pathlib import Path

import cv2
import numpy as np

from plan2scene.colour import as_uint8
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet
from plan2scene.photos.patterns.bonds import LAID, PX_PER_M, Zigzag
from plan2scene.plans.surface_areas import Area

#: Rows of pixels of a floor that are worked on together, to limit the memory.
_ROWS_AT_ONCE = 64
_Point = tuple[float, ...]


@dataclass(frozen=True)
class LayingSettings:
    """Tuned constants. Chosen by looking at maps of development homes."""

    least_units: int = 6  #: fewer units are not laid: equal ones would lie side by side
    px_per_m: float = 256.0  #: pixels per metre of a map
    upright_deg: float = 6.0  #: a floor is laid along a plan axis if its angle to it is no larger
    sight_m: float = 3.0  #: distance up to which equal units are kept apart
    drawn: float = 0.25  #: share of the units, those used farthest away, of which one is drawn
    #: weight of a tile's side that is not the one asked for (log ratio); stretched units weigh 1
    other_size: float = 0.5
    run: float = 0.4  #: least share that is laid of a run of planks without a known length


LAYING = LayingSettings()


@dataclass(frozen=True, eq=False)
class LaidPattern:
    """How a floor is laid, a row of ``patterns.parquet`` (docs/conventions.md)."""

    kind: str  #: ``planks``, ``tiles``, ``herringbone`` or ``chevron``
    width_m: float  #: width_m, length_m: of a unit; length NaN for planks of many lengths
    length_m: float
    direction_deg: float  #: of the length, from +x towards +z; NaN where not known
    offset: float  #: shift of a row against the row before, over the length
    #: (3,) float: Darkness of a joint, (units' sRGB - joint's sRGB) / units' sRGB
    joint: np.ndarray
    joint_m: float
    #: list of (h, w, 3) uint8: sRGB levels, 127.5 where the floor has its usual colour; empty where
    #: only joints are known
    units: list[np.ndarray]
    #: id of the room whose floor runs on into this one, if no photo shows this one's; else empty
    like: str = ""
    slant_deg: float = 0.0  #: angle of units to `direction_deg` in herringbones, chevrons; else 0

    @property
    def square(self) -> bool:
        """Return whether units are as long as wide."""
        return bool(abs(self.length_m - self.width_m) < 1e-6)

    @property
    def longest_m(self) -> float:
        """Return the length of the longest unit."""
        return max(unit.shape[1] for unit in self.units) / PX_PER_M

    @property
    def words(self) -> str:
        """Return kind and size as ``planks 15 x 60 cm``."""
        width = f"{self.kind} {100 * self.width_m:.0f}"
        known = np.isfinite(self.length_m)
        return f"{width} x {100 * self.length_m:.0f} cm" if known else f"{width} cm wide"


def read_patterns(path: str | Path) -> dict[SurfaceKey, LaidPattern]:
    """Return the patterns of ``patterns.parquet`` that floors can be laid by.

    A pattern without units has a known size, but no photo shows enough whole units.
    """
    table, _ = read_parquet(path)
    patterns = {}
    for row in table.itertuples():
        units = row.units if len(row.units) >= LAYING.least_units else []
        if row.kind not in LAID or not (len(units) or np.isfinite(row.length_m)):
            continue
        patterns[SurfaceKey(row.room_id, row.surface)] = LaidPattern(
            row.kind,
            float(row.width_m),
            float(row.length_m),
            float(row.direction_deg),
            float(row.offset),
            np.array(row.joint, dtype=np.float64),
            float(row.joint_m),
            [image_from_bytes(unit) for unit in units],
            row.like,
            float(row.slant_deg),
        )
    return patterns


def pattern_of(patterns: Mapping[SurfaceKey, LaidPattern], *keys: SurfaceKey) -> LaidPattern | None:
    """Return the first pattern found for `keys`, or that of the room that it is `like`."""
    pattern = next((patterns[key] for key in keys if key in patterns), None)
    return pattern and patterns.get(SurfaceKey(pattern.like, keys[0].surface), pattern)


def laid(
    pattern: LaidPattern, area: Area, colour: np.ndarray, seed: int, whole: Area | None = None
) -> tuple[np.ndarray, Area]:
    """Return a floor's image (h, w, 3) uint8 sRGB, and the area that it covers.

    Rows are +z and columns +x of the plan. `colour` (3,) is the floor's usual sRGB in [0, 1].
    `whole` is an area that holds all floors: with the same `whole` and `seed` they match at doors.
    """
    scale = LAYING.px_per_m
    low, size = _pixels(area)
    turn = _turn(pattern, size)
    first, last = _extent(low, size, turn)
    begin, end = map(tuple, (_extent(*_pixels(whole or area), turn) / scale).tolist())
    if pattern.slant_deg:
        rows = _columns(pattern, first, last, _planks(pattern, begin, end, seed))
    else:
        rows = _rows(pattern, first, last, _places(pattern, begin, end, seed))
    # From pixel centres of the map to pixel centres of the rows.
    middle = turn @ (low + 0.5) - first - 0.5
    to_rows = np.column_stack([turn, middle])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    shape = (int(size[0]), int(size[1]))
    image = cv2.warpAffine(rows, to_rows, shape, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    laid_image = as_uint8(np.clip(2.0 * image * colour, 0.0, 1.0))
    near, far = low / scale, (low + size) / scale
    return laid_image, Area((float(near[0]), float(near[1])), (float(far[0]), float(far[1])))


def with_joints(
    pattern: LaidPattern, image: np.ndarray, area: Area, whole: Area | None = None
) -> tuple[np.ndarray, Area]:
    """Return a floor's image (h, w, 3) uint8 sRGB with a pattern's joints drawn, and its area.

    `whole` as in :func:`laid`.
    """
    plain = replace(pattern, units=[np.full((2, 2, 3), 128, np.uint8)])
    joints, area = laid(plain, area, np.full(3, 0.5), 0, whole)
    size = (joints.shape[1], joints.shape[0])
    fine = cv2.resize(image, size, interpolation=cv2.INTER_LINEAR)
    return as_uint8(np.clip(fine / 255.0 * (joints / 128.0), 0.0, 1.0)), area


def laid_tile(
    pattern: LaidPattern, size_m: float, size_px: int, colour: np.ndarray, seed: int
) -> tuple[np.ndarray, float]:
    """Return a tile (s, s, 3) uint8 sRGB that repeats without a seam, and the metres of its side.

    The side is about `size_m`, so that whole units, stretched a little, fill it both ways. They lie
    along the nearer axis of the plan; `colour` as in :func:`laid`.
    """
    sized, side, counts = _whole_units(pattern, size_m)
    pixels = np.full(2, round(side * LAYING.px_per_m))
    corner = np.zeros(2, int)
    if pattern.slant_deg:
        rows = _columns(sized, corner, pixels, _wrapped_planks(sized, side, seed))
    else:
        places = list(_wrapped_places(sized, side, counts, seed))
        rows = _rows(sized, corner, pixels, places)
    angle = pattern.direction_deg
    if np.isfinite(angle) and round(angle / 90.0) % 2:
        rows = rows.swapaxes(0, 1)
    image = cv2.resize(rows, (size_px, size_px), interpolation=cv2.INTER_AREA)
    return as_uint8(np.clip(2.0 * image * colour, 0.0, 1.0)), side


def _whole_units(pattern: LaidPattern, size_m: float) -> tuple[LaidPattern, float, tuple[int, int]]:
    """Return the pattern stretched to fill a square, the square's side, and the counts along, down.

    The counts are those of whole units; of a herringbone or chevron, of whole periods.
    """
    long, wide = pattern.length_m, pattern.width_m
    if pattern.slant_deg:
        wide, long = _zigzag(pattern).period_m
    known = np.isfinite(long)
    long = long if known else pattern.longest_m / 2

    def worth(down: int) -> float:
        side = down * wide
        stretched = abs(np.log(max(1, round(side / long)) * long / side)) if known else 0.0
        return float(stretched + LAYING.other_size * abs(np.log(side / size_m)))

    down = min(range(1, 2 + round(2 * size_m / wide)), key=worth)
    along = max(1, round(down * wide / long))
    side = 0.5 * (down * wide + along * long) if known else down * wide
    side = round(side * LAYING.px_per_m) / LAYING.px_per_m
    if pattern.slant_deg:
        sine = np.sin(np.radians(pattern.slant_deg))
        sizes = {"width_m": side / down * sine, "length_m": side / along / (2 * sine)}
    else:
        length = side / along if known else float("nan")
        sizes = {"width_m": side / down, "length_m": length}
    offset = round(pattern.offset * down) / down
    return replace(pattern, **sizes, offset=offset), side, (along, down)


def _wrapped_places(
    pattern: LaidPattern, side: float, counts: tuple[int, int], seed: int
) -> Iterator[_Place]:
    """Yield the places of units in a square that repeats, row by row."""
    rng = np.random.default_rng(seed)
    used = _Used(len(pattern.units))
    along, down = counts
    length = side / along
    ways = rng.permutation(8 if pattern.square else 4)
    for row in range(down):
        first = pattern.offset * row % 1.0 if np.isfinite(pattern.length_m) else rng.random()
        for k in range(along):
            start = (first + k) * length
            unit = used.next(start + length / 2, (row + 0.5) * pattern.width_m, rng)
            spare = max(0.0, 1.0 - length * PX_PER_M / pattern.units[unit].shape[1])
            way, begin = int(ways[used.turns[unit] % len(ways)]), float(rng.uniform(0.0, spare))
            place = _Place(row, start, start + length, unit, way, begin)
            yield place
            if place.end > side:
                yield replace(place, start=place.start - side, end=place.end - side)


def _wrapped_planks(
    pattern: LaidPattern, side: float, seed: int
) -> dict[tuple[int, int], tuple[int, int]]:
    """Return units and turns as :func:`_planks`, equal on opposite borders of a square."""
    high = side + pattern.length_m
    planks = dict(_planks(pattern, (0.0, 0.0), (high, high), seed))
    zigzag, step = _zigzag(pattern), pattern.width_m / 3
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.arange(0.0, high, step)] * 2))
    beyond = (x >= side) | (y >= side)
    x, y = x[beyond], y[beyond]
    pairs = np.hstack([zigzag.planks(x, y)[0], zigzag.planks(x % side, y % side)[0]])
    for _ in range(3):  # a plank at one corner is also that at the three other corners
        for *there, row, column in np.unique(pairs, axis=0).tolist():
            planks[there[0], there[1]] = planks[row, column]
    return planks


def _pixels(area: Area) -> tuple[np.ndarray, np.ndarray]:
    """Return the first pixel (2,) of an area and its size (2,) in the plan's grid."""
    low = np.floor(np.array(area.low) * LAYING.px_per_m).astype(int)
    return low, np.ceil(np.array(area.high) * LAYING.px_per_m).astype(int) - low


def _turn(pattern: LaidPattern, size: np.ndarray) -> np.ndarray:
    """Return the rotation (2, 2) from the plan to rows along x; by the room's `size` if unknown."""
    angle = pattern.direction_deg
    if not np.isfinite(angle):
        angle = 0.0 if size[0] >= size[1] else 90.0
    upright = round(angle / 90.0) * 90.0
    if abs(angle - upright) <= LAYING.upright_deg:
        angle = upright
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[cosine, sine], [-sine, cosine]])


def _extent(low: np.ndarray, size: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the first and last pixel (2, 2) of a rectangle, along and down the rows."""
    corners = low + size * np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    along = corners @ turn.T
    return np.array([np.floor(along.min(axis=0)), np.ceil(along.max(axis=0)) + 1]).astype(int)


@dataclass(frozen=True)
class _Place:
    """Where a unit lies: number of its row, its ends (metres), and how it is turned."""

    row: int
    start: float
    end: float
    unit: int
    way: int
    begin: float  #: where the laid part of a run begins, as a share of the run


@dataclass
class _Used:
    """Where units have been laid, and how often."""

    count: int
    turns: np.ndarray = field(init=False)
    units: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    places: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))  #: (x, y), metres

    def __post_init__(self) -> None:
        self.turns = np.zeros(self.count, int)

    def next(self, x: float, y: float, rng: np.random.Generator) -> int:
        """Return a unit for the place (x, y), drawn from those that were used farthest away."""
        away = np.full(self.count, LAYING.sight_m)
        np.minimum.at(away, self.units, np.hypot(*(self.places - (x, y)).T))
        far = np.argsort(-(away + 1e-3 * rng.random(self.count)))
        unit = int(far[rng.integers(max(1, round(LAYING.drawn * self.count)))])
        self.turns[unit] += 1
        self.units = np.append(self.units, unit)
        self.places = np.vstack([self.places, (x, y)])
        return unit

    def forget(self, above: float) -> None:
        """Forget places whose y is less than `above`, metres."""
        kept = self.places[:, 1] >= above
        self.units, self.places = self.units[kept], self.places[kept]


@lru_cache(maxsize=16)
def _places(pattern: LaidPattern, low: _Point, high: _Point, seed: int) -> list[_Place]:
    """Return the places of units in all rows between two corners, metres, row by row.

    Cached for the other floors that run on from this one.
    """
    rng = np.random.default_rng(seed)
    used, places = _Used(len(pattern.units)), []
    rows = np.floor([low[1] / pattern.width_m, high[1] / pattern.width_m + 1]).astype(int)
    ways = rng.permutation(8 if pattern.square else 4)
    for row in range(*rows):
        y = (row + 0.5) * pattern.width_m
        used.forget(y - LAYING.sight_m)
        length = pattern.length_m
        if np.isfinite(length):
            begin = (pattern.offset * row % 1.0) * length
            end = begin + np.floor((low[0] - begin) / length) * length
        else:
            end = low[0] - rng.uniform(0.0, pattern.longest_m)
        while end < high[0]:
            start, begin = end, 0.0
            usual_length = length if np.isfinite(length) else pattern.longest_m / 2
            unit = used.next(start + usual_length / 2, y, rng)
            end = start + length
            if not np.isfinite(length):
                run = pattern.units[unit].shape[1] / PX_PER_M
                share = rng.uniform(LAYING.run, 1.0)
                begin, end = float(rng.uniform(0.0, 1.0 - share)), start + share * run
            way = int(ways[used.turns[unit] % len(ways)])
            places.append(_Place(row, start, end, unit, way, begin))
    return places


def _zigzag(pattern: LaidPattern) -> Zigzag:
    """Return how the planks of a herringbone or chevron lie."""
    return Zigzag(pattern.kind, pattern.width_m, pattern.length_m, pattern.slant_deg)


@lru_cache(maxsize=16)
def _planks(
    pattern: LaidPattern, low: _Point, high: _Point, seed: int
) -> dict[tuple[int, int], tuple[int, int]]:
    """Return unit and turn of each plank of the columns between two corners, metres."""
    rng = np.random.default_rng(seed)
    used, planks = _Used(len(pattern.units)), {}
    zigzag, step = _zigzag(pattern), pattern.width_m / 3
    x = np.arange(low[0], high[0] + step, step)
    ways = rng.permutation(4)
    for y in np.arange(low[1], high[1] + step, step):
        used.forget(y - LAYING.sight_m)
        number = zigzag.planks(x, np.full_like(x, y))[0]
        for k, key in enumerate(map(tuple, number.tolist())):
            if key not in planks:
                unit = used.next(float(x[k]), float(y), rng)
                planks[key] = unit, int(ways[used.turns[unit] % len(ways)])
    return planks


def _columns(
    pattern: LaidPattern,
    first: np.ndarray,
    last: np.ndarray,
    planks: Mapping[tuple[int, int], tuple[int, int]],
) -> np.ndarray:
    """Return columns of planks (h, w, 3) float32, as :func:`_rows` does."""
    scale = LAYING.px_per_m
    high, long = pattern.units[0].shape[:2]
    atlas = np.concatenate(pattern.units) / np.float32(255.0)
    depth, joint = pattern.joint.astype(np.float32), max(pattern.joint_m, 1e-6)
    canvas = np.empty((last[1] - first[1], last[0] - first[0], 3), np.float32)
    x = (np.arange(first[0], last[0]) + 0.5) / scale
    zigzag = _zigzag(pattern)
    for top in range(0, len(canvas), _ROWS_AT_ONCE):
        part = canvas[top : top + _ROWS_AT_ONCE]
        y = (np.arange(top, top + len(part)) + first[1] + 0.5) / scale
        number, along, over, border = zigzag.planks(*np.broadcast_arrays(x, y[:, None]))
        low = number.min(axis=(0, 1))
        codes = (number - low) @ [int(np.ptp(number[..., 1])) + 1, 1]  # one integer a plank
        _, place, which = np.unique(codes, return_index=True, return_inverse=True)
        keys = number.reshape(-1, 2)[place].tolist()
        known = np.array([planks.get((row, column), (0, 0)) for row, column in keys])
        unit, way = np.moveaxis(known[which.reshape(codes.shape)], -1, 0)
        along = np.where(way & 1, -along, along) / pattern.length_m + 0.5
        over = np.where(way & 2, -over, over) / pattern.width_m + 0.5
        column = np.clip(along * long - 0.5, 0, long - 1).astype(np.float32)
        line = (unit * high + np.clip(over * high - 0.5, 0, high - 1)).astype(np.float32)
        cv2.remap(atlas, column, line, cv2.INTER_LINEAR, dst=part)
        covered = np.clip((max(joint, 1 / scale) / 2 - border) * scale + 0.5, 0.0, 1.0)
        part *= 1.0 - (covered * min(1.0, joint * scale))[..., None] * depth
    return canvas


def _rows(
    pattern: LaidPattern, first: np.ndarray, last: np.ndarray, places: Sequence[_Place]
) -> np.ndarray:
    """Return rows of units (h, w, 3) float32, 0.5 where the floor has its usual colour.

    `first` and `last` (2,) are pixels along and down the grid, whose row 0 begins at pixel 0.
    """
    scale = LAYING.px_per_m
    width = pattern.width_m * scale
    canvas = np.full((last[1] - first[1], last[0] - first[0], 3), 0.5, np.float32)
    depth = pattern.joint.astype(np.float32)
    joint = max(pattern.joint_m * scale, 1e-6)
    for number, row in groupby(places, key=lambda place: place.row):
        top, bottom = number * width, (number + 1) * width
        low, high = max(round(top), first[1]), min(round(bottom), last[1])
        if low >= high:
            continue
        laid_row = canvas[low - first[1] : high - first[1]]
        ends = []
        for place in row:
            ends.append(place.end * scale)
            _lay(pattern, place, laid_row, first[0], (low - round(top), round(bottom) - round(top)))
        line = _coverage(np.arange(low, high) + 0.5, [top, bottom], joint)
        across = np.arange(first[0], last[0]) + 0.5
        joints = np.maximum(line[:, None], _coverage(across, ends, joint))
        laid_row *= 1.0 - joints[..., None] * depth
    return canvas


def _lay(
    pattern: LaidPattern, place: _Place, row: np.ndarray, first: int, rows: tuple[int, int]
) -> None:
    """Put a unit into a row's image (h, w, 3), whose columns begin at pixel `first`.

    `rows`: the unit's pixel row that is the image's first, and how many pixel rows the unit has.
    """
    left, right = (round(end * LAYING.px_per_m) for end in (place.start, place.end))
    low, high = max(left, first), min(right, first + row.shape[1])
    if low >= high:
        return
    unit = pattern.units[place.unit]
    if not np.isfinite(pattern.length_m):
        columns = round((place.end - place.start) * PX_PER_M)
        begin = round(place.begin * unit.shape[1])
        unit = unit[:, begin : begin + columns]
    unit = unit[:: -1 if place.way & 1 else 1, :: -1 if place.way & 2 else 1]
    if place.way & 4:
        unit = unit.swapaxes(0, 1)
    size = (right - left, rows[1])
    image = cv2.resize(np.ascontiguousarray(unit), size, interpolation=cv2.INTER_LINEAR)
    part = image[rows[0] : rows[0] + row.shape[0], low - left : high - left]
    row[:, low - first : high - first] = part / 255.0


def _coverage(places: np.ndarray, joints: list[float], width: float) -> np.ndarray:
    """Return how much of each pixel (n,) at `places` the joints cover, 0..1."""
    if not joints:
        return np.zeros(len(places))
    ordered = np.sort(joints)
    at = np.searchsorted(ordered, places)
    before = np.abs(places - ordered[np.maximum(at - 1, 0)])
    after = np.abs(ordered[np.minimum(at, len(ordered) - 1)] - places)
    away = np.minimum(before, after)
    covered = np.clip((max(width, 1.0) / 2 - away) + 0.5, 0.0, 1.0) * min(1.0, width)
    return np.asarray(covered)
