"""From labels of pixels to openings on the walls of the traced rooms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from plan2scene.plans.geometry import ring_edges
from plan2scene_app.tracing.regions import Regions, labels_at
from plan2scene_app.tracing.settings import OPENINGS, PASSAGE, ROOM, SETTINGS


@dataclass(frozen=True)
class TracedOpening:
    """An opening between `start` and `end` (pixels x, y), on the outline of room `room`."""

    kind: str
    start: tuple[float, float]
    end: tuple[float, float]
    room: int
    other: int  #: room behind it; 0: outside
    confidence: float  #: mean probability of its label
    full: bool = False  #: whether it reaches the ceiling, as no wall is drawn between the rooms

    @property
    def width(self) -> float:
        """Width in pixels."""
        return float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))


@dataclass(frozen=True)
class Edge:
    """An edge of a room's outline, pixels (x, y), with unit vectors along it and into the room."""

    room: int
    start: np.ndarray
    way: np.ndarray
    length: float
    inwards: np.ndarray

    def place(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates of points (n, 2): along the edge, and off it (inwards)."""
        apart = points - self.start
        return apart @ self.way, apart @ self.inwards

    def distance(self, point: np.ndarray) -> float:
        """Return the distance from a point (2,) to the edge."""
        (along,), (off,) = self.place(point[None])
        return float(np.hypot(off, max(-along, along - self.length, 0.0)))


def find_openings(
    regions: Regions, polygons: dict[int, Polygon], probabilities: np.ndarray
) -> list[TracedOpening]:
    """Return the openings of traced rooms; one between two rooms lies on the edge of either."""
    edges = edges_of(polygons)
    openings: list[TracedOpening] = []
    for label, kind in OPENINGS.items():
        places, count = _apart(regions.structure == label, 1.5 * regions.wall_px + 2)
        for number, box in enumerate(ndimage.find_objects(places, count), start=1):
            rows, columns = np.nonzero(places[box] == number)
            if len(rows) < SETTINGS.opening * regions.ppm:
                continue
            points = np.c_[columns + box[1].start, rows + box[0].start].astype(float)
            sure = float(probabilities[label][box][places[box] == number].mean())
            opening = _on_edge(edges, points, kind, sure, regions, polygons)
            if opening is not None:
                openings.append(opening)
    openings += _undrawn_passages(edges, regions, polygons, openings)
    return joined(openings, regions.ppm)


def _apart(drawn: np.ndarray, thick: float) -> tuple[np.ndarray, int]:
    """Return the connected components (h, w) of `drawn`, numbered from 1, and their count.

    A component wider than `thick` pixels along x and y is two doors that meet in a corner: the
    pixels in longer runs along x are parted from those in longer runs along y.
    """
    places, count = ndimage.label(drawn, np.ones((3, 3)))
    for number, box in enumerate(ndimage.find_objects(places, count), start=1):
        if min(s.stop - s.start for s in box) <= thick:
            continue
        component = places[box] == number
        upright = component & (_runs(component) < _runs(component.T).T)
        pieces, more = ndimage.label(upright, np.ones((3, 3)))
        places[box][upright] = pieces[upright] + count
        flat, flat_count = ndimage.label(component & ~upright, np.ones((3, 3)))
        places[box][component & ~upright] = flat[component & ~upright] + count + more
        count += more + flat_count
    kept = np.bincount(places.ravel()) > 0
    return (np.cumsum(kept) - 1)[places], int(kept.sum()) - 1


def _runs(drawn: np.ndarray) -> np.ndarray:
    """Return for each pixel the length of its run in its row."""
    lengths = np.zeros(drawn.shape, np.int32)
    for row, line in zip(lengths, drawn, strict=True):
        edges = np.flatnonzero(np.diff(np.r_[0, line.astype(np.int8), 0]))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            row[start:stop] = stop - start
    return lengths


def edges_of(polygons: Mapping[int, Polygon]) -> list[Edge]:
    """Return the edges of all outlines."""
    edges = []
    for number, polygon in polygons.items():
        ring = tuple(polygon.exterior.coords[:-1])
        clockwise = not polygon.exterior.is_ccw
        for a, b in ring_edges(ring):
            start, end = np.array(a), np.array(b)
            length = float(np.linalg.norm(end - start))
            way = (end - start) / max(length, 1e-9)
            inwards = np.array([way[1], -way[0]]) * (1 if clockwise else -1)
            edges.append(Edge(number, start, way, length, inwards))
    return edges


def edge_of(opening: TracedOpening, edges: list[Edge]) -> Edge:
    """Return the edge of its room that an opening is on."""
    middle = (np.array(opening.start) + opening.end) / 2
    own = (edge for edge in edges if edge.room == opening.room)
    return min(own, key=lambda edge: edge.distance(middle))


def within_walls(
    openings: Sequence[TracedOpening], polygons: Mapping[int, Polygon], most: float
) -> list[TracedOpening]:
    """Return openings, shortened where a wall of their rooms ends up to `most` pixels before."""
    edges = edges_of(polygons)
    shortened = []
    for opening in openings:
        ends = np.array([opening.start, opening.end])
        for room in sorted({opening.room, opening.other} & polygons.keys()):
            edge = edge_of(replace(opening, room=room), edges)
            along, _ = edge.place(ends)
            beyond = np.clip(along, 0.0, edge.length) - along
            if abs(np.ptp(along)) > 0.9 * opening.width and np.abs(beyond).max() <= most:
                ends = ends + beyond[:, None] * edge.way
        start, end = ((float(x), float(y)) for x, y in ends)
        shortened.append(replace(opening, start=start, end=end))
    return shortened


def _on_edge(
    edges: list[Edge],
    points: np.ndarray,
    kind: str,
    sure: float,
    regions: Regions,
    polygons: dict[int, Polygon],
) -> TracedOpening | None:
    """Return the opening that pixels form on the nearest edge of their direction, if any."""
    centre = points.mean(0)
    spread = np.cov((points - centre).T) + 1e-6 * np.eye(2)
    values, vectors = np.linalg.eigh(spread)
    longish = values[1] > 2.5 * values[0]
    best, nearest = None, SETTINGS.off_wall * regions.ppm + regions.wall_px
    reach = float(np.linalg.norm(points - centre, axis=1).max())
    for edge in edges:
        if longish and abs(edge.way @ vectors[:, 1]) < 0.9:
            continue
        if abs((centre - edge.start) @ edge.inwards) - reach >= nearest:
            continue
        along, off = edge.place(points)
        covered = np.mean((along > 0) & (along < edge.length))
        distance = abs(float(np.median(off))) + float(1 - covered) * regions.ppm
        if distance < nearest:
            best, nearest = edge, distance
    if best is None:
        return None
    along, _ = best.place(points)
    low, high = np.percentile(along, [1.5, 98.5]) + (-0.5, 0.5)
    low, high = max(0.0, float(low)), min(best.length, float(high))
    if high - low < SETTINGS.opening * regions.ppm:
        return None
    return _opening(best, low, high, kind, sure, polygons, regions)


def _opening(
    edge: Edge,
    low: float,
    high: float,
    kind: str,
    sure: float,
    polygons: dict[int, Polygon],
    regions: Regions,
) -> TracedOpening:
    """Return the opening between two positions, `low` and `high`, along an edge."""
    start, end = edge.start + low * edge.way, edge.start + high * edge.way
    beyond = (start + end) / 2 - edge.inwards * max(2.0, 0.1 * regions.ppm)
    x, y = np.round(beyond).astype(int)
    h, w = regions.rooms.shape
    other = int(regions.rooms[min(max(y, 0), h - 1), min(max(x, 0), w - 1)])
    other = other if other in polygons and other != edge.room else 0
    ends = [(float(p[0]), float(p[1])) for p in (start, end)]
    return TracedOpening(kind, ends[0], ends[1], edge.room, other, sure)


def _undrawn_passages(
    edges: list[Edge],
    regions: Regions,
    polygons: dict[int, Polygon],
    known: list[TracedOpening],
) -> list[TracedOpening]:
    """Return passages where floor goes on from one room to the next without a wall.

    Where a `known` door or window is, there is none: its wall exists, but is too faint. A known
    passage may be a part of one. Floor narrower than `SETTINGS.open_beside` on either side, as of
    a cupboard along a wall, does not count.
    """
    beside = SETTINGS.open_beside * regions.ppm
    doors_and_windows = [opening for opening in known if opening.kind != OPENINGS[PASSAGE]]
    passages = []
    for edge in edges:
        if edge.length < SETTINGS.open_floor * regions.ppm:
            continue
        steps = np.arange(0.5, edge.length, 1.0)
        line = edge.start + steps[:, None] * edge.way
        across = np.arange(-beside, beside + 0.5)[:, None, None] * edge.inwards
        is_open = np.isin(labels_at(regions, line + across), (ROOM, PASSAGE))
        runs, count = ndimage.label(is_open.all(axis=0))
        for (run,) in ndimage.find_objects(runs, count):
            low, high = float(steps[run.start]) - 0.5, float(steps[run.stop - 1]) + 0.5
            if high - low < SETTINGS.open_floor * regions.ppm:
                continue
            opening = _opening(edge, low, high, OPENINGS[PASSAGE], 0.5, polygons, regions)
            if opening.other > edge.room and not any(_same(opening, o) for o in doors_and_windows):
                blank = float((labels_at(regions, line[run]) == ROOM).mean())
                wide = opening.width >= SETTINGS.open_room * regions.ppm
                passages.append(replace(opening, full=wide and blank >= SETTINGS.open_blank))
    return passages


def _same(one: TracedOpening, other: TracedOpening) -> bool:
    """Return whether two openings overlap on one wall."""
    middle = (np.array(other.start) + other.end) / 2
    start, end = np.array(one.start), np.array(one.end)
    way = (end - start) / max(one.width, 1e-9)
    along = float((middle - start) @ way)
    off = abs(float((middle - start) @ np.array([-way[1], way[0]])))
    return -other.width / 2 < along < one.width + other.width / 2 and off < min(
        one.width / 4, other.width / 2
    )


def joined(openings: list[TracedOpening], ppm: float) -> list[TracedOpening]:
    """Return openings, largest first; those of one kind in one line and hardly apart are joined."""
    kept: list[TracedOpening] = []
    for opening in sorted(openings, key=lambda o: -o.width):
        for k, other in enumerate(kept):
            joined = _union(other, opening, SETTINGS.joined * ppm)
            if joined is not None:
                kept[k] = joined
                break
        else:
            kept.append(opening)
    return kept


def _union(one: TracedOpening, other: TracedOpening, gap: float) -> TracedOpening | None:
    """Return two openings as one, or None if they lie apart.

    Of two different kinds, the first is kept if it covers more than half of the other.
    """
    start, end = np.array(one.start), np.array(one.end)
    way = (end - start) / max(one.width, 1e-9)
    ends = [(np.array(p) - start) for p in (other.start, other.end)]
    along = sorted(float(p @ way) for p in ends)
    off = max(abs(float(p @ np.array([-way[1], way[0]]))) for p in ends)
    if off > gap / 2 or along[0] > one.width + gap or along[1] < -gap:
        return None
    overlap = min(along[1], one.width) - max(along[0], 0.0)
    if one.kind != other.kind:
        return one if overlap > 0.5 * other.width else None
    low, high = min(0.0, along[0]), max(one.width, along[1])
    a, b = start + low * way, start + high * way
    return replace(
        one,
        start=(float(a[0]), float(a[1])),
        end=(float(b[0]), float(b[1])),
        other=one.other or other.other,
        confidence=max(one.confidence, other.confidence),
    )
