"""Divide open floors that hold several names: rooms that meet without a wall.

A straight line divides two of them: where a printed size ends, where a thin line is drawn, or from
a corner across a neck.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from plan2scene.plans.room_names import room_types
from plan2scene_app.plan_formats.measures import sides_in_feet
from plan2scene_app.tracing.ink import ink_of
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.regions import Regions, grown
from plan2scene_app.tracing.scale import read_room_sides
from plan2scene_app.tracing.settings import OPENINGS, SETTINGS


@dataclass(frozen=True)
class _Named:
    """A name at `place` (x, y) pixels: its first room type, and the sides in metres beside it."""

    place: tuple[float, float]
    type: str
    sides: tuple[float, ...]


def with_open_rooms(
    regions: Regions,
    polygons: dict[int, Polygon],
    image: np.ndarray,
    lines: Sequence[TextLine],
    metres: float,
) -> Regions:
    """Return the regions, rooms with several names divided; `metres` is the size of a pixel."""
    ink = ink_of(image) > SETTINGS.faint
    # A dividing line must not end in a door or window, as it would halve it.
    opening_mask = np.isin(regions.structure, list(OPENINGS))
    opened = ndimage.binary_dilation(opening_mask, iterations=1 + round(regions.wall_px))
    feet = sides_in_feet(line.text for line in lines)
    floors, count = regions.floors.copy(), regions.count
    names = list(_named(lines, feet=feet))
    for number in polygons:
        floor_names = [one for one in names if _at(floors, one.place) == number]
        for k, one in enumerate(floor_names):
            for other in floor_names[k + 1 :]:
                sized = one.sides and other.sides
                if (one.type == other.type and not sized) or _at(floors, one.place) != _at(
                    floors, other.place
                ):
                    continue
                joint_floor = floors == _at(floors, one.place)
                part = _divided(joint_floor, one, other, (ink, opened), metres, regions.ppm)
                if part is not None:
                    count += 1
                    floors[part] = count
    if count == regions.count:
        return regions
    return replace(
        regions, floors=floors, count=count, rooms=grown(floors, regions.wall_px, regions.ppm)
    )


def _named(lines: Sequence[TextLine], *, feet: bool) -> Iterator[_Named]:
    """Yield the names of rooms, without those of wardrobes."""
    sizes = [(line, pairs[0]) for line in lines if (pairs := read_room_sides(line.text, feet=feet))]
    for line in lines:
        types = room_types(line.text)
        if not types or types[0] == "Closet":
            continue
        reach = SETTINGS.size_beside * min(line.size)
        near = [
            (float(np.linalg.norm(np.subtract(size.middle, line.middle))), sides)
            for size, sides in sizes
        ]
        sides = min((one for one in near if one[0] < reach), default=(0.0, ()))[1]
        yield _Named(line.middle, types[0], tuple(sides))


def _at(floors: np.ndarray, place: tuple[float, float]) -> int:
    """Return the floor at a place (x, y), 0 for none."""
    x, y = round(place[0]), round(place[1])
    inside = 0 <= y < floors.shape[0] and 0 <= x < floors.shape[1]
    return int(floors[y, x]) if inside else 0


def _divided(
    own: np.ndarray,
    one: _Named,
    other: _Named,
    seen: tuple[np.ndarray, np.ndarray],
    metres: float,
    ppm: float,
) -> np.ndarray | None:
    """Return the part (h, w) bool of a floor for the `other` name; None without a clear line.

    `seen` are two masks (h, w) bool: where something is drawn, and doors and windows, dilated.
    """
    best: tuple[float, np.ndarray] | None = None
    for axis in (0, 1):
        # Along x the line is a column; along y it is one of the transposed picture.
        floor, drawn, opened = (own, *seen) if axis == 0 else (own.T, *(part.T for part in seen))
        low, high = sorted((one, other), key=lambda named: named.place[axis])
        for cut, sized in _cuts(floor, low, high, axis, metres, ppm):
            column = floor[:, cut]
            length = int(column.sum())
            if not length or opened[np.flatnonzero(column)[[0, -1]], cut].any():
                continue
            line = float(drawn[column, max(0, cut - 1) : cut + 2].any(axis=1).mean())
            neck = 1 - length / max(floor[:, :cut].sum(0).max(), floor[:, cut:].sum(0).max())
            score = sized + (line > SETTINGS.line_drawn) * (1 + line) + neck
            if best is not None and score <= best[0] + 1e-9:
                continue
            if sized or line > SETTINGS.line_drawn or neck > SETTINGS.neck_parts:
                side = np.zeros_like(floor)
                side[:, cut:] = floor[:, cut:]
                if low is other:
                    side = floor & ~side
                part = _with_its_name(floor, side, axis, one, other)
                if min(part.sum(), (floor & ~part).sum()) >= SETTINGS.room_floor * ppm**2:
                    best = score, part if axis == 0 else part.T
    return None if best is None else best[1]


def _cuts(
    floor: np.ndarray, low: _Named, high: _Named, axis: int, metres: float, ppm: float
) -> Iterator[tuple[int, float]]:
    """Yield the columns of a floor between two names, with the score of printed sizes for each."""
    first, last = round(low.place[axis]) + 3, round(high.place[axis]) - 3
    if last - first < SETTINGS.room_width * ppm:
        return
    size_ends = []
    for named, way in ((low, -1), (high, 1)):
        x, y = round(named.place[axis]), round(named.place[1 - axis])
        end = x + way * _run(floor[y, x::way])
        across = (_run(floor[y:, x]) + _run(floor[y::-1, x])) * metres
        # One printed side is the floor's width from wall to wall; the other ends at the line.
        pairs = zip(named.sides, named.sides[::-1], strict=True)
        beside = sorted(pairs, key=lambda pair: abs(pair[1] - across))
        size_ends += [round(end - way * side / metres) for side, _ in beside[:1]]
    widths = floor.sum(0)
    steps = np.flatnonzero(np.abs(np.diff(widths)) > SETTINGS.room_width * ppm) + 1
    for cut in sorted({*size_ends, *steps.tolist(), *range(first, last, 2)}):
        if first <= cut <= last:
            near = [abs(cut - place) * metres for place in size_ends]
            yield cut, float(sum(max(0.0, 1 - off / SETTINGS.size_off) for off in near))


def _run(values: np.ndarray) -> int:
    """Return the number of true values before the first false one."""
    return int(len(values) if values.all() else np.argmin(values))


def _with_its_name(
    floor: np.ndarray, side: np.ndarray, axis: int, one: _Named, other: _Named
) -> np.ndarray:
    """Return the part (h, w) bool of a floor with the `other` name.

    `side` is that name's side of the line. Parts that the line cuts off from `one` are added.
    """
    parts = []
    for mask, named in ((floor & ~side, one), (side, other)):
        places, _ = ndimage.label(mask)
        x, y = (round(v) for v in named.place)
        parts.append((places, places[(y, x) if axis == 0 else (x, y)]))
    (one_parts, one_number), (other_parts, other_number) = parts
    return np.asarray(
        ((other_parts == other_number) & side) | ((one_parts > 0) & (one_parts != one_number))
    )
