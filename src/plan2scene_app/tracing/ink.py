"""Correct the network's labels by the drawn lines: gaps in solid walls, and swings of doors.

Estate agents draw walls solid and doors as a gap with a thin arc, in which the network sees a wall
or a window.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import product

import cv2
import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from plan2scene_app.tracing.openings import Edge, TracedOpening, edge_of, edges_of, joined
from plan2scene_app.tracing.picture import paper_share
from plan2scene_app.tracing.settings import (
    DOOR,
    OUTSIDE,
    PASSAGE,
    ROOM,
    SETTINGS,
    WALL,
    WINDOW,
)


def ink_of(image: np.ndarray) -> np.ndarray:
    """Return the darkness (h, w) float32 of (h, w, 3) uint8: 0 for paper, 1 for the darkest ink."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    paper, dark = np.percentile(grey, [90, 0.5])
    return np.asarray(np.clip((paper - grey) / max(paper - dark, 1.0), 0, 1), np.float32)


def drawn_solid(structure: np.ndarray, image: np.ndarray, ppm: float) -> bool:
    """Return whether the walls of a structure (h, w) uint8 are drawn solid."""
    wall = structure == WALL
    solid = solid_walls(ink_of(image), ppm)
    return bool(wall.any() and solid[wall].mean() >= SETTINGS.solid)


def with_drawn_walls(structure: np.ndarray, image: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure (h, w) uint8 with its solid walls continued where it sees outside.

    The network may see neither floor nor walls of a large empty room, such as a garage.
    """
    solid, count = ndimage.label(solid_walls(ink_of(image), ppm), np.ones((3, 3)))
    walls = np.bincount(solid[structure == WALL], minlength=count + 1)
    missed = np.bincount(solid[structure == OUTSIDE], minlength=count + 1)
    goes_on = walls > missed
    goes_on[0] = False
    return np.where(goes_on[solid] & (structure == OUTSIDE), WALL, structure).astype(np.uint8)


def without_standing_lines(structure: np.ndarray, image: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure (h, w) uint8 with thin lines that stand alone on a floor as floor.

    The plan's walls must be solid. The network takes a kitchen island's outline for walls.
    """
    solid = solid_walls(ink_of(image), ppm)
    around, _ = ndimage.label(np.pad(structure == OUTSIDE, 1, constant_values=True))
    outside = ndimage.binary_dilation(around == around[0, 0])[1:-1, 1:-1]
    places, count = ndimage.label(~np.isin(structure, (ROOM, OUTSIDE)), np.ones((3, 3)))
    standing = np.ones(count + 1, bool)
    standing[np.unique(places[solid | outside | (structure != WALL)])] = False
    return np.where(standing[places], ROOM, structure).astype(np.uint8)


def with_drawn_doors(structure: np.ndarray, image: np.ndarray, ppm: float) -> np.ndarray:
    """Return the structure (h, w) uint8 with gaps in solid walls, and swings, as doors.

    A gap between rooms with at most a faint line in it is a passage if it is wider than a door, or
    has no swing in a clean drawing whose other doors mostly have one. The structure stays as it is
    if the walls are not drawn solid.
    """
    ink = ink_of(image)
    solid = solid_walls(ink, ppm)
    if not drawn_solid(structure, image, ppm):
        return structure
    changed = structure.copy()
    thin = ndimage.binary_dilation(ink > SETTINGS.ink, np.ones((3, 3)))
    near = ndimage.binary_dilation(solid, np.ones((3, 3)))
    low, high = (width * ppm for width in SETTINGS.door_gap)
    for label in (WALL, WINDOW):
        for gap in _gaps((structure == label) & ~near, solid, ppm):
            rows, columns, turned, width = gap
            sides = _beside(structure, rows, columns, turned)
            inner = ROOM in sides and OUTSIDE not in sides
            if _swings(thin, gap) or (label == WALL and inner and low <= width <= high):
                part = changed[rows, columns]
                part[part != ROOM] = DOOR
                part[solid[rows, columns]] = WALL
    for rows, columns, _, width in _gaps(np.isin(changed, (DOOR, WINDOW)), solid, ppm):
        part = changed[rows, columns]  # one opening from jamb to jamb
        share = (part == DOOR).sum() / np.isin(part, (DOOR, WINDOW)).sum()
        if share >= SETTINGS.half_door and width <= SETTINGS.double_door * ppm:
            part[part == WINDOW] = DOOR
    changed = _parted(changed, [g for g in _facing(solid, ppm) if _swings(thin, g)], solid, ppm)
    thick = solid_walls(ink, 2 * ppm)
    swinging = [
        (gap, swing)
        for gap in _gaps(changed == DOOR, solid, ppm)
        if (swing := _swings(thin, gap)) is not None
    ]
    shut = np.zeros_like(solid)  # the doors themselves: the sweep of another leaf keeps them
    for (rows, columns, _, _), _ in swinging:
        shut[rows, columns] = changed[rows, columns] == DOOR
    for _, (swept, beyond) in swinging:
        # If something solid lies behind the open leaf, thin solid walls in the sweep stay, too.
        _sweep(changed, shut | (solid if solid[beyond].any() else thick), swept)

    def blank(gap: _Gap) -> bool:
        rows, columns, turned, _ = gap
        darkest = ink[rows, columns].max(axis=1 if turned else 0)
        between = _beside(changed, rows, columns, turned) == (ROOM, ROOM)
        return between and (darkest < SETTINGS.solid_ink).mean() >= SETTINGS.gap_faint

    wide = [g for g in _gaps(~np.isin(changed, (ROOM, OUTSIDE)) & ~near, solid, ppm) if g[3] > high]
    doors = list(_gaps(changed == DOOR, solid, ppm))
    unswung = [gap for gap in doors if not _swings(thin, gap)]
    open_ones = [gap for gap in wide if not _swings(thin, gap)]
    clean = paper_share(image) >= SETTINGS.drawn_paper  # on photographed paper arcs are missed
    if clean and len(unswung) < SETTINGS.unswung * len(doors):
        open_ones += unswung
    for rows, columns, _, _ in filter(blank, open_ones):
        part = changed[rows, columns]
        part[part != ROOM] = PASSAGE
    return changed


def solid_walls(ink: np.ndarray, ppm: float) -> np.ndarray:
    """Return the mask (h, w) bool of solid ink that is at least as thick as the thinnest wall."""
    side = max(3, round(SETTINGS.thin_wall * ppm))
    dark = (ink > SETTINGS.solid_ink).astype(np.uint8)
    return np.asarray(cv2.morphologyEx(dark, cv2.MORPH_OPEN, np.ones((side, side), np.uint8)) > 0)


_Gap = tuple[slice, slice, bool, int]  #: rows, columns, whether it runs along y, width
#: Rows and columns.
_Box = tuple[slice, slice]


def _gaps(drawn: np.ndarray, solid: np.ndarray, ppm: float) -> Iterator[_Gap]:
    """Yield the gaps in solid walls that a connected component of `drawn` (h, w) bool fills."""
    places, count = ndimage.label(drawn)
    for number, box in enumerate(ndimage.find_objects(places, count), start=1):
        gap = _gap(places, number, box, solid, ppm)
        if gap is not None:
            yield gap


def _gap(
    places: np.ndarray, number: int, box: tuple[slice, slice], solid: np.ndarray, ppm: float
) -> _Gap | None:
    """Return the gap between two solid ends that component `number` fills, or None."""
    height, width = (s.stop - s.start for s in box)
    turned = height > width
    long, short = max(height, width), min(height, width)
    if not SETTINGS.gap[0] * ppm <= long <= SETTINGS.gap[1] * ppm or short > 0.6 * long:
        return None
    if (places[box] == number).mean() < 0.4:
        return None
    plane = solid.T if turned else solid
    across, along = (box[1], box[0]) if turned else box
    reach = max(4, round(0.3 * ppm))
    before = plane[across, max(0, along.start - reach) : along.start]
    after = plane[across, along.stop : along.stop + reach]
    if not (before.any() and after.any()):
        return None
    start = along.start - (reach if along.start >= reach else along.start)
    first = start + int(np.flatnonzero(before.any(0))[-1]) + 1
    last = along.stop + int(np.flatnonzero(after.any(0))[0])
    along = slice(first, last)
    rows, columns = (along, across) if turned else (across, along)
    return rows, columns, turned, last - first


def _parted(
    structure: np.ndarray, doors: Sequence[_Gap], solid: np.ndarray, ppm: float
) -> np.ndarray:
    """Return the structure with those of the doors that part two floors, both large enough."""
    closed = structure.copy()
    for rows, columns, _, _ in doors:
        closed[rows, columns][~solid[rows, columns]] = DOOR
    floors, count = ndimage.label(closed == ROOM)
    sizes = np.bincount(floors.ravel(), minlength=count + 1)
    sizes[0] = 0
    parted = structure.copy()
    for rows, columns, turned, _ in doors:
        one, other = _beside(floors, rows, columns, turned)
        if one != other and min(sizes[one], sizes[other]) >= SETTINGS.parted_floor * ppm**2:
            parted[rows, columns] = closed[rows, columns]
    return parted


def _facing(solid: np.ndarray, ppm: float) -> Iterator[_Gap]:
    """Yield the gaps, as wide as doors may be, from an end of a solid wall to another wall."""
    least, most = (width * ppm for width in (SETTINGS.door_gap[0], SETTINGS.double_door))
    thinnest, thickest = SETTINGS.thin_wall * ppm, SETTINGS.ending_wall * ppm
    for turned in (False, True):
        plane = solid.T if turned else solid
        thick, long = _run_lengths(plane), _run_lengths(plane.T).T
        ending = (thick <= thickest) & (long >= 1.5 * thick)
        gap_boxes: list[list[int]] = []  # start and stop along the gap, start and stop across it
        for y, row in enumerate(plane):
            edges = np.flatnonzero(np.diff(row.astype(np.int8)))
            for low, high in zip(edges[:-1] + 1, edges[1:] + 1, strict=True):
                ends = ending[y, low - 1] or ending[y, high]
                if row[low] or not ends or not least <= high - low <= most:
                    continue
                above = (
                    g for g in gap_boxes if g[3] == y and abs(g[0] - low) + abs(g[1] - high) <= 2
                )
                gap = next(above, None)
                if gap is None:
                    gap_boxes.append([int(low), int(high), y, y + 1])
                else:
                    gap[3] = y + 1
        for low, high, first, last in gap_boxes:
            if thinnest <= last - first <= thickest:
                across, along = slice(first, last), slice(low, high)
                rows, columns = (along, across) if turned else (across, along)
                yield rows, columns, turned, high - low


def _run_lengths(plane: np.ndarray) -> np.ndarray:
    """Return for each true pixel the length of its run in its column; 0 for the others."""
    above, below = np.zeros((2, *plane.shape), np.int32)
    for y in range(1, len(plane)):
        above[y] = np.where(plane[y - 1], above[y - 1] + 1, 0)
        below[-1 - y] = np.where(plane[-y], below[-y] + 1, 0)
    return np.where(plane, above + below + 1, 0)


def _beside(structure: np.ndarray, rows: slice, columns: slice, turned: bool) -> tuple[int, int]:
    """Return the most frequent label (or number of a floor) on each side of a gap."""
    plane = structure.T if turned else structure
    across, along = (columns, rows) if turned else (rows, columns)
    sides = []
    for row in (across.start - 4, across.stop + 3):
        near = plane[min(max(row, 0), len(plane) - 1), along]
        sides.append(int(np.bincount(near).argmax()) if near.size else OUTSIDE)
    return sides[0], sides[1]


#: Pixels from an arc to the points beside it that should be blank.
_CLEAR = 4


def _sweep(structure: np.ndarray, walls: np.ndarray, swept: _Box) -> None:
    """Relabel what a leaf sweeps in a room as floor: an open leaf is no wall, its arc no door."""
    part = structure[swept]
    if (part == ROOM).mean() > 0.5:
        part[np.isin(part, (WALL, DOOR, PASSAGE)) & ~walls[swept]] = ROOM


def _swings(thin: np.ndarray, gap: _Gap, *, leaves: bool = False) -> tuple[_Box, _Box] | None:
    """Find the drawn arc of a door in a gap: the boxes that its leaf sweeps and behind it, or None.

    The leaf turns about an end of the gap and is as wide as the gap or half of it. The arc's centre
    may lie at either face or in the middle of the wall. With `leaves`, the open leaf must be drawn,
    too. `thin` (h, w) bool is where lines are.
    """
    rows, columns, turned, width = gap
    plane = thin.T if turned else thin
    across, along = (columns, rows) if turned else (rows, columns)
    angles = np.radians(np.linspace(*SETTINGS.arc_angles, 15))
    for leaf in (width, width / 2):
        for radius in leaf * np.array(SETTINGS.arc_radii):
            if radius < 5:
                continue
            for hinge, way in ((along.start, 1), (along.stop - 1, -1)):
                x = np.round(hinge + way * radius * np.cos(angles)).astype(int)
                for side in (1, -1):
                    for y0 in {across.start, (across.start + across.stop) // 2, across.stop - 1}:
                        y = np.round(y0 + side * radius * np.sin(angles)).astype(int)
                        drawn_share = _drawn(plane, x, y)
                        if drawn_share < SETTINGS.arc_drawn:
                            continue
                        beside = [
                            _drawn(plane, x + way * d, y + side * d) for d in (-_CLEAR, _CLEAR)
                        ]
                        if max(beside) > SETTINGS.arc_beside:
                            continue
                        ways = (way * radius, side * radius)
                        if not leaves or _leaf_drawn(plane, (hinge, y0), ways):
                            return _boxes_of_swing(gap, hinge, *ways)
    return None


def _boxes_of_swing(gap: _Gap, hinge: int, shut: float, opened: float) -> tuple[_Box, _Box]:
    """Return two boxes: what a leaf sweeps, and what lies behind the open leaf.

    From its hinge the shut leaf reaches `shut` pixels along the gap, the open one `opened` pixels
    across it (signed). The swept box is widened by the open leaf as thick as the network sees it.
    """
    rows, columns, turned, _ = gap
    across = columns if turned else rows
    edge = across.stop if opened > 0 else across.start
    blur = SETTINGS.leaf_seen * abs(shut)
    ends = sorted((hinge - np.sign(shut) * blur, hinge + shut + 2 * np.sign(shut)))

    def span(low: float, high: float) -> slice:
        return slice(max(0, round(min(low, high))), max(0, round(max(low, high))) + 1)

    (near, far), (behind, end) = SETTINGS.leaf_reach, SETTINGS.behind_leaf
    swept = span(edge + near * opened, edge + far * opened), span(*ends)
    beyond = span(edge + behind * opened, edge + end * opened), span(hinge - blur, hinge + blur)
    return (swept[::-1], beyond[::-1]) if turned else (swept, beyond)


def _leaf_drawn(plane: np.ndarray, hinge: tuple[int, int], ways: tuple[float, float]) -> bool:
    """Return whether a leaf is drawn from hinge (x, y) to arc, open by 40 to 100 degrees."""
    angles = np.radians(np.arange(40.0, 100.0, 2.0))
    along = np.linspace(0.3, 0.95, 20)[:, None]
    x = np.round(hinge[0] + ways[0] * along * np.cos(angles)).astype(int)
    y = np.round(hinge[1] + ways[1] * along * np.sin(angles)).astype(int)
    return any(_drawn(plane, *line) > 0.95 for line in zip(x.T, y.T, strict=True))


def with_whole_windows(
    openings: Sequence[TracedOpening],
    polygons: Mapping[int, Polygon],
    image: np.ndarray,
    wall_px: float,
    ppm: float,
    garages: Collection[int] = (),
) -> list[TracedOpening]:
    """Return openings with each window as long as the profile across its wall stays the same.

    The network sees only the ends of a long window, and joins two windows that are near each other.
    Doors to the outside of rooms that are `garages` are treated alike. `image` (h, w, 3) uint8 has
    no text; walls are `wall_px` thick.
    """
    ink = ink_of(image)
    long = [o for o in openings if o.kind == "window" or (o.room in garages and not o.other)]
    whole_openings = [opening for opening in openings if opening not in long]
    other_ends = [np.array([opening.start, opening.end]) for opening in whole_openings]
    edges = edges_of(polygons)
    for window in long:
        whole_openings += _whole_windows(
            window, edge_of(window, edges), other_ends, ink, wall_px, ppm
        )
    return joined(whole_openings, ppm)


def _across(edge: Edge, plane: np.ndarray, wall_px: float) -> np.ndarray:
    """Sample a plane (h, w) float32 across a wall, (n, m): one profile for each pixel of its edge.

    A profile goes from `wall_px` on one side of the edge to `wall_px` on the other.
    """
    steps = np.arange(0.5, edge.length)
    half = np.arange(-round(wall_px), round(wall_px) + 1)
    places = edge.start + steps[:, None, None] * edge.way + half[None, :, None] * edge.inwards
    rows, columns = places[..., 1], places[..., 0]
    return np.asarray(ndimage.map_coordinates(plane, [rows, columns], order=1, mode="nearest"))


def _whole_windows(
    window: TracedOpening,
    edge: Edge,
    others: Sequence[np.ndarray],
    ink: np.ndarray,
    wall_px: float,
    ppm: float,
) -> list[TracedOpening]:
    """Return the windows on a room's edge that one seen window stands for.

    They end before `others`, the ends (2, 2) of openings that are no windows. The window stays as
    it is if the profiles along it differ much.
    """
    profiles = _across(edge, ink, wall_px)
    steps = np.arange(0.5, edge.length)
    low, high = _span(window, edge)
    in_window = (steps > low) & (steps < high)
    if not in_window.any():
        return [window]
    differences = np.abs(profiles - np.median(profiles[in_window], axis=0)).max(axis=1)
    post = np.ones(max(1, round(SETTINGS.pier * ppm)))
    alike_steps = ndimage.binary_closing(differences <= SETTINGS.alike_lines, post)
    for other in others:
        along, off_edge = edge.place(other)
        if np.abs(off_edge).max() <= 2 * wall_px:
            first, last = np.sort(along).round().astype(int).clip(0)
            alike_steps[first:last] = False
    runs, _ = ndimage.label(alike_steps)
    spans = [
        (run.start, run.stop)
        for number, (run,) in enumerate(ndimage.find_objects(runs), start=1)
        if (in_window & (runs == number)).any() and run.stop - run.start >= SETTINGS.opening * ppm
    ]
    if (
        alike_steps[in_window].mean() < 0.5
        or not spans
        or spans[0][0] == 0
        or spans[-1][1] == len(steps)
    ):
        return [window]
    windows = []
    for k, (start, stop) in enumerate(spans):
        first = min(low, start) if k == 0 else start
        last = max(high, stop) if k == len(spans) - 1 else stop
        p, q = ((edge.start + along * edge.way).tolist() for along in (first, last))
        windows.append(replace(window, start=(p[0], p[1]), end=(q[0], q[1])))
    return windows


def with_sliding_doors(
    openings: Sequence[TracedOpening],
    polygons: Mapping[int, Polygon],
    image: np.ndarray,
    wall_px: float,
    ppm: float,
    open_air: Set[int],
) -> list[TracedOpening]:
    """Return openings with each gap to the outside that is part panes, part blank as one door.

    It is a sliding door: its panes are drawn beside the open part. `open_air` are the numbers of
    terraces, balconies and yards. `image` (h, w, 3) uint8 has no text; walls are `wall_px` thick.
    """
    ink = ink_of(image)
    paper = np.median(image.reshape(-1, 3), axis=0)
    marks = np.abs(image - paper).max(axis=2) / 255
    edges, beside = edges_of(polygons), SETTINGS.slid_beside * ppm
    kept = list(openings)
    for opening in openings:
        if opening not in kept or not _leads_out(opening, open_air):
            continue
        edge = edge_of(opening, edges)
        ink_profiles, mark_profiles = (_across(edge, plane, wall_px) for plane in (ink, marks))
        gap = _sliding(ink_profiles, mark_profiles, int(np.mean(_span(opening, edge))), ppm)
        if gap is None:
            continue
        low, high = gap[0] - beside, gap[1] + beside
        spans = {o: _span(o, edge) for o in kept if _lies_on(o, edge, 2 * wall_px)}
        reached = {o: span for o, span in spans.items() if span[0] < high and span[1] > low}
        sure = any(o.kind == "door" and o.confidence >= SETTINGS.swung for o in reached)
        if sure or not all(_leads_out(o, open_air) for o in reached):
            continue
        panes = [gap, *(span for o, span in reached.items() if o.kind == "window")]
        ends = min(panes)[0], max(last for _, last in panes)
        start, end = ((edge.start + along * edge.way).tolist() for along in ends)
        door = replace(opening, kind="door", start=tuple(start), end=tuple(end), confidence=0.5)
        kept = [o for o in kept if o not in reached] + [door]
    return kept


def _span(opening: TracedOpening, edge: Edge) -> tuple[float, float]:
    """Return the start and the end of an opening along an edge, pixels."""
    first, last = sorted(edge.place(np.array([opening.start, opening.end]))[0].tolist())
    return first, last


def _leads_out(opening: TracedOpening, open_air: Set[int]) -> bool:
    """Return whether an opening leads to the outside, or to or from a room in the `open_air`."""
    return not opening.other or bool(open_air & {opening.room, opening.other})


def _sliding(
    ink: np.ndarray, marks: np.ndarray, middle: int, ppm: float
) -> tuple[float, float] | None:
    """Return the ends, along an edge, of the gap of a sliding door around `middle`, or None.

    `ink` and `marks` (ink of any colour) are profiles of :func:`_across`. The gap reaches from wall
    to wall: where the drawn line is as thick as the edge's walls, it ends.
    """
    if not len(ink):
        return None
    thick = np.array([_longest_run(row > SETTINGS.solid_ink) for row in ink])
    post = np.ones(max(1, round(SETTINGS.pier * ppm)))
    wall = thick >= SETTINGS.as_thick * thick.max()
    wall = ndimage.binary_opening(np.pad(wall, len(post), mode="edge"), post)
    wall = wall[len(post) : -len(post)]
    before, after = np.flatnonzero(wall[:middle]), np.flatnonzero(wall[middle:])
    if not len(before) or not len(after) or after[0] == 0:
        return None
    low, high = int(before[-1]) + 1, middle + int(after[0])
    blank = marks[low:high].max(axis=1) < SETTINGS.faint
    if _longest_run(blank) < SETTINGS.door_gap[0] * ppm or blank.mean() > SETTINGS.slid_open:
        return None
    panes = ink[low:high][~blank]
    step = max(1, round(SETTINGS.dash * ppm))
    runs = np.abs(panes[step:] - panes[:-step]).max(axis=1) <= SETTINGS.alike_lines
    return (float(low), float(high)) if runs.mean() >= 0.5 else None  # lines of a bay are slanted


def _longest_run(line: np.ndarray) -> int:
    """Return the length of the longest run of true values in a line (n,) bool."""
    edges = np.flatnonzero(np.diff(np.r_[0, line.astype(np.int8), 0]))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _lies_on(opening: TracedOpening, edge: Edge, off: float) -> bool:
    """Return whether an opening is on an edge, at most `off` pixels beside it."""
    return bool(np.abs(edge.place(np.array([opening.start, opening.end]))[1]).max() <= off)


def with_swings(
    openings: Sequence[TracedOpening], image: np.ndarray, wall_px: float
) -> list[TracedOpening]:
    """Return openings, with a high confidence for each door whose arc is drawn.

    `image` (h, w, 3) uint8 has no text; walls are `wall_px` thick.
    """
    thin = ndimage.binary_dilation(ink_of(image) > SETTINGS.ink, np.ones((3, 3)))
    return [
        replace(opening, confidence=max(opening.confidence, SETTINGS.swung))
        if opening.kind == "door" and _is_swung(opening, thin, wall_px)
        else opening
        for opening in openings
    ]


def with_swung_windows(
    openings: Sequence[TracedOpening],
    image: np.ndarray,
    wall_px: float,
    upstairs: Collection[int] = (),
) -> list[TracedOpening]:
    """Return openings with each window whose arc and open leaf are drawn as a door.

    Outer windows of rooms `upstairs` stay windows. `image` and `wall_px` are as above.
    """
    thin = ndimage.binary_dilation(ink_of(image) > SETTINGS.ink, np.ones((3, 3)))
    kept = []
    for opening in openings:
        may = opening.kind == "window" and (opening.other or opening.room not in upstairs)
        if may and _is_swung(opening, thin, wall_px, leaves=True):
            opening = replace(opening, kind="door", confidence=min(opening.confidence, 0.5))
        kept.append(opening)
    return kept


def _is_swung(
    opening: TracedOpening, thin: np.ndarray, wall_px: float, *, leaves: bool = False
) -> bool:
    """Return whether an opening that runs roughly along x or y has an arc (:func:`_swings`)."""
    half = max(2, round(wall_px / 2))
    (x0, x1), (y0, y1) = (sorted(ends) for ends in zip(opening.start, opening.end, strict=True))
    turned = y1 - y0 > x1 - x0
    low, high, middle = (y0, y1, (x0 + x1) / 2) if turned else (x0, x1, (y0 + y1) / 2)
    across = slice(max(0, round(middle) - half), round(middle) + half + 1)
    gaps = []
    for before, after in product((-3, 0, 3), repeat=2):  # its ends are this uncertain
        along = slice(max(0, round(low) + before), round(high) + after)
        rows, columns = (along, across) if turned else (across, along)
        gaps.append((rows, columns, turned, along.stop - along.start))
    straight = min(x1 - x0, y1 - y0) <= SETTINGS.slanted * max(x1 - x0, y1 - y0)
    return straight and any(_swings(thin, gap, leaves=leaves) for gap in gaps)


def _drawn(plane: np.ndarray, x: np.ndarray, y: np.ndarray) -> float:
    """Return the share of points with something drawn in (h, w) bool; 0 if any lies outside it."""
    inside = (y >= 0) & (y < plane.shape[0]) & (x >= 0) & (x < plane.shape[1])
    return float(plane[y, x].mean()) if inside.all() else 0.0
