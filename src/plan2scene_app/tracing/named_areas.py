"""Use the written room names to correct rooms: add areas with a name, join counters without one.

Balconies, decks and garages have thin or dashed lines as borders: the network may see nothing of
them, or a part without borders. It may also miss the middle of a hall. In plans with solid walls,
thin lines around counters part them from kitchens.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.ink import ink_of, solid_walls
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, PASSAGE, ROOM, SETTINGS, WALL

#: Half the thickness of the thickest line that is crossed, pixels.
_LINE_PX = 5


def with_named_areas(
    structure: np.ndarray,
    image: np.ndarray,
    names: Sequence[tuple[float, float]],
    open_air: Sequence[tuple[float, float]],
    ppm: float,
) -> np.ndarray:
    """Return the structure (h, w) uint8 with each closed area around a name (x, y) as a room.

    An area that encloses other rooms is the ground around the home, and no room. At the names of
    balconies and the like, `open_air`, such an area replaces floor that has no border.
    """
    side = 2 * round(SETTINGS.dash * ppm / 2) + 1
    ink = (ink_of(image) > SETTINGS.ink).astype(np.uint8)
    lines = cv2.morphologyEx(ink, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8)) > 0
    changed = structure.copy()
    floors, _ = ndimage.label(structure == ROOM)
    open_floors = [n for n in _at(floors, open_air) if _is_open(floors == n, structure)]
    structure = np.where(np.isin(floors, open_floors), OUTSIDE, structure)
    places, _ = ndimage.label((structure == OUTSIDE) & ~lines)
    rim = np.concatenate([places[0], places[-1], places[:, 0], places[:, -1]])
    tried = set(np.unique(rim).tolist()) | {0}
    h, w = structure.shape
    for x, y in names:
        if not (0 <= round(x) < w and 0 <= round(y) < h):
            continue
        number = int(places[round(y), round(x)])
        if number in tried:
            continue
        tried.add(number)
        area = places == number
        within = ndimage.binary_fill_holes(area) & ~area
        holds_rooms = (structure[within] == ROOM).sum() >= SETTINGS.parted_floor * ppm**2
        if holds_rooms or area.sum() < SETTINGS.room_floor * ppm**2:
            continue
        if floors[round(y), round(x)] in open_floors:
            changed[floors == floors[round(y), round(x)]] = OUTSIDE
        changed[area] = ROOM
        beside = _wide(area) & ~area & (structure == OUTSIDE)
        # A line between this area and floor that the network saw already is furniture, no wall.
        changed[beside] = np.where(_wide(structure == ROOM)[beside], ROOM, WALL)
    return changed


def without_counters(
    structure: np.ndarray,
    image: np.ndarray,
    names: Sequence[tuple[float, float]],
    kitchens: Sequence[tuple[float, float]],
    ppm: float,
) -> np.ndarray:
    """Return the structure (h, w) uint8 with counters as part of their kitchen.

    A counter has no name, and thin lines part it from the kitchen; the plan's walls are drawn
    solid. `names` are the places (x, y) of all room names, `kitchens` those of kitchens.
    """
    walls = _wide(solid_walls(ink_of(image), 2 * ppm))
    lines = np.isin(structure, (WALL, DOOR, PASSAGE)) & ~walls
    floors, count = ndimage.label(structure == ROOM)
    areas = np.bincount(floors.ravel(), minlength=count + 1)
    named, cooked = (_at(floors, places) for places in (names, kitchens))
    changed = structure.copy()
    for kitchen in cooked:
        kitchen_floor = floors == kitchen
        for number in np.unique(floors[_across(kitchen_floor, lines)]).tolist():
            if number in {0, kitchen} | named or areas[number] > SETTINGS.counter * areas[kitchen]:
                continue
            counter = floors == number
            between = _across(kitchen_floor, lines) & _across(counter, lines) & lines
            around = _wide(counter) & ~counter
            front = (_wide(_wide(between)) & around).sum()
            if front >= SETTINGS.counter_front * around.sum():
                changed[between] = ROOM
    return changed


def _is_open(floor: np.ndarray, structure: np.ndarray) -> bool:
    """Return whether a floor (h, w) bool has too much of the outside beside it to be a room."""
    rim = _wide(floor) & ~floor
    return bool(rim.any() and np.mean(structure[rim] != OUTSIDE) < SETTINGS.closed)


def _at(floors: np.ndarray, places: Sequence[tuple[float, float]]) -> set[int]:
    """Return the numbers of the floors (h, w) that lie at places (x, y)."""
    h, w = floors.shape
    inside = [(round(x), round(y)) for x, y in places if 0 <= x < w - 1 and 0 <= y < h - 1]
    return {int(floors[y, x]) for x, y in inside} - {0}


def _across(floor: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Return a floor (h, w) bool grown over the lines along it to what lies right behind them."""
    reached = floor
    for _ in range(_LINE_PX):
        reached = floor | (_wide(reached) & lines)
    return _wide(reached)


def _wide(mask: np.ndarray) -> np.ndarray:
    """Return a mask (h, w) bool dilated by two pixels."""
    return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
