"""Rooms that the network takes for outside: a name stands in what lines close.

Balconies, decks and garages are drawn by thin or dashed lines; the middle of a hall has no wall in
the network's sight.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.ink import ink_of
from plan2scene_app.tracing.settings import OUTSIDE, ROOM, SETTINGS, WALL


def with_named_areas(
    structure: np.ndarray, image: np.ndarray, names: Sequence[tuple[float, float]], ppm: float
) -> np.ndarray:
    """Return the structure (h, w) uint8 with closed areas around names (x, y) as rooms.

    What lies around other rooms is the ground that they stand on, no room.
    """
    side = 2 * round(SETTINGS.dash * ppm / 2) + 1
    ink = (ink_of(image) > SETTINGS.ink).astype(np.uint8)
    lines = cv2.morphologyEx(ink, cv2.MORPH_CLOSE, np.ones((side, side), np.uint8)) > 0
    changed = structure.copy()
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
        own = places == number
        within = ndimage.binary_fill_holes(own) & ~own
        held = (structure[within] == ROOM).sum() >= SETTINGS.parted_floor * ppm**2
        if held or own.sum() < SETTINGS.room_floor * ppm**2:
            continue
        changed[own] = ROOM
        beside = _wide(own) & ~own & (structure == OUTSIDE)
        # A line between two parts of a floor that the network saw in parts is furniture.
        changed[beside] = np.where(_wide(structure == ROOM)[beside], ROOM, WALL)
    return changed


def _wide(mask: np.ndarray) -> np.ndarray:
    """Return a mask (h, w) bool with the two pixels around it."""
    return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0)
