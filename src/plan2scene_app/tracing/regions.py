"""From labels of pixels to which room each pixel belongs to."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy import ndimage
from skimage.segmentation import watershed

from plan2scene_app.tracing.labels import DOOR, OUTSIDE, PASSAGE, ROOM

#: Metres, as far as doors tell the scale: a neck of a room narrower than this parts two rooms.
NECK = 0.5
#: Rooms with less floor (m2), or nowhere wider (metres) than this, are none.
LEAST_FLOOR, LEAST_WIDTH = 0.6, 0.5
#: A gap between rooms up to this wide (metres) is a wall that both share.
THICKEST = 0.55
#: A room has something behind this share of its border.
CLOSED = 0.7
#: Square metres up to which a room without an opening is part of another.
ISLAND = 3.0


@dataclass(frozen=True)
class Regions:
    """Rooms as areas of a picture (h, w); `ppm` is the pixels of a metre as far as known."""

    rooms: np.ndarray  #: (h, w) int32: 0 outside, else number of the room, up to middles of walls
    floors: np.ndarray  #: (h, w) int32: the same, floor alone
    structure: np.ndarray  #: (h, w) uint8: outside, wall, door, window, passage, room
    count: int
    wall_px: float  #: thickness of inner walls in pixels
    ppm: float


def structure_of(probabilities: np.ndarray) -> np.ndarray:
    """Return the structure (h, w) uint8 of probabilities (labels, h, w): rooms are one label."""
    merged = np.concatenate([probabilities[:ROOM], probabilities[ROOM:].sum(0, keepdims=True)])
    return np.asarray(merged.argmax(0), np.uint8)


def find_regions(structure: np.ndarray, ppm: float) -> Regions:
    """Return the rooms of a structure (h, w) uint8 at about `ppm` pixels a metre."""
    structure = _without_pockets(structure, ppm)
    floors = _floors(structure == ROOM, ppm)
    count = int(floors.max())
    wall_px = _wall_thickness(structure, floors, ppm)
    rooms = _grown(floors, wall_px, ppm) if count else floors
    found = Regions(rooms, floors, structure, count, wall_px, ppm)
    return without_open_rooms(without_islands(found)) if count else found


def _without_pockets(structure: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure with what is outside in the midst of a room as room.

    The outside is what one can walk to from the picture's border by ways wider than a neck.
    """
    outside = np.pad(structure == OUTSIDE, 1, constant_values=True).astype(np.uint8)
    side = 2 * round(NECK * ppm / 2) + 1
    walker = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    padded = cv2.copyMakeBorder(outside, side, side, side, side, cv2.BORDER_CONSTANT, value=1)
    places, _ = ndimage.label(cv2.erode(padded, walker))
    reached = cv2.dilate((places == places[0, 0]).astype(np.uint8), walker)
    reached = reached[side + 1 : -side - 1, side + 1 : -side - 1]
    pockets, count = ndimage.label((structure == OUTSIDE) & (reached == 0))
    found = structure.copy()
    for number, box in enumerate(ndimage.find_objects(pockets, count), start=1):
        rows, columns = (slice(max(0, s.start - 1), s.stop + 1) for s in box)
        own = pockets[rows, columns] == number
        rim = ndimage.binary_dilation(own) & ~own
        if np.mean(structure[rows, columns][rim] == ROOM) > 0.5:
            found[rows, columns][own] = ROOM
    return found


def _floors(mask: np.ndarray, ppm: float) -> np.ndarray:
    """Return numbered floors (h, w) int32 of a mask of room pixels, parted at narrow necks."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    seeds, count = ndimage.label(depth > NECK / 2 * ppm)
    if not count:
        return np.zeros(mask.shape, np.int32)
    floors = watershed(-depth, seeds, mask=mask)
    sizes = np.bincount(floors.ravel(), minlength=count + 1)
    widest = np.asarray(ndimage.maximum(depth, floors, np.arange(count + 1))) * 2
    kept = (sizes >= LEAST_FLOOR * ppm**2) & (widest >= LEAST_WIDTH * ppm)
    kept[0] = False
    numbers = np.where(kept, np.cumsum(kept), 0)
    return np.asarray(numbers[floors], np.int32)


def _wall_thickness(structure: np.ndarray, floors: np.ndarray, ppm: float) -> float:
    """Return the usual thickness in pixels of what parts two rooms."""
    found = []
    for axis in (0, 1):
        lines = floors if axis else floors.T
        for line in lines[:: max(1, round(ppm / 8))]:
            inside = np.flatnonzero(line)
            if len(inside) < 2:
                continue
            gaps = np.diff(inside) - 1
            ends = line[inside[:-1]] != line[inside[1:]]
            found.append(gaps[(gaps > 0) & ends & (gaps < THICKEST * ppm)])
    gaps = np.concatenate(found) if found else np.zeros(0)
    return float(np.median(gaps)) if len(gaps) > 5 else 0.12 * ppm


def _grown(floors: np.ndarray, wall_px: float, ppm: float) -> np.ndarray:
    """Return rooms (h, w) int32 that meet in the middle of walls.

    Towards the outside they reach half of an inner wall beyond their floor.
    """
    half = max(1, round(wall_px / 2))
    reach = round(THICKEST * ppm / 2)
    square = cv2.getStructuringElement(cv2.MORPH_RECT, (2 * half + 1, 2 * half + 1))
    body = cv2.dilate((floors > 0).astype(np.uint8), square)
    pad = reach + 1
    body = cv2.copyMakeBorder(body, pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
    closing = cv2.getStructuringElement(cv2.MORPH_RECT, (2 * reach + 1, 2 * reach + 1))
    body = cv2.morphologyEx(body, cv2.MORPH_CLOSE, closing)[pad:-pad, pad:-pad]
    nearest = ndimage.distance_transform_edt(
        floors == 0, return_distances=False, return_indices=True
    )
    return np.where(body > 0, floors[tuple(nearest)], 0).astype(np.int32)


def closed_share(regions: Regions, number: int) -> float:
    """Return how much of a floor's border has a wall, an opening or another floor behind it.

    What the network takes for a room without walls around it (a path, a table, letters) has not.
    """
    floor = (regions.floors == number).astype(np.uint8)
    rim = cv2.dilate(floor, np.ones((5, 5), np.uint8)) > floor
    behind = regions.structure[rim]
    return float(np.mean(behind != OUTSIDE)) if rim.any() else 0.0


def without_islands(regions: Regions) -> Regions:
    """Return the regions with small ones that no opening leads to as part of the room around.

    Furniture drawn as heavily as walls looks like a room; cupboards that are rooms have doors.
    """
    sizes = np.bincount(regions.floors.ravel(), minlength=regions.count + 1)
    reach = max(3, round(regions.wall_px) + 2)
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    owner = np.arange(regions.count + 1)
    for number in np.argsort(sizes).tolist():
        if not number or sizes[number] >= ISLAND * regions.ppm**2:
            continue
        rim = cv2.dilate((regions.floors == number).astype(np.uint8), square) > 0
        behind = np.isin(regions.structure[rim], (DOOR, PASSAGE)).sum()
        beside = np.bincount(regions.floors[rim], minlength=regions.count + 1)
        beside[[0, number]] = 0
        if behind < LEAST_WIDTH * regions.ppm and beside.max() > 0:
            owner[number] = int(beside.argmax())
    for _ in range(3):  # an island in an island
        owner = owner[owner]
    kept, floors = np.unique(owner[regions.floors], return_inverse=True)
    if len(kept) == regions.count + 1:
        return regions
    floors = floors.reshape(regions.floors.shape).astype(np.int32)
    rooms = _grown(floors, regions.wall_px, regions.ppm)
    return replace(regions, rooms=rooms, floors=floors, count=len(kept) - 1)


def without_open_rooms(regions: Regions) -> Regions:
    """Return the regions without those that nothing closes."""
    numbers = np.arange(regions.count + 1)
    kept = np.array([n > 0 and closed_share(regions, int(n)) >= CLOSED for n in numbers])
    if kept[1:].all():
        return regions
    renumbered = np.where(kept, np.cumsum(kept), 0).astype(np.int32)
    floors = renumbered[regions.floors]
    rooms = _grown(floors, regions.wall_px, regions.ppm) if kept.any() else floors
    return replace(regions, rooms=rooms, floors=floors, count=int(kept.sum()))


def touches_open_floor(regions: Regions, line: np.ndarray) -> np.ndarray:
    """Return where floor goes on across a line (n, 2) of pixels x, y between two rooms, (n,) bool.

    There is no wall and no symbol of an opening: a passage that is not drawn.
    """
    h, w = regions.structure.shape
    x = np.clip(np.round(line[:, 0]).astype(int), 0, w - 1)
    y = np.clip(np.round(line[:, 1]).astype(int), 0, h - 1)
    return np.isin(regions.structure[y, x], (ROOM, PASSAGE))
