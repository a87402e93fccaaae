"""Walls drawn as thin single lines, found where they part named rooms that the network joins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.ink import ink_of, solid_walls
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, PASSAGE, ROOM, SETTINGS, WALL


@dataclass(frozen=True)
class _Parted:
    """A structure parted by thin lines."""

    structure: np.ndarray
    ppm: float
    agree: int  #: number of printed sizes that agree on the pixels a metre
    names: int  #: number of parts with a name


def with_thin_walls(
    structure: np.ndarray,
    image: np.ndarray,
    names: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float, float]],
    ppm: float,
) -> tuple[np.ndarray, float]:
    """Return the structure (h, w) uint8 with straight lines as walls, gaps in them as doors.

    It also returns the pixels a metre, by `sizes` (x, y, m2 of the room there), else by the widths
    of these doors. `names` are the places (x, y) of room names. Lines between named rooms are
    walls; an area with neither a name nor a gap in its border is furniture. The structure stays as
    it is if the lines part fewer than `SETTINGS.thin_names` more names and have fewer gaps than
    that. `ppm` is a guess: several scales near it are tried, and the one on which most sizes agree
    is taken.
    """
    candidates = [
        parted
        for factor in SETTINGS.thin_scales
        if (parted := _parted_at(structure, image, names, sizes, factor * ppm)) is not None
    ]
    if not candidates:
        return structure, ppm
    best = max(candidates, key=lambda parted: (parted.agree, parted.names))
    return best.structure, best.ppm


def _parted_at(
    structure: np.ndarray,
    image: np.ndarray,
    names: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float, float]],
    ppm: float,
) -> _Parted | None:
    """Return the structure parted at one guess of the scale; None if too few names are parted."""
    dark = ink_of(image)
    ink, solid = dark > SETTINGS.ink, solid_walls(dark, 2 * ppm)
    inside = ndimage.binary_fill_holes(structure != OUTSIDE) & (structure == OUTSIDE)
    # Lines that the network takes for walls are judged anew.
    line = (structure == WALL) & ~ndimage.binary_dilation(solid, np.ones((3, 3)))
    floor = (structure == ROOM) | inside | line
    widths: list[int] = []
    walls, doors = np.zeros(floor.shape, bool), np.zeros(floor.shape, bool)
    wall_mask = cv2.dilate((structure == WALL).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    for turned in (False, True):
        drawn, walled = (ink.T, wall_mask.T) if turned else (ink, wall_mask)
        line, gap, wide = _lines(drawn, walled, ppm)
        widths += wide
        line = ndimage.binary_dilation(line, np.ones((3, 1)))
        gap = ndimage.binary_dilation(gap, np.ones((3, 1)))
        walls |= line.T if turned else line
        doors |= gap.T if turned else gap
    before = _parted(structure == ROOM, names)
    # Where the network sees an opening in a part of a gap, the whole gap is an opening.
    opening = np.isin(structure, (DOOR, PASSAGE))
    floor |= opening & doors
    added = walls & floor
    gaps = doors & floor & ~added
    for _ in range(SETTINGS.thin_rounds):
        faces, count = ndimage.label(floor & ~added & ~gaps)
        kept = _rooms(faces, count, gaps, names, ppm)
        opened = _without_furniture(faces, kept, added)
        if (opened == added).all():
            break
        added = opened
    parts = _parted(floor & ~added & ~gaps, names)
    more = parts - before, ndimage.label(gaps)[1]
    if more[0] < 0 or max(more) < SETTINGS.thin_names:
        return None
    changed = structure.copy()
    changed[floor] = ROOM
    changed[gaps] = DOOR
    changed[added] = WALL
    changed[opening & (cv2.dilate(gaps.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0)] = DOOR
    faces, count = ndimage.label(floor & ~added & ~gaps)
    areas = np.bincount(faces.ravel(), minlength=count + 1)
    at: dict[int, list[float]] = {}
    for x, y, area in sizes:
        if 0 <= x < faces.shape[1] - 1 and 0 <= y < faces.shape[0] - 1:
            at.setdefault(int(faces[round(y), round(x)]), []).append(area)
    printed_scales = [
        float(np.sqrt(areas[face] / printed_areas[0]))
        for face, printed_areas in at.items()
        if face and len(printed_areas) == 1
    ]
    # A floor that is several unparted rooms gives too large a scale: take the scales that agree.
    agree = [
        [one for one in printed_scales if abs(np.log(one / other)) < 0.06]
        for other in sorted(printed_scales)
    ]
    best = max(agree, key=len, default=[])
    if len(best) >= 2:
        return _Parted(changed, float(np.mean(best)), len(best), parts)
    by_doors = float(np.median(widths)) / SETTINGS.door_width[0] if len(widths) >= 3 else ppm
    return _Parted(changed, float(np.clip(by_doors, ppm / 2, 2 * ppm)), 0, parts)


def _without_furniture(faces: np.ndarray, kept: np.ndarray, added: np.ndarray) -> np.ndarray:
    """Return the lines (h, w) bool without those between furniture and the room it stands in.

    `faces` (h, w) are numbered from 1; `kept` tells which are rooms. Furniture stands in the face
    with the largest shared border, divided by the square root of that face's area.
    """
    opened = added.copy()
    sizes = np.bincount(faces.ravel(), minlength=len(kept))
    boxes = ndimage.find_objects(faces, len(kept) - 1)
    for number in np.flatnonzero(~kept).tolist():
        if not number or boxes[number - 1] is None:
            continue
        box = tuple(slice(max(0, s.start - 8), s.stop + 8) for s in boxes[number - 1])
        furniture, part = faces[box] == number, faces[box]
        near = cv2.dilate(furniture.astype(np.uint8), np.ones((13, 13), np.uint8)) > 0
        beside = np.bincount(part[near & ~furniture], minlength=len(kept)).astype(float)
        beside[[0, number]] = 0
        if beside.max() == 0:
            continue
        other = int(np.argmax(beside / np.sqrt(np.maximum(sizes, 1))))
        near_other = cv2.dilate((part == other).astype(np.uint8), np.ones((13, 13), np.uint8)) > 0
        opened[box] &= ~(near & near_other)
    return opened


def _parted(floor: np.ndarray, names: Sequence[tuple[float, float]]) -> int:
    """Return the number of connected parts of a floor (h, w) bool that have a name."""
    places, _ = ndimage.label(floor)
    h, w = floor.shape
    inside = [(round(x), round(y)) for x, y in names if 0 <= x < w - 1 and 0 <= y < h - 1]
    return len({int(places[y, x]) for x, y in inside} - {0})


def _rooms(
    faces: np.ndarray,
    count: int,
    gaps: np.ndarray,
    names: Sequence[tuple[float, float]],
    ppm: float,
) -> np.ndarray:
    """Return which faces are rooms: they have a name, or a gap and the size of a room.

    `faces` (h, w) are numbered from 1; the result is (count + 1,) bool.
    """
    beside = cv2.dilate(gaps.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    touched = np.bincount(faces[beside], minlength=count + 1)
    sizes = np.bincount(faces.ravel(), minlength=count + 1)
    kept = (touched > SETTINGS.room_width * ppm) & (sizes >= SETTINGS.room_floor * ppm**2)
    h, w = faces.shape
    for x, y in names:
        if 0 <= x < w - 1 and 0 <= y < h - 1:
            kept[faces[round(y), round(x)]] = True
    kept[0] = False
    return np.asarray(kept)


def _lines(
    ink: np.ndarray, seen: np.ndarray, ppm: float
) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return straight lines along x, the gaps between two in line (h, w) bool, and their widths.

    A line counts if the network has labelled enough of it as wall (`seen`, (h, w) bool), which it
    does not do for the edge of a bath.
    """
    length = max(9, round(SETTINGS.thin_line * ppm))
    thickened = cv2.dilate(ink.astype(np.uint8), np.ones((3, 1), np.uint8))
    lines = cv2.morphologyEx(thickened, cv2.MORPH_OPEN, np.ones((1, length), np.uint8)) > 0
    lines &= ink
    places, count = ndimage.label(
        cv2.dilate(lines.astype(np.uint8), np.ones((3, 1), np.uint8)), np.ones((3, 3))
    )
    boxes = ndimage.find_objects(places, count)
    ends = []
    for number, box in enumerate(boxes, start=1):
        line_mask = places[box] == number
        if seen[box][line_mask].mean() < SETTINGS.thin_seen:
            lines[box] &= ~line_mask
            continue
        rows = [box[0].start + float(np.nonzero(line_mask[:, k])[0].mean()) for k in (0, -1)]
        ends.append((box[1].start, box[1].stop, rows[0], rows[1]))
    gaps = np.zeros(ink.shape, bool)
    widths: list[int] = []
    low, high = (size * ppm for size in SETTINGS.thin_gap)
    for left, (first, stop, _, y) in enumerate(ends):
        best: tuple[float, int, int] | None = None
        for right, (start, last, other, _) in enumerate(ends):
            gap, longer = start - stop, max(stop - first, last - start)
            fits = low <= gap <= high and longer >= SETTINGS.thin_wall_beside * ppm
            if left != right and fits and abs(y - other) <= 3:
                best = min(best or (gap, start, right), (gap, start, right))
        if best is None:
            continue
        row = round(y)
        band = ink[max(0, row - 2) : row + 3, stop + 3 : best[1] - 3]
        if band.any(0).mean() < 0.25:
            gaps[row, stop : best[1]] = True
            widths.append(best[1] - stop)
    return lines, gaps, widths
