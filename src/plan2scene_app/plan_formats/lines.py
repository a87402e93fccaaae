"""Find walls that are drawn as lines: pairs of faces, single axes, and gaps for openings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from shapely import unary_union
from shapely.geometry import LineString, MultiLineString, Polygon
from shapely.ops import polygonize
from shapely.strtree import STRtree

from plan2scene.plans.openings import Segment
from plan2scene_app.plan_formats.axes import (
    DEFAULT_THICKNESS,
    SETTINGS,
    WallAxis,
    is_floor,
    limit_pairs,
    same_ends,
)


def axes_of_lines(lines: Sequence[LineString]) -> list[WallAxis]:
    """Return the wall axes of lines: the middle line of two faces, else the line itself.

    Faces are paired, the nearest pairs first. A long face may have several short partners, as where
    walls that join it interrupt the opposite face. An axis is as long as the shorter face.
    """
    segments = [pair for line in lines for pair in pairwise(line.coords) if math.dist(*pair) > 0.01]
    segment_by_ends: dict[object, tuple[tuple[float, ...], ...]] = {}
    for pair in segments:
        segment_by_ends.setdefault(same_ends(*pair), pair)
    pieces = [LineString(pair) for pair in segment_by_ends.values()]
    if not pieces:
        return []
    limit_pairs(pieces, SETTINGS.faces[1], "lines of walls side by side")
    covered = np.zeros(len(pieces))
    lengths = np.array([piece.length for piece in pieces])
    axes = []
    for distance, i, j in sorted(_pairs(pieces)):
        short, long = (i, j) if lengths[i] <= lengths[j] else (j, i)
        if max(covered[short] / lengths[short], covered[long] / lengths[long]) < SETTINGS.covered:
            covered[[short, long]] += lengths[short]
            axes.append(_middle(pieces[short], pieces[long], distance))
    single = [k for k in range(len(pieces)) if covered[k] == 0]
    if axes:
        # Leave out ends of walls and reveals: short lines across a wall with two faces.
        widest = max(axis.thickness for axis in axes)
        single = [k for k in single if pieces[k].length > 1.2 * widest]
    ends = (list(pieces[k].coords) for k in single)
    return axes + [WallAxis(a, b, DEFAULT_THICKNESS) for a, b in ends]


def _pairs(pieces: Sequence[LineString]) -> list[tuple[float, int, int]]:
    """Return (distance, i, j) for each two lines that may be the two faces of a wall.

    Both must be longer than the wall is thick: the two ends of a short wall are no faces.
    """
    tree = STRtree(pieces)
    left, right = tree.query(pieces, predicate="dwithin", distance=SETTINGS.faces[1])
    pairs = []
    for i, j in zip(left.tolist(), right.tolist(), strict=True):
        if i >= j:
            continue
        a, b = _unit(pieces[i]), _unit(pieces[j])
        if abs(a[0] * b[1] - a[1] * b[0]) > math.sin(SETTINGS.face_angle):
            continue
        start = np.array(pieces[i].coords[0])
        offsets = np.array(pieces[j].coords) - start
        across = float(np.mean(offsets @ np.array([-a[1], a[0]])))
        low, high = sorted((offsets @ a).tolist())
        shared = min(high, pieces[i].length) - max(low, 0.0)
        shorter = min(pieces[i].length, pieces[j].length)
        thin = SETTINGS.faces[0] <= abs(across) <= min(SETTINGS.faces[1], shorter)
        if thin and shared >= SETTINGS.shared * shorter:
            pairs.append((round(abs(across), 3), i, j))
    return pairs


def _unit(line: LineString) -> np.ndarray:
    step = np.subtract(line.coords[1], line.coords[0])
    return np.asarray(step / np.linalg.norm(step))


def _middle(short: LineString, long: LineString, thickness: float) -> WallAxis:
    """Return the axis half-way between two faces, as long as the short one."""
    way = _unit(short)
    ends = np.array(short.coords)
    normal = np.array([-way[1], way[0]])
    side = float(np.mean((np.array(long.coords) - ends[0]) @ normal)) / 2 * normal
    start, end = (ends + side).tolist()
    return WallAxis(tuple(start), tuple(end), thickness)


def bridges(axes: Sequence[WallAxis], openings: Sequence[Segment]) -> list[WallAxis]:
    """Return a piece of wall for each opening that lies in the gap between two axes.

    The piece lies on the line of the nearest axis that is parallel to the opening.
    """
    lines = [LineString([axis.start, axis.end]) for axis in axes]
    tree = STRtree(lines)
    added = []
    for opening in openings:
        segment = LineString([opening.start, opening.end])
        way = _unit(segment)
        best = None
        for k in tree.query(segment, predicate="dwithin", distance=1.0):
            other = _unit(lines[k])
            if abs(way[0] * other[1] - way[1] * other[0]) > math.sin(5 * SETTINGS.face_angle):
                continue
            offset = np.array(segment.centroid.coords[0]) - np.array(lines[k].coords[0])
            across = abs(float(offset @ np.array([-other[1], other[0]])))
            key = (round(across, 3), lines[k].distance(segment), int(k))
            if across <= axes[k].thickness / 2 + SETTINGS.overlap and (best is None or key < best):
                best = key
        if best is None:
            continue
        axis, line = axes[best[2]], lines[best[2]]
        start, unit = np.array(line.coords[0]), _unit(line)
        along = sorted(float((np.array(p) - start) @ unit) for p in segment.coords)
        if along[0] >= -1e-6 and along[1] <= line.length + 1e-6:
            continue
        ends = [
            start + at * unit for at in (along[0] - SETTINGS.overlap, along[1] + SETTINGS.overlap)
        ]
        piece = WallAxis(tuple(ends[0].tolist()), tuple(ends[1].tolist()), axis.thickness)
        added.append(piece)
    return added


def rooms_of_outlines(lines: Sequence[LineString], gaps: Sequence[WallAxis]) -> list[Polygon]:
    """Return the floors that walls enclose, where the outlines of the walls' bodies are drawn.

    `gaps` are the pieces of wall through openings, where the outlines are interrupted.
    """
    unique_lines = list({line.wkb: line for line in lines}.values())
    limit_pairs(unique_lines, 0.0, "lines of walls that meet")
    network = unary_union(unique_lines, grid_size=SETTINGS.grid)
    thin = [face for face in polygonize(network) if face.buffer(-SETTINGS.thin / 2).is_empty]
    over = [
        LineString([gap.start, gap.end]).buffer(gap.thickness / 2, cap_style="flat") for gap in gaps
    ]
    solid = unary_union([*thin, *over], grid_size=SETTINGS.grid)
    rooms = [
        Polygon(ring).simplify(2 * SETTINGS.grid)
        for part in getattr(solid, "geoms", [solid])
        for ring in part.interiors
    ]
    return [room for room in rooms if is_floor(room)]


def groups_of_lines(lines: Sequence[LineString]) -> list[Polygon]:
    """Return the boxes around lines that belong together: a leaf and its swing, or panes.

    Lines belong together if they touch, or if they are straight, parallel and side by side.
    """
    if not lines:
        return []
    from scipy.sparse import coo_array  # slow to import (0.3 s); no other format needs it
    from scipy.sparse.csgraph import connected_components

    lines = list({line.wkb: line for line in lines}.values())
    limit_pairs(lines, SETTINGS.panes, "lines of doors and windows side by side")
    tree = STRtree(lines)
    near = tree.query(lines, predicate="dwithin", distance=SETTINGS.panes)
    pairs = [(i, j) for i, j in near.T.tolist() if i < j and _together(lines[i], lines[j])]
    ends = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    links = coo_array((np.ones(len(pairs)), tuple(ends)), shape=(len(lines), len(lines)))
    _, group = connected_components(links, directed=False)
    members: dict[int, list[LineString]] = {}
    for name, line in zip(group.tolist(), lines, strict=True):
        members.setdefault(name, []).append(line)
    groups = []
    for group_lines in members.values():
        area = MultiLineString(group_lines).minimum_rotated_rectangle
        if isinstance(area, LineString):
            area = area.buffer(0.005, cap_style="flat")
        if isinstance(area, Polygon):
            groups.append(area)
    return groups


def _together(one: LineString, other: LineString) -> bool:
    """Return whether two lines belong to one door or window."""
    if one.distance(other) <= SETTINGS.touch:
        return True
    if len(one.coords) != 2 or len(other.coords) != 2 or min(one.length, other.length) < 1e-6:
        return False
    a, b = _unit(one), _unit(other)
    along = (np.array(other.coords) - np.array(one.coords[0])) @ a
    shared = min(along.max(), one.length) - max(along.min(), 0.0)
    parallel = abs(a[0] * b[1] - a[1] * b[0]) <= math.sin(SETTINGS.face_angle)
    return bool(parallel and shared >= SETTINGS.shared * min(one.length, other.length))
