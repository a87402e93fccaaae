"""Rooms out of loose wall lines: join ends, straighten, split at crossings, polygonise (pixels)."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from shapely.geometry import LineString, Point, Polygon
from shapely.ops import polygonize, unary_union

from plan2scene.plans.parse import MAX_ITEMS, MAX_ROOMS, Source
from plan2scene.plans.r2v_text import PixelWall

#: Wall ends nearer than this (pixels) meet; the reference converter's margin.
JOIN_MARGIN = 5.0
#: Faces with less area than this (square pixels) are drawing slack, not rooms.
MIN_FACE = 50.0

Edge = tuple[int, int]


def room_polygons(source: Source, walls: Sequence[PixelWall]) -> tuple[list[Polygon], float]:
    """Return the faces that the walls close, and the length (pixels) of walls that close none.

    Ends within `JOIN_MARGIN` become one node, an end that near to another wall splits it, runs
    of nearly axis-aligned walls are made straight, crossings are split. Corners remain where
    walls meet or turn. Sorted from top to bottom, then left to right. InputError for none, or
    more than a house can have.
    """
    nodes, edges = _join([(wall.start, wall.end) for wall in walls])
    edges = _split_at_nodes(nodes, edges)
    nodes = _straighten(nodes, edges)
    lines = [LineString(nodes[list(edge)]) for edge in edges if edge[0] != edge[1]]
    lines = [line for line in lines if line.length > 0]
    network = unary_union(lines)
    pieces = len(getattr(network, "geoms", [network]))
    if pieces > MAX_ITEMS:
        raise source.fault(f"walls of at most {MAX_ITEMS} pieces between crossings", pieces)
    faces = [face for face in polygonize(network) if face.area >= MIN_FACE]
    if not 1 <= len(faces) <= MAX_ROOMS:
        raise source.fault(f"walls that close 1 to {MAX_ROOMS} rooms", f"{len(faces)} rooms")
    used = unary_union([face.boundary for face in faces])
    degrees = _degrees(used)
    faces = [_drop_flat_corners(face, degrees) for face in faces]
    loose = network.difference(used).length
    faces.sort(key=lambda face: (round(face.bounds[1], 3), round(face.bounds[0], 3)))
    return faces, float(loose)


def _join(segments: Iterable[tuple[tuple[float, float], ...]]) -> tuple[np.ndarray, list[Edge]]:
    """Return nodes (n, 2) and edges; ends within the margin share a node at their mean."""
    points = np.array([end for segment in segments for end in segment], dtype=np.float64)
    group = np.arange(len(points))
    for k, point in enumerate(points):
        near = np.flatnonzero(np.linalg.norm(points - point, axis=1) < JOIN_MARGIN)
        merged = np.isin(group, group[near])
        group[merged] = group[k]
    _, index = np.unique(group, return_inverse=True)
    counts = np.bincount(index)[:, None]
    nodes = np.zeros((len(counts), 2))
    np.add.at(nodes, index, points)
    edges = [(int(index[k]), int(index[k + 1])) for k in range(0, len(points), 2)]
    return nodes / counts, list(dict.fromkeys(tuple(sorted(e)) for e in edges if e[0] != e[1]))  # type: ignore[misc]


def _split_at_nodes(nodes: np.ndarray, edges: list[Edge]) -> list[Edge]:
    """Return the edges cut at every node that lies within the margin of their inside."""
    pieces: dict[Edge, None] = {}
    for a, b in edges:
        direction = nodes[b] - nodes[a]
        length = float(np.linalg.norm(direction))
        along = (nodes - nodes[a]) @ direction / length
        across = np.abs((nodes - nodes[a]) @ np.array([-direction[1], direction[0]]) / length)
        inside = (along > 0) & (along < length) & (across < JOIN_MARGIN)
        inside[[a, b]] = False
        between = [int(k) for k in np.flatnonzero(inside)]
        stops = [a, *sorted(between, key=lambda k: along[k]), b]
        for start, end in pairwise(stops):
            pieces[(min(start, end), max(start, end))] = None
    return list(pieces)


def _straighten(nodes: np.ndarray, edges: list[Edge]) -> np.ndarray:
    """Return the nodes with runs of nearly vertical (horizontal) edges on one x (y)."""
    straight = nodes.copy()
    for axis in (0, 1):
        group = np.arange(len(nodes))
        for a, b in edges:
            off, along = np.abs(nodes[a] - nodes[b])[[axis, 1 - axis]]
            if off < min(JOIN_MARGIN, along):
                group[group == group[b]] = group[a]
        for name in np.unique(group):
            members = group == name
            straight[members, axis] = nodes[members, axis].mean()
    return straight


def _key(point: Sequence[float]) -> tuple[float, float]:
    """Return a point rounded so that equal nodes are equal keys."""
    return (round(point[0], 6), round(point[1], 6))


def _degrees(network: LineString) -> Counter[tuple[float, float]]:
    """Return how many pieces of a noded network meet at each of its points."""
    degrees: Counter[tuple[float, float]] = Counter()
    for line in getattr(network, "geoms", [network]):
        coordinates = list(line.coords)
        for start, end in pairwise(coordinates):
            degrees.update((_key(start), _key(end)))
    return degrees


def _drop_flat_corners(face: Polygon, degrees: Counter[tuple[float, float]]) -> Polygon:
    """Return a face without the points where one straight wall merely goes on."""
    rings = []
    for ring in (face.exterior, *face.interiors):
        points = list(ring.coords)[:-1]
        kept = []
        for k, point in enumerate(points):
            before, after = points[k - 1], points[(k + 1) % len(points)]
            turn = (point[0] - before[0]) * (after[1] - point[1]) - (point[1] - before[1]) * (
                after[0] - point[0]
            )
            scale = math.dist(point, before) * math.dist(after, point)
            if degrees[_key(point)] > 2 or abs(turn) > 1e-3 * scale:
                kept.append(point)
        rings.append(kept)
    return Polygon(rings[0], rings[1:])


def side_labels(face: Polygon, walls: Sequence[PixelWall]) -> dict[str, float]:
    """Return the length (pixels) of walls by the label on their side towards `face`."""
    votes: dict[str, float] = defaultdict(float)
    for wall in walls:
        if wall.labels is None or wall.start == wall.end:
            continue
        line = LineString([wall.start, wall.end])
        near = line.intersection(face.boundary.buffer(JOIN_MARGIN / 2))
        if near.length < min(JOIN_MARGIN, line.length / 2):
            continue
        middle = np.array(near.interpolate(0.5, normalized=True).coords[0])
        direction = np.subtract(wall.end, wall.start) / line.length
        # Left of the direction in a frame with y down.
        left = np.array([direction[1], -direction[0]])
        for label, sign in zip(wall.labels, (1.0, -1.0), strict=True):
            if face.contains(Point(middle + sign * 1.5 * JOIN_MARGIN * left)):
                votes[label] += near.length
    return dict(votes)
