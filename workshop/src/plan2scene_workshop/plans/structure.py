"""The parts of a house that a drawn plan shows: wall bodies, rails and gaps for openings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Point, Polygon

from plan2scene.house import House
from plan2scene.plans.geometry import point_along, ring_edges, room_polygon
from plan2scene_workshop.homes.openings import OPEN_AIR
from plan2scene_workshop.plans.passages import opened_doors

#: Smallest distance in metres between a cut corner and an opening.
_FREE = 0.15


@dataclass(frozen=True)
class Gap:
    """An opening in a wall, as drawn; lengths in metres.

    `start` and `end` (x, z) lie on the middle line of the wall's body, `normal` points into the
    room that a door opens to, `depth` is the body's thickness.
    """

    kind: str  #: door, window or passage
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray
    depth: float
    outer: bool  #: whether outside or open air is on one side

    @property
    def width(self) -> float:
        """Length along the wall in metres."""
        return float(np.linalg.norm(self.end - self.start))

    def corners(self, depth: float | None = None) -> np.ndarray:
        """Return the rectangle (4, 2) that the opening cuts out of the wall."""
        half = self.normal * (depth or self.depth) / 2
        return np.array(
            [self.start - half, self.end - half, self.end + half, self.start + half], np.float64
        )


@dataclass(frozen=True)
class Structure:
    """Rooms, walls and openings of a plan in metres."""

    rooms: tuple[Polygon, ...]  #: outlines along the middle of inner walls
    types: tuple[tuple[str, ...], ...]
    gaps: tuple[Gap, ...]
    inner: shapely.Geometry  #: bodies of the inner walls, without the gaps
    outer: shapely.Geometry  #: bodies of the outer walls, without the gaps
    rails: shapely.Geometry  #: around balconies and terraces
    inner_depth: float
    outer_depth: float

    def indoor(self, index: int) -> bool:
        """Return whether a room is indoors."""
        return self.types[index][0] not in OPEN_AIR


def structure_of(
    house: House,
    rng: np.random.Generator,
    *,
    inner_depth: float,
    outer_depth: float,
    rail_depth: float,
    cut_corners: float,
    opened: float = 0.0,
    windows: bool = True,
) -> Structure:
    """Return the parts of a house that a drawing shows.

    Outer walls lie outside the outlines of the rooms, except for half of an inner wall's
    thickness. Each corner of a room is cut off with probability `cut_corners`, each inner door
    becomes a passage with probability `opened`. Without `windows`, walls are closed there.
    """
    rooms = [room_polygon(room) for room in house.rooms]
    types = tuple(room.types for room in house.rooms)
    spans = [span for span in _spans(house) if windows or span[0] != "window"]
    rooms = _cut_corners(rooms, [span for *_, span in spans], rng, cut_corners)
    if opened:
        spans = opened_doors(spans, rooms, types, rng, opened)
    indoor = shapely.union_all([r for r, t in zip(rooms, types, strict=True) if _inside(t)])
    half = inner_depth / 2
    lines = shapely.union_all([r.exterior for r, t in zip(rooms, types, strict=True) if _inside(t)])
    skin = indoor.buffer(outer_depth - half, join_style="mitre")
    ring = skin.difference(indoor.buffer(-half, join_style="mitre"))
    inner = lines.buffer(half, join_style="mitre", cap_style="square").difference(ring)
    air = [r.exterior for r, t in zip(rooms, types, strict=True) if not _inside(t)]
    rails = shapely.union_all(air).buffer(rail_depth / 2, join_style="mitre").difference(skin)
    depths = (inner_depth, outer_depth, rail_depth)
    gaps = [g for g in (_gap(s, rooms, types, depths, rng) for s in spans) if g is not None]
    holes = shapely.union_all([Polygon(g.corners(g.depth * 1.02 + 0.004)) for g in gaps])
    inner, outer, rails = (body.difference(holes) for body in (inner, ring, rails))
    return Structure(
        tuple(rooms), types, tuple(gaps), inner, outer, rails, inner_depth, outer_depth
    )


def _inside(types: tuple[str, ...]) -> bool:
    return types[0] not in OPEN_AIR


def _spans(house: House) -> list[tuple[str, LineString]]:
    """Return the kind and line of each opening; one in two walls is returned once."""
    found = {}
    for wall in house.walls:
        for hole in wall.openings:
            ends = point_along(wall, hole.start), point_along(wall, hole.end)
            found[hole.id] = (hole.kind, LineString(ends))
    return list(found.values())


def _gap(
    span: tuple[str, LineString],
    rooms: list[Polygon],
    types: tuple[tuple[str, ...], ...],
    depths: tuple[float, float, float],
    rng: np.random.Generator,
) -> Gap | None:
    """Return an opening as drawn; None if a plan does not show it (balcony to outside)."""
    kind, line = span
    start, end = np.array(line.coords)
    along = (end - start) / np.linalg.norm(end - start)
    normal = np.array([-along[1], along[0]])
    middle = (start + end) / 2
    sides = []
    for sign in (1, -1):
        point = Point(middle + sign * 0.05 * normal)
        index = next((i for i, room in enumerate(rooms) if room.contains(point)), None)
        sides.append(None if index is None else _inside(types[index]))
    inner_depth, outer_depth, rail_depth = depths
    if not any(sides):
        if kind == "window" or None in sides:
            return None
        return Gap("passage", start, end, normal, rail_depth, True)
    outer = not all(sides)
    if (outer and not sides[0]) or (not outer and rng.random() < 0.5):
        normal = -normal
    if outer:
        shift = -normal * (outer_depth - inner_depth) / 2
        start, end = start + shift, end + shift
    return Gap(kind, start, end, normal, outer_depth if outer else inner_depth, outer)


def _cut_corners(
    rooms: list[Polygon], spans: list[LineString], rng: np.random.Generator, chance: float
) -> list[Polygon]:
    """Return rooms with some convex corners cut off; the room behind gets the triangle."""
    rooms = list(rooms)
    for index in range(len(rooms)):
        edges = ring_edges(tuple(rooms[index].exterior.coords[:-1]))
        for before, after in zip(edges[-1:] + edges[:-1], edges, strict=True):
            if rng.random() >= chance:
                continue
            leg = float(rng.uniform(0.5, 1.3))
            corner = np.array(after[0])
            arms = np.array([before[0], after[1]]) - corner
            lengths = np.linalg.norm(arms, axis=1)
            if lengths.min() < leg + 0.6:
                continue
            if _cut_corner(rooms, index, corner, arms / lengths[:, None], leg, spans):
                break
    return rooms


def _cut_corner(
    rooms: list[Polygon],
    index: int,
    corner: np.ndarray,
    arms: np.ndarray,
    leg: float,
    spans: list[LineString],
) -> bool:
    """Cut a corner off room `index`, in place; return False if openings or two rooms prevent it.

    `arms` are the unit vectors (2, 2) of the edges that leave the corner, `leg` is in metres.
    """
    triangle = Polygon([corner, *(corner + leg * arms)])
    zone = triangle.buffer(_FREE)
    if not rooms[index].buffer(0.01).contains(triangle) or any(s.intersects(zone) for s in spans):
        return False
    probes = [
        Point(corner + 0.1 * np.array(signs) @ arms) for signs in ((-1, 1), (1, -1), (-1, -1))
    ]
    behind = {next((i for i, room in enumerate(rooms) if room.contains(p)), None) for p in probes}
    if len(behind) != 1:
        return False
    other = behind.pop()
    cut = rooms[index].difference(triangle)
    if isinstance(cut, MultiPolygon):
        return False
    if other is not None:
        grown = rooms[other].union(triangle.buffer(1e-6))
        if isinstance(grown, MultiPolygon):
            return False
        rooms[other] = grown.simplify(1e-4)
    rooms[index] = cut
    return True
