"""Fixtures of baths and kitchens: what a plan's picture draws in these rooms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from scipy import ndimage

from plan2scene.house import OPEN_AIR
from plan2scene_app.ids import free_id
from plan2scene_app.tracing.openings import TracedOpening
from plan2scene_app.tracing.picture import Frame
from plan2scene_app.tracing.rooms import TracedRoom
from plan2scene_app.tracing.segmenter import PlanSegmenter
from plan2scene_app.tracing.settings import FIXTURE_LABELS, FIXTURE_PPM, SETTINGS

_BATH, _KITCHEN = ("toilet", "sink", "bath", "shower"), ("sink", "stove")
_NO_USE = ("Unknown", "Closet", "Corridor")  #: types that other evidence may replace
_SWUNG = ("toilet", "shower")  #: what the swing of a door looks like
_MOST_PX = 2048  #: longest side of a view; the scale may be wrong
_COUNTER = FIXTURE_LABELS.index("counter")


@dataclass(frozen=True)
class TracedFixture:
    """A fixture: its kind, the number of its room, two corners (x, y) in pixels of the frame."""

    kind: str  #: of `FIXTURE_LABELS`, or "sink_unit": a sink in a counter
    room: int
    low: tuple[float, float]
    high: tuple[float, float]


def find_fixtures(
    picture: np.ndarray,
    frame: Frame,
    rooms: Sequence[TracedRoom],
    openings: Sequence[TracedOpening],
    metres: float,
    segmenter: PlanSegmenter,
) -> list[TracedFixture]:
    """Return the fixtures in bathrooms, kitchens and unnamed rooms of a picture.

    `picture` is (h, w, 3) uint8 sRGB.
    `metres` is the size of a pixel of the `frame`. A shower or toilet before a door is its swing.
    """
    reach = SETTINGS.before_door / metres
    doors = [shapely.LineString([o.start, o.end]) for o in openings if o.kind != "window"]
    before_doors = shapely.union_all([door.buffer(reach, cap_style="flat") for door in doors])
    zoom = FIXTURE_PPM * metres
    reduced = zoom * frame.zoom
    if reduced < 1:
        picture = cv2.GaussianBlur(picture, (0, 0), 0.5 / reduced)
    found = []
    for room in rooms:
        kinds = _kinds_in(room)
        if not kinds:
            continue
        x0, y0, x1, y1 = room.polygon.bounds
        side = [
            min(max(segmenter.long_side, 32 * round((b - a) * zoom / 32 + 1)), _MOST_PX)
            for a, b in ((x0, x1), (y0, y1))
        ]
        corner = np.array([x0 + x1, y0 + y1]) / 2 - np.array(side) / 2 / zoom
        matrix = zoom * frame.matrix
        matrix[:, 2] -= zoom * corner
        view = cv2.warpAffine(
            picture, matrix, side, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        inside = np.zeros(view.shape[:2], np.uint8)
        ring = np.round((np.array(room.polygon.exterior.coords) - corner) * zoom).astype(np.int32)
        cv2.fillPoly(inside, [ring], 1)
        probabilities = segmenter.probabilities(view, views=SETTINGS.fixture_views) * inside
        for kind, sides in worktops_and_fixtures(probabilities, kinds):
            (x0, y0), (x1, y1) = (corner + np.array(p) / zoom for p in (sides[:2], sides[2:]))
            if kind not in _SWUNG or not shapely.box(x0, y0, x1, y1).intersects(before_doors):
                ends = (float(x0), float(y0)), (float(x1), float(y1))
                found.append(TracedFixture(kind, room.number, *ends))
    return found


def _kinds_in(room: TracedRoom) -> tuple[str, ...]:
    """Return the kinds of fixtures that a room may have."""
    unnamed = not room.named and OPEN_AIR.isdisjoint(room.types)
    return _BATH + _KITCHEN if unnamed else _kinds_of(room.types)


def _kinds_of(types: Sequence[str]) -> tuple[str, ...]:
    return (_BATH if "Bathroom" in types else ()) + (_KITCHEN if "Kitchen" in types else ())


def with_types_by_fixtures(
    rooms: Sequence[TracedRoom], fixtures: Sequence[TracedFixture], metres: float
) -> tuple[list[TracedRoom], list[TracedFixture]]:
    """Return rooms, the unnamed ones with types by their fixtures, and the fixtures that fit them.

    A toilet, bath or shower makes a small room of no known use a bathroom; two of them, or one with
    a sink, make any small room a bathroom. A sink and a stove make a room a kitchen, and a living
    room one with a kitchen. `metres` is the size of a pixel.
    """
    taken = {room.id for room in rooms}
    typed_rooms, fitting = [], []
    for room in rooms:
        inside = [fixture for fixture in fixtures if fixture.room == room.number]
        kinds = {fixture.kind.removesuffix("_unit") for fixture in inside}
        types = room.types
        if not room.named:
            bath = kinds.intersection(_BATH)
            small = room.polygon.area * metres**2 < SETTINGS.bath[1]
            if small and bath - {"sink"} and (len(bath) > 1 or types[0] in _NO_USE):
                types = ("Bathroom",)
            elif {"stove", "sink"} <= kinds and "Kitchen" not in types:
                types = (*types, "Kitchen") if types == ("Reception",) else ("Kitchen",)
        identifier = room.id if types[0] == room.types[0] else free_id(types[0], taken)
        typed_rooms.append(replace(room, types=types, id=identifier))
        if possible := _kinds_of(types):
            fitting += [f for f in inside if f.kind in (*possible, "counter", "sink_unit")]
    return typed_rooms, fitting


_Box = tuple[int, int, int, int]


def worktops_and_fixtures(
    probabilities: np.ndarray, kinds: Sequence[str]
) -> Iterator[tuple[str, _Box]]:
    """Yield kind and box (x0, y0, x1, y1) of each fixture in probabilities (labels, h, w).

    `kinds` are those that the room may have, besides counters.
    """
    labels = probabilities.argmax(0)
    single = []
    for kind in dict.fromkeys(kinds):
        index = FIXTURE_LABELS.index(kind)
        low, high = SETTINGS.fixture_sides[kind]
        for sides, score in _parts(labels == index, probabilities[index]):
            short, long = sorted((sides[2] - sides[0], sides[3] - sides[1]))
            fits = short >= low * FIXTURE_PPM and long <= high * FIXTURE_PPM
            if fits and score >= SETTINGS.fixture_score:
                single.append((kind, sides))
    worktops = np.isin(labels, [_COUNTER, *(FIXTURE_LABELS.index(k) for k in ("sink", "stove"))])
    for run in _runs(worktops):
        yield from _divided(run, single)
    yield from single


def _parts(mask: np.ndarray, probability: np.ndarray) -> Iterator[tuple[_Box, float]]:
    """Yield the box of each part of a mask (h, w) bool, and its mean probability."""
    numbers, count = ndimage.label(mask)
    scores = ndimage.mean(probability, numbers, np.arange(1, count + 1))
    for (rows, columns), score in zip(ndimage.find_objects(numbers), scores, strict=True):
        yield (columns.start, rows.start, columns.stop, rows.stop), float(score)


def _runs(worktops: np.ndarray) -> Iterator[_Box]:
    """Yield the box of each straight worktop of a mask (h, w) bool; a corner has two."""
    least = round(SETTINGS.least_worktop * FIXTURE_PPM)
    low, high = (depth * FIXTURE_PPM for depth in SETTINGS.worktop_depth)
    left = worktops
    for size in ((1, least), (least, 1)):
        arms = ndimage.binary_opening(left, np.ones(size))
        left = left & ~arms
        for box, _ in _parts(arms, arms):
            filled = arms[box[1] : box[3], box[0] : box[2]].mean()
            short = min(box[2] - box[0], box[3] - box[1])
            if low <= short <= high and filled >= SETTINGS.worktop_filled:
                yield box


def _divided(run: _Box, single: list[tuple[str, _Box]]) -> Iterator[tuple[str, _Box]]:
    """Yield a worktop's parts: its sinks and stoves, taken out of `single`, and its counters."""
    axis = 0 if run[2] - run[0] >= run[3] - run[1] else 1

    def part(start: int, end: int) -> _Box:
        box = list(run)
        box[axis], box[axis + 2] = start, end
        return box[0], box[1], box[2], box[3]

    place = run[axis]
    for kind, box in sorted(single, key=lambda entry: entry[1][axis]):
        x, y = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
        if kind not in _KITCHEN or not (run[0] <= x <= run[2] and run[1] <= y <= run[3]):
            continue
        single.remove((kind, box))
        start, end = max(place, box[axis]), min(run[axis + 2], box[axis + 2])
        if start - place >= SETTINGS.least_counter * FIXTURE_PPM:
            yield "counter", part(place, start)
        else:
            start = place
        yield "sink_unit" if kind == "sink" else kind, part(start, end)
        place = end
    if run[axis + 2] - place >= SETTINGS.least_counter * FIXTURE_PPM:
        yield "counter", part(place, run[axis + 2])
