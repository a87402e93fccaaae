"""Stairs of a plan picture: treads are drawn as a ladder of lines, which gives a flight its place.

The network hardly sees stairs in real drawings, so they are found as parallel lines of one length
at even distances.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import cv2
import numpy as np
from shapely.affinity import translate
from shapely.geometry import LineString, Point, Polygon, box

from plan2scene.plans.levels import STAIRS
from plan2scene_app.tracing.drawings import Storey
from plan2scene_app.tracing.ink import ink_of
from plan2scene_app.tracing.rooms import TracedRoom
from plan2scene_app.tracing.settings import SETTINGS


@dataclass(frozen=True)
class Treads:
    """Treads of one flight as they are drawn."""

    box: tuple[float, float, float, float]  #: x0, y0, x1, y1 in pixels of the frame
    upright: bool  #: whether the flight goes along y

    @property
    def middle(self) -> np.ndarray:
        """Middle of the box (2,), pixels."""
        x0, y0, x1, y1 = self.box
        return np.array([x0 + x1, y0 + y1]) / 2


@dataclass(frozen=True)
class TracedFlight:
    """A straight flight between two storeys, in pixels of the frame moved onto the ground floor."""

    storey: int  #: index of the lower storey, from the lowest
    start: tuple[float, float]  #: middle of its foot
    end: tuple[float, float]  #: middle of its head
    width: float


def find_treads(image: np.ndarray, ppm: float) -> list[Treads]:
    """Return the ladders of treads in a straight picture (h, w, 3) uint8 without text.

    `ppm` is roughly its number of pixels a metre.
    """
    ink = ink_of(image)
    ladders = []
    for upright in (True, False):
        lines = _lines_across(ink if upright else ink.T, ppm)
        for chain in _ladders(lines, ppm):
            x0, x1 = np.median(chain[:, :2], axis=0)
            depth = float(np.median(np.diff(chain[:, 2])))
            place = (x0, chain[0, 2] - depth / 2, x1, chain[-1, 2] + depth / 2)
            place = place if upright else (place[1], place[0], place[3], place[2])
            x0, y0, x1, y1 = (float(v) for v in place)
            ladders.append(Treads((x0, y0, x1, y1), upright))
    return [one for one in ladders if not any(_crossed(one, other) for other in ladders)]


def _crossed(one: Treads, other: Treads) -> bool:
    """Return whether lines at right angles, `other`, cover half of `one`: both are tiles."""
    one_box, other_box = box(*one.box), box(*other.box)
    crosses = one.upright != other.upright
    return crosses and one_box.intersection(other_box).area > 0.5 * one_box.area


def _lines_across(ink: np.ndarray, ppm: float) -> np.ndarray:
    """Return thin lines along x as long as a tread, (n, 3): first x, last x, y; sorted by y."""
    side = 2 * max(2, round(SETTINGS.tread_line * ppm)) + 1
    thin = ink - cv2.morphologyEx(ink, cv2.MORPH_OPEN, np.ones((side, 1), np.uint8))
    low, high = (length * ppm for length in SETTINGS.tread_length)
    along = np.ones((1, max(3, round(low))), np.uint8)
    lines = cv2.morphologyEx((thin > SETTINGS.ink).astype(np.uint8), cv2.MORPH_OPEN, along)
    boxes = cv2.connectedComponentsWithStats(lines)[2][1:]
    kept = boxes[(boxes[:, 2] <= high) & (boxes[:, 3] <= 2 * SETTINGS.tread_line * ppm)]
    x, y, width, height = kept[:, :4].T.astype(float)
    lines = np.stack([x, x + width, y + height / 2], axis=1)
    return np.asarray(lines[np.argsort(lines[:, 2], kind="stable")])


def _ladders(lines: np.ndarray, ppm: float) -> Iterator[np.ndarray]:
    """Yield groups of lines (k, 3) that follow one another at even distances along y."""
    free = np.ones(len(lines), bool)
    least, most = (depth * ppm for depth in SETTINGS.tread_depth)
    for first in range(len(lines)):
        if not free[first]:
            continue
        chain, low, high = [first], least, most
        while True:
            x0, x1, y = lines[chain[-1]]
            away = lines[:, 2] - y
            shared = np.minimum(lines[:, 1], x1) - np.maximum(lines[:, 0], x0)
            longer = np.maximum(lines[:, 1] - lines[:, 0], x1 - x0)
            fits = free & (away > SETTINGS.tread_line * ppm) & (away <= high)
            fits &= shared >= SETTINGS.tread_alike * longer
            following = int(np.argmax(fits))
            if not fits[following] or away[following] < low:
                break
            chain.append(following)
            depth = float(np.median(np.diff(lines[chain, 2])))
            low, high = (max(least, 0.7 * depth), min(most, 1.4 * depth))
        if len(chain) >= SETTINGS.least_treads:
            free[chain] = False
            yield lines[chain]


def covered(treads: Sequence[Treads], floor: np.ndarray) -> float:
    """Return the share of a room's floor (h, w) bool that treads take."""
    taken = np.zeros_like(floor)
    for ladder in treads:
        x0, y0, x1, y1 = (max(0, round(v)) for v in ladder.box)
        taken[y0:y1, x0:x1] = True
    return float((taken & floor).sum() / max(1, floor.sum()))


def flights_of(
    treads: Sequence[Treads],
    rooms: Sequence[TracedRoom],
    storeys: Sequence[Storey],
    metres: float,
) -> list[TracedFlight]:
    """Return a flight from each storey to the next, where treads are drawn on one or both.

    Of the two ways up, it takes the one with more free floor: on the lower storey before its foot,
    on the higher storey behind its head. `metres` is the size of a pixel.
    """
    flights = []
    for place, pair in enumerate(pairwise(storeys)):
        floors = [_floors(rooms, storey) for storey in pair]
        treads_by_storey = [_on_storey(treads, *item) for item in zip(pair, floors, strict=True)]
        joined_treads = [_joined(a, b) for a, b in product(*treads_by_storey) if _meet(a, b)]
        ways = [
            flight
            for strip in joined_treads or treads_by_storey[0] or treads_by_storey[1]
            for flight in _ways_up(strip, place, floors, metres)
        ]
        if ways:
            flights.append(max(ways, key=lambda way: way[0])[1])
    return flights


def _floors(rooms: Sequence[TracedRoom], storey: Storey) -> list[Polygon]:
    """Return the rooms of a storey, moved onto the ground floor."""
    own = [room.polygon for room in rooms if room.drawing == storey.drawing]
    return [translate(polygon, *storey.shift) for polygon in own]


def _on_storey(treads: Sequence[Treads], storey: Storey, floors: Sequence[Polygon]) -> list[Treads]:
    """Return the treads in the rooms of a storey, moved onto the ground floor."""
    dx, dy = storey.shift
    moved = [
        Treads((x0 + dx, y0 + dy, x1 + dx, y1 + dy), ladder.upright)
        for ladder in treads
        for x0, y0, x1, y1 in [ladder.box]
    ]
    return [ladder for ladder in moved if _room_at(ladder.middle, floors)]


def _room_at(point: np.ndarray, floors: Sequence[Polygon]) -> Polygon | None:
    return next((floor for floor in floors if floor.covers(Point(point))), None)


def _meet(one: Treads, other: Treads) -> bool:
    """Return whether treads of two storeys lie on one another, as parts of one flight."""
    along = int(one.upright)
    apart = np.abs(one.middle - other.middle)
    sizes = [np.subtract(item.box[2:], item.box[:2]) for item in (one, other)]
    near = apart[1 - along] < min(size[1 - along] for size in sizes) / 2
    return one.upright == other.upright and near and apart[along] < sum(s[along] for s in sizes) / 2


def _joined(one: Treads, other: Treads) -> Treads:
    """Return all treads of a flight: each of two storeys shows a part of them."""
    along = int(one.upright)
    low, high = np.minimum(one.box[:2], other.box[:2]), np.maximum(one.box[2:], other.box[2:])
    low[1 - along], high[1 - along] = one.box[1 - along], one.box[3 - along]
    x0, y0, x1, y1 = (float(v) for v in (*low, *high))
    return Treads((x0, y0, x1, y1), one.upright)


def _ways_up(
    strip: Treads, place: int, floors: Sequence[Sequence[Polygon]], metres: float
) -> Iterator[tuple[float, TracedFlight]]:
    """Yield (free floor, flight) for both ways up a strip of treads.

    The free floor, in metres, is that before the foot plus that behind the head, at most 1 m each.
    """
    along = int(strip.upright)
    size = np.subtract(strip.box[2:], strip.box[:2])
    off = (STAIRS.step_off + 0.05) / metres
    for sign in (1.0, -1.0):
        way = sign * np.eye(2)[along]
        free = [
            _clear(strip.middle, toward, floor) - size[along] / 2
            for toward, floor in ((-way, floors[0]), (way, floors[1]))
        ]
        # Where a wall is nearer than the step on or off needs, the flight is shortened.
        ends = [size[along] / 2 + min(0.0, clear - off) for clear in free]
        if sum(ends) * metres < STAIRS.least_flight:
            continue
        foot, head = strip.middle - ends[0] * way, strip.middle + ends[1] * way
        flight = TracedFlight(
            place,
            (float(foot[0]), float(foot[1])),
            (float(head[0]), float(head[1])),
            float(size[1 - along]),
        )
        yield sum(min(clear * metres, 1.0) for clear in free), flight


def _clear(start: np.ndarray, way: np.ndarray, floors: Sequence[Polygon]) -> float:
    """Return the pixels from a point, along `way`, to its room's outline; 1e6 outside all rooms."""
    room = _room_at(start, floors)
    if room is None:
        return 1e6
    far_point = start + way * 1e5
    return float(Point(start).distance(LineString([start, far_point]).intersection(room.exterior)))
