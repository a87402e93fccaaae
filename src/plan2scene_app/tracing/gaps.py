"""Passages that nothing marks: the floor goes on between two ends of walls.

A wall that ends in the middle of a floor goes on in the mind of who drew it: to an end that faces
it, or to the wall across. Where that parts two floors, both large enough, it is a passage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.labels import OUTSIDE, PASSAGE, ROOM

#: Metres of a gap between two ends of walls, and of one between an end and the wall across.
FACING, ACROSS = (0.6, 4.0), (0.6, 3.6)
#: Metres: a wall is no thicker, and its end is free on both sides for at least this far.
THICKEST, LEAST_END = 0.5, 0.08
#: Metres: what joins no other wall and is shorter stands alone.
ALONE = 1.8
#: Walls follow at least this share of the line from wall to wall that a gap is in.
WALLED = {"facing": 0.15, "across": 0.4}
#: Square metres of floor on both sides.
LEAST_FLOOR = 3.0


@dataclass(frozen=True)
class _Gap:
    """Floor between two ends: `rows` of the wall's thickness, `columns` of the gap."""

    rows: tuple[int, int]
    columns: tuple[int, int]
    turned: bool  #: whether rows are columns of the picture

    @property
    def place(self) -> tuple[slice, slice]:
        """Where it is in the picture."""
        along, across = slice(*self.columns), slice(*self.rows)
        return (along, across) if self.turned else (across, along)

    def sides(self, floors: np.ndarray) -> tuple[int, int]:
        """Return the floors on both sides, 0 for none; `floors` (h, w) are numbered."""
        plane = floors.T if self.turned else floors
        found = []
        for row in (self.rows[0] - 1, self.rows[1]):
            near = plane[row, slice(*self.columns)] if 0 <= row < len(plane) else np.zeros(1, int)
            found.append(int(np.bincount(near).argmax()))
        return found[0], found[1]


def with_passages(structure: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure (h, w) uint8 with passages where floors go on between ends of walls."""
    gaps = [gap for turned in (False, True) for gap in _gaps(structure, ppm, turned=turned)]
    while gaps:
        found = structure.copy()
        for gap in gaps:
            part = found[gap.place]
            part[part == ROOM] = PASSAGE
        floors, count = ndimage.label(found == ROOM)
        sizes = np.bincount(floors.ravel(), minlength=count + 1)
        sizes[0] = 0
        kept = []
        for gap in gaps:
            one, other = gap.sides(floors)
            if one != other and min(sizes[one], sizes[other]) >= LEAST_FLOOR * ppm**2:
                kept.append(gap)
        if len(kept) == len(gaps):
            return found
        gaps = kept
    return structure


def _gaps(structure: np.ndarray, ppm: float, *, turned: bool) -> list[_Gap]:
    """Return the gaps along the rows, or along the columns where `turned`."""
    plane = structure.T if turned else structure
    solid = ndimage.binary_closing((plane != ROOM) & (plane != OUTSIDE), np.ones((3, 3)))
    floors, _ = ndimage.label((plane == ROOM) & ~solid)
    thin = np.where(_standing(solid, ppm), 0, _thin(floors, solid, ppm))
    marks = np.zeros(plane.shape, np.int8)  # of gaps: 0 none, else one
    for y, row in enumerate(solid):
        if row.any():
            _mark_row(marks[y], floors[y], row, thin[y], ppm)
    places, count = ndimage.label(marks)
    found = []
    for box in ndimage.find_objects(places, count):
        rows, columns = box
        if rows.stop - rows.start <= THICKEST * ppm:
            thick = (max(0, rows.start - 1), rows.stop + 1)
            found.append(_Gap(thick, (columns.start, columns.stop), turned))
    return found


def _standing(solid: np.ndarray, ppm: float) -> np.ndarray:
    """Return what stands alone in a floor (h, w) bool: furniture, pillars, screens."""
    places, count = ndimage.label(solid, np.ones((3, 3)))
    boxes = ndimage.find_objects(places, count)
    small = [max(s.stop - s.start for s in box) < ALONE * ppm for box in boxes]
    return np.asarray(np.array([False, *small])[places])


def _thin(floors: np.ndarray, solid: np.ndarray, ppm: float) -> np.ndarray:
    """Return the floor (h, w; 0 for none) on both sides of walls that columns cross.

    A wall with one floor on both sides, no thicker than usual, is one that ends somewhere.
    """
    found = np.zeros(solid.shape, np.int32)
    height = len(floors)
    for x in range(solid.shape[1]):
        edges = np.flatnonzero(np.diff(np.r_[0, solid[:, x].astype(np.int8), 0]))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            free = start > 0 and stop < height
            if free and stop - start <= THICKEST * ppm:
                one, other = floors[start - 1, x], floors[stop, x]
                found[start:stop, x] = one if one == other else 0
    return found


def _mark_row(
    marks: np.ndarray, floors: np.ndarray, solid: np.ndarray, thin: np.ndarray, ppm: float
) -> None:
    """Mark the gaps of one row: all floor, from an end of a wall to an end or a wall."""
    edges = np.flatnonzero(np.diff(np.r_[0, solid.astype(np.int8), 0]))
    starts, stops = edges[::2], edges[1::2]
    least = max(2, round(LEAST_END * ppm))
    for k in range(len(starts) - 1):
        low, high = int(stops[k]), int(starts[k + 1])
        floor = floors[low]
        if not floor or not (floors[low:high] == floor).all():
            continue
        before, after = _run(thin[:low][::-1] == floor), _run(thin[high:] == floor)
        ends = (before >= least) + (after >= least)
        if not ends:
            continue
        kind, (shortest, longest) = ("facing", FACING) if ends == 2 else ("across", ACROSS)
        gap = high - low
        walled = (before + after) / (before + after + gap)
        if shortest * ppm <= gap <= longest * ppm and walled >= WALLED[kind]:
            marks[low:high] = 1


def _run(values: np.ndarray) -> int:
    """Return how many values are true before the first that is not."""
    return int(len(values) if values.all() else np.argmin(values))
