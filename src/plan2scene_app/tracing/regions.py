"""From labels of pixels to the room that each pixel belongs to.

Passages that no symbol marks are found first: a wall that ends in a floor is extended to the end of
a wall that faces it, or to the wall across, if this parts two large enough floors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy import ndimage
from skimage.segmentation import watershed

from plan2scene_app.tracing.settings import DOOR, OUTSIDE, PASSAGE, ROOM, SETTINGS, WINDOW


@dataclass(frozen=True)
class Regions:
    """Rooms as areas of a picture (h, w); `ppm` is the estimated pixels a metre."""

    rooms: np.ndarray  #: (h, w) int32: 0 outside, else the room's number, to the middle of walls
    floors: np.ndarray  #: (h, w) int32: the same numbers, without the walls
    structure: np.ndarray  #: (h, w) uint8: outside, wall, door, window, passage, room
    count: int
    wall_px: float  #: thickness of inner walls in pixels
    ppm: float


def structure_of(probabilities: np.ndarray) -> np.ndarray:
    """Return the likeliest labels (h, w) uint8 of (labels, h, w); all kinds of room are one."""
    merged = np.concatenate([probabilities[:ROOM], probabilities[ROOM:].sum(0, keepdims=True)])
    return np.asarray(merged.argmax(0), np.uint8)


def find_regions(structure: np.ndarray, ppm: float) -> Regions:
    """Return the rooms of a structure (h, w) uint8 at about `ppm` pixels a metre."""
    structure = without_pockets(structure, ppm)
    floors = _floors(structure == ROOM, ppm)
    count = int(floors.max())
    wall_px = _wall_thickness(structure, floors, ppm)
    floors = _with_strips(floors, structure == ROOM, wall_px, ppm) if count else floors
    rooms = grown(floors, wall_px, ppm) if count else floors
    regions = Regions(rooms, floors, structure, count, wall_px, ppm)
    return without_open_rooms(without_islands(regions)) if count else regions


def without_pockets(structure: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure with enclosed pockets of outside relabelled as room.

    The network may see only a part of a large room, or nothing: such a pocket must enclose no rooms
    and have a door, or a window without a room behind it (those of a light well have one). The
    real outside is connected to the picture's border by paths wider than `SETTINGS.neck`.
    """
    outside = np.pad(structure == OUTSIDE, 1, constant_values=True).astype(np.uint8)
    side = 2 * round(SETTINGS.neck * ppm / 2) + 1
    walker = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    padded = cv2.copyMakeBorder(outside, side, side, side, side, cv2.BORDER_CONSTANT, value=1)
    places, _ = ndimage.label(cv2.erode(padded, walker))
    reached = cv2.dilate((places == places[0, 0]).astype(np.uint8), walker)
    reached = reached[side + 1 : -side - 1, side + 1 : -side - 1]
    pockets, count = ndimage.label((structure == OUTSIDE) & (reached == 0))
    leading = _leading(structure, ppm)
    filled = structure.copy()
    for number, box in enumerate(ndimage.find_objects(pockets, count), start=1):
        rows, columns = (slice(max(0, s.start - 1), s.stop + 1) for s in box)
        pocket = pockets[rows, columns] == number
        rim = ndimage.binary_dilation(pocket) & ~pocket
        is_room = np.mean(structure[rows, columns][rim] == ROOM) > SETTINGS.pocket
        if not is_room and leading[rows, columns][rim].sum() >= SETTINGS.opening * ppm:
            around = ndimage.binary_fill_holes(pocket).sum() - pocket.sum()
            large = pocket.sum() >= SETTINGS.parted_floor * ppm**2
            is_room = large and around < SETTINGS.parted_floor * ppm**2
        if is_room:
            filled[rows, columns][pocket] = ROOM
    return filled


def _leading(structure: np.ndarray, ppm: float) -> np.ndarray:
    """Return the mask (h, w) bool of doors, passages, and windows with no room beside them."""
    floors, count = ndimage.label(structure == ROOM)
    large = np.bincount(floors.ravel(), minlength=count + 1) >= SETTINGS.parted_floor * ppm**2
    large[0] = False
    beside = cv2.dilate(large[floors].astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    windows, count = ndimage.label(structure == WINDOW, np.ones((3, 3)))
    inner = np.bincount(windows[beside], minlength=count + 1) > 0
    return np.isin(structure, (DOOR, PASSAGE)) | ((windows > 0) & ~inner[windows])


def _floors(mask: np.ndarray, ppm: float) -> np.ndarray:
    """Return numbered floors (h, w) int32 of a mask of room pixels, parted at narrow necks."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    seeds, count = ndimage.label(depth > SETTINGS.neck / 2 * ppm)
    if not count:
        return np.zeros(mask.shape, np.int32)
    floors = watershed(-depth, seeds, mask=mask)
    sizes = np.bincount(floors.ravel(), minlength=count + 1)
    widest = np.asarray(ndimage.maximum(depth, floors, np.arange(count + 1))) * 2
    kept = (sizes >= SETTINGS.room_floor * ppm**2) & (widest >= SETTINGS.room_width * ppm)
    kept[0] = False
    numbers = np.where(kept, np.cumsum(kept), 0)
    return np.asarray(numbers[floors], np.int32)


def _with_strips(floors: np.ndarray, mask: np.ndarray, wall_px: float, ppm: float) -> np.ndarray:
    """Return floors (h, w) with the narrow strips of room pixels in `mask` added to them.

    A strip (a counter, a cupboard) joins the floor from which the thinnest line parts it, if that
    line is clearly thinner than those to other floors and than a wall, `wall_px`. Strips narrower
    than `SETTINGS.strip` are the inside of walls and are left out.
    """
    strips, count = ndimage.label(mask & (floors == 0))
    away, nearest = ndimage.distance_transform_edt(floors == 0, return_indices=True)
    widened = floors.copy()
    for number, box in enumerate(ndimage.find_objects(strips, count), start=1):
        rows, columns = (slice(max(0, s.start - 1), s.stop + 1) for s in box)
        strip = strips[rows, columns] == number
        depth = cv2.distanceTransform(np.pad(strip, 1).astype(np.uint8), cv2.DIST_L2, 3)
        if 2 * depth.max() < SETTINGS.strip * ppm:
            continue
        rim = strip & ~ndimage.binary_erosion(strip)
        behind = floors[tuple(index[rows, columns][rim] for index in nearest)]
        off = away[rows, columns][rim]
        beside = [n for n in np.unique(behind) if (behind == n).mean() >= SETTINGS.strip_beside]
        thick = sorted((float(np.percentile(off[behind == n], 25)), int(n)) for n in beside)
        least = min([wall_px + 1, *(other for other, _ in thick[1:])])
        if thick and thick[0][0] <= SETTINGS.strip_thinner * least:
            widened[rows, columns][strip] = thick[0][1]
    return widened


def floor_count(structure: np.ndarray, ppm: float) -> int:
    """Return how many floors of a structure (h, w) uint8 are large enough for a room."""
    return int(_floors(structure == ROOM, ppm).max())


def _wall_thickness(structure: np.ndarray, floors: np.ndarray, ppm: float) -> float:
    """Return the median thickness in pixels of the walls between two rooms."""
    thicknesses = []
    for axis in (0, 1):
        lines = floors if axis else floors.T
        for line in lines[:: max(1, round(ppm / 8))]:
            inside = np.flatnonzero(line)
            if len(inside) < 2:
                continue
            gaps = np.diff(inside) - 1
            ends = line[inside[:-1]] != line[inside[1:]]
            thicknesses.append(gaps[(gaps > 0) & ends & (gaps < SETTINGS.shared_wall * ppm)])
    gaps = np.concatenate(thicknesses) if thicknesses else np.zeros(0)
    return float(np.median(gaps)) if len(gaps) > 5 else 0.12 * ppm


def grown(floors: np.ndarray, wall_px: float, ppm: float) -> np.ndarray:
    """Return rooms (h, w) int32: floors grown until they meet in the middle of walls.

    Towards the outside they grow by half the thickness of an inner wall.
    """
    half = max(1, round(wall_px / 2))
    reach = round(SETTINGS.shared_wall * ppm / 2)
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
    """Return the share of a floor's border with a wall, an opening or another floor behind it.

    It is low where the network takes something without walls (a path, a table, letters) for a room.
    """
    floor = (regions.floors == number).astype(np.uint8)
    rim = cv2.dilate(floor, np.ones((5, 5), np.uint8)) > floor
    behind = regions.structure[rim]
    return float(np.mean(behind != OUTSIDE)) if rim.any() else 0.0


def without_islands(regions: Regions) -> Regions:
    """Return the regions with each small room without an opening merged into the room around it.

    Such a room is furniture that is drawn as heavily as walls; cupboards that are rooms have doors.
    """
    sizes = np.bincount(regions.floors.ravel(), minlength=regions.count + 1)
    reach = max(3, round(regions.wall_px) + 2)
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    owner = np.arange(regions.count + 1)
    for number in np.argsort(sizes).tolist():
        if not number or sizes[number] >= SETTINGS.island * regions.ppm**2:
            continue
        rim = cv2.dilate((regions.floors == number).astype(np.uint8), square) > 0
        behind = np.isin(regions.structure[rim], (DOOR, PASSAGE)).sum()
        beside = np.bincount(regions.floors[rim], minlength=regions.count + 1)
        beside[[0, number]] = 0
        if behind < SETTINGS.room_width * regions.ppm and beside.max() > 0:
            owner[number] = int(beside.argmax())
    for _ in range(3):  # an island in an island
        owner = owner[owner]
    kept, floors = np.unique(owner[regions.floors], return_inverse=True)
    if len(kept) == regions.count + 1:
        return regions
    floors = floors.reshape(regions.floors.shape).astype(np.int32)
    rooms = grown(floors, regions.wall_px, regions.ppm)
    return replace(regions, rooms=rooms, floors=floors, count=len(kept) - 1)


def without_open_rooms(regions: Regions) -> Regions:
    """Return the regions without those that are not closed by walls (:func:`closed_share`)."""
    numbers = np.arange(regions.count + 1)
    kept = np.array([n > 0 and closed_share(regions, int(n)) >= SETTINGS.closed for n in numbers])
    if kept[1:].all():
        return regions
    renumbered = np.where(kept, np.cumsum(kept), 0).astype(np.int32)
    floors = renumbered[regions.floors]
    rooms = grown(floors, regions.wall_px, regions.ppm) if kept.any() else floors
    return replace(regions, rooms=rooms, floors=floors, count=int(kept.sum()))


def labels_at(regions: Regions, points: np.ndarray) -> np.ndarray:
    """Return the labels (...) uint8 at points (..., 2), pixels x, y, moved into the picture."""
    h, w = regions.structure.shape
    x, y = np.moveaxis(np.round(points).astype(int), -1, 0)
    return np.asarray(regions.structure[np.clip(y, 0, h - 1), np.clip(x, 0, w - 1)])


@dataclass(frozen=True)
class _Gap:
    """Floor between two ends of walls: `rows` span the wall's thickness, `columns` the gap."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    turned: bool  #: whether rows are columns of the picture

    @property
    def place(self) -> tuple[slice, slice]:
        """Where it is in the picture."""
        along, across = slice(*self.columns), slice(*self.rows)
        return (along, across) if self.turned else (across, along)

    def sides(self, floors: np.ndarray) -> tuple[int, int]:
        """Return the most frequent number in `floors` (h, w) on each side, 0 for no floor."""
        plane = floors.T if self.turned else floors
        beside = []
        for row in (self.rows[0] - 1, self.rows[1]):
            near = plane[row, slice(*self.columns)] if 0 <= row < len(plane) else np.zeros(1, int)
            beside.append(int(np.bincount(near).argmax()))
        return beside[0], beside[1]


def with_passages(structure: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure (h, w) uint8 with those gaps as passages that part two large floors."""
    gaps = [gap for turned in (False, True) for gap in _gaps(structure, ppm, turned=turned)]
    while gaps:
        opened = structure.copy()
        for gap in gaps:
            part = opened[gap.place]
            part[part == ROOM] = PASSAGE
        floors, count = ndimage.label(opened == ROOM)
        sizes = np.bincount(floors.ravel(), minlength=count + 1)
        sizes[0] = 0
        kept = []
        for gap in gaps:
            one, other = gap.sides(floors)
            if one != other and min(sizes[one], sizes[other]) >= SETTINGS.parted_floor * ppm**2:
                kept.append(gap)
        if len(kept) == len(gaps):
            return opened
        gaps = kept
    return structure


def _gaps(structure: np.ndarray, ppm: float, *, turned: bool) -> list[_Gap]:
    """Return the gaps in walls along the rows, or along the columns if `turned`."""
    plane = structure.T if turned else structure
    solid = ndimage.binary_closing((plane != ROOM) & (plane != OUTSIDE), np.ones((3, 3)))
    floors, _ = ndimage.label((plane == ROOM) & ~solid)
    thin = np.where(_standing(solid, ppm), 0, _thin(floors, solid, ppm))
    marks = np.zeros(plane.shape, np.int8)  # 1 in a gap
    for y, row in enumerate(solid):
        if row.any():
            _mark_row(marks[y], floors[y], row, thin[y], ppm)
    places, count = ndimage.label(marks)
    gaps = []
    for box in ndimage.find_objects(places, count):
        rows, columns = box
        if rows.stop - rows.start <= SETTINGS.ending_wall * ppm:
            thick = (max(0, rows.start - 1), rows.stop + 1)
            gaps.append(_Gap(thick, (columns.start, columns.stop), turned))
    return gaps


def _standing(solid: np.ndarray, ppm: float) -> np.ndarray:
    """Return the mask (h, w) bool of what stands alone in a floor: furniture, pillars, screens."""
    places, count = ndimage.label(solid, np.ones((3, 3)))
    boxes = ndimage.find_objects(places, count)
    small = [max(s.stop - s.start for s in box) < SETTINGS.standing * ppm for box in boxes]
    return np.asarray(np.array([False, *small])[places])


def _thin(floors: np.ndarray, solid: np.ndarray, ppm: float) -> np.ndarray:
    """Return for each pixel (h, w) of a thin wall the floor's number on both its sides, else 0.

    It is 0 where the sides, above and below, differ: a wall within one floor ends somewhere in it.
    """
    thin = np.zeros(solid.shape, np.int32)
    height = len(floors)
    for x in range(solid.shape[1]):
        edges = np.flatnonzero(np.diff(np.r_[0, solid[:, x].astype(np.int8), 0]))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            free = start > 0 and stop < height
            if free and stop - start <= SETTINGS.ending_wall * ppm:
                one, other = floors[start - 1, x], floors[stop, x]
                thin[start:stop, x] = one if one == other else 0
    return thin


def _mark_row(
    marks: np.ndarray, floors: np.ndarray, solid: np.ndarray, thin: np.ndarray, ppm: float
) -> None:
    """Mark the gaps of one row: floor from the end of a wall to another end, or to a wall."""
    edges = np.flatnonzero(np.diff(np.r_[0, solid.astype(np.int8), 0]))
    starts, stops = edges[::2], edges[1::2]
    least = max(2, round(SETTINGS.free_end * ppm))
    for k in range(len(starts) - 1):
        low, high = int(stops[k]), int(starts[k + 1])
        floor = floors[low]
        if not floor or not (floors[low:high] == floor).all():
            continue
        before, after = _run(thin[:low][::-1] == floor), _run(thin[high:] == floor)
        ends = (before >= least) + (after >= least)
        if not ends:
            continue
        facing = ends == 2
        shortest, longest = SETTINGS.facing if facing else SETTINGS.across
        least_share = SETTINGS.facing_walled if facing else SETTINGS.across_walled
        gap = high - low
        walled = (before + after) / (before + after + gap)
        if shortest * ppm <= gap <= longest * ppm and walled >= least_share:
            marks[low:high] = 1


def _run(values: np.ndarray) -> int:
    """Return the number of true values before the first false one."""
    return int(len(values) if values.all() else np.argmin(values))
