"""The shell of a room: floor, ceiling, wall faces with their openings cut, reveals, skirting.

A room's polygon runs along the middle of its walls; the visible face of a wall lies half a
thickness inside it. Reveals join the faces of the two rooms through an opening.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import mapbox_earcut
import numpy as np
import shapely

from plan2scene.house import House, Opening, Room, SurfaceKey, Wall
from plan2scene_workshop.rendering.geometry import (
    CEILING,
    FLOOR,
    WALL,
    Array,
    Colour,
    Geometry,
    Solid,
    box,
    quad,
)

#: Wall faces closer than this to an edge of the room's polygon lie on it, metres.
EDGE_TOLERANCE = 0.02
#: How far reveals of an outer wall reach beyond the polygon, metres.
OUTER_REVEAL = 0.16
SKIRTING_HEIGHT, SKIRTING_DEPTH = 0.08, 0.012


@dataclass(frozen=True)
class FaceOpening:
    """An opening as seen on one face: metres from the face's left end, and above the floor."""

    opening: Opening
    left: float
    right: float
    bottom: float
    top: float


@dataclass(frozen=True)
class WallFace:
    """The inner side of a wall in one room, left to right as seen from inside the room.

    Attributes
    ----------
    left : (2,) float64
        Left end (x, z) on the visible face, metres.
    right_direction, inward : (2,) float64
        Unit vectors along the face and into the room.
    length, height : float
    inset : float
        Distance from the polygon's line to the face.
    outer : bool
        No room lies on the other side.
    u_start : float
        Metres along the room's walls where this face begins, for continuous texture.
    """

    room_id: str
    wall: Wall
    left: Array
    right_direction: Array
    inward: Array
    length: float
    height: float
    inset: float
    outer: bool
    u_start: float
    openings: tuple[FaceOpening, ...]

    def at(self, along: float, y: float, out: float = 0.0) -> Array:
        """Return the world point `along` from the left end, at height `y`, `out` into the room."""
        x, z = self.left + self.right_direction * along + self.inward * out
        return np.array([x, y, z])

    def frame(self, along: float, y: float = 0.0, out: float = 0.0) -> Array:
        """Return the 4x4 frame at a point of the face: x along it, y up, z into the room."""
        matrix = np.eye(4)
        matrix[[0, 2], 0] = self.right_direction
        matrix[[0, 2], 2] = self.inward
        matrix[:3, 3] = self.at(along, y, out)
        return matrix


def room_polygon(room: Room) -> shapely.Polygon:
    """Return the room's polygon in (x, z), metres."""
    return shapely.Polygon(room.rings[0], [list(ring) for ring in room.rings[1:]])


def wall_faces(house: House, room: Room) -> tuple[WallFace, ...]:
    """Return the faces of the room's walls, ring by ring."""
    polygon = room_polygon(room)
    others = [room_polygon(other) for other in house.rooms if other.id != room.id]
    walls = tuple(house.walls_of(room.id))
    faces: list[WallFace] = []
    for ring in room.rings:
        points = np.array(ring, float)
        u = 0.0
        for i in range(len(points)):
            edge = _Edge.of(points, i, polygon)
            for wall in walls:
                face = _face_on_edge(room, wall, edge, others, u)
                if face is not None:
                    faces.append(face)
            u += edge.length
    return tuple(faces)


@dataclass(frozen=True)
class _Edge:
    """Edge of a ring, oriented left to right as seen from inside, with its neighbours' turns."""

    left: Array
    direction: Array
    inward: Array
    length: float
    turns: tuple[float, float]  # how much one unit of inset shortens the left and right end

    @classmethod
    def of(cls, points: Array, i: int, polygon: shapely.Polygon) -> _Edge:
        n = len(points)
        before, start, end, after = (points[(i + k) % n] for k in (-1, 0, 1, 2))
        delta = end - start
        length = float(np.hypot(*delta))
        direction = delta / length
        inward = np.array([-direction[1], direction[0]])
        probe = (start + end) / 2 + inward * 1e-3
        if not polygon.contains(shapely.Point(*probe)):
            inward = -inward
        first, last = (
            _turn(start - before, direction, inward),
            _turn(after - end, direction, inward),
        )
        turns = (first[0], last[1])
        right = np.array([inward[1], -inward[0]])
        if float(direction @ right) > 0:
            return cls(start, direction, inward, length, turns)
        return cls(end, -direction, inward, length, (turns[1], turns[0]))


def _turn(neighbour: Array, direction: Array, inward: Array) -> tuple[float, float]:
    """Return by how much a unit inset of both edges shortens this edge, before and after it."""
    neighbour = neighbour / max(float(np.hypot(*neighbour)), 1e-9)
    cross = float(neighbour @ inward)
    dot = float(neighbour @ direction)
    shortening = 0.0 if abs(cross) < 1e-6 else (1 - dot) / abs(cross)
    # an edge that comes from inside the room's side turns convex: the face gets shorter
    return (shortening * -np.sign(cross), shortening * np.sign(cross))


def _face_on_edge(
    room: Room, wall: Wall, edge: _Edge, others: list[shapely.Polygon], u: float
) -> WallFace | None:
    ends = np.array([wall.start, wall.end], float) - edge.left
    if np.abs(ends @ edge.inward).max() > EDGE_TOLERANCE:
        return None
    along = ends @ edge.direction
    low, high = float(along.min()), float(along.max())
    if min(high, edge.length) - max(low, 0.0) < EDGE_TOLERANCE:
        return None
    inset = wall.depth / 2
    begin = edge.turns[0] * inset if low < EDGE_TOLERANCE else low
    finish = edge.length - edge.turns[1] * inset if high > edge.length - EDGE_TOLERANCE else high
    sign, origin = (1.0, along[0]) if along[1] > along[0] else (-1.0, along[0])
    openings = []
    for opening in wall.openings:
        a, b = sorted((origin + sign * opening.start, origin + sign * opening.end))
        a, b = max(a, begin) - begin, min(b, finish) - begin
        if b - a > 0.05:
            openings.append(
                FaceOpening(opening, a, b, max(opening.bottom, 0.0), min(opening.top, wall.height))
            )
    middle = edge.left + edge.direction * (low + high) / 2 - edge.inward * (inset + 0.02)
    outer = len(wall.room_ids) < 2 and not any(
        other.contains(shapely.Point(*middle)) for other in others
    )
    return WallFace(
        room.id,
        wall,
        edge.left + edge.direction * begin + edge.inward * inset,
        edge.direction,
        edge.inward,
        finish - begin,
        min(wall.height, room.height),
        inset,
        outer,
        u + begin,
        tuple(openings),
    )


def _cells(face: WallFace) -> Iterator[tuple[float, float, float, float]]:
    """Yield rectangles (left, right, bottom, top) that cover the face less its openings."""
    cuts = sorted({0.0, face.length, *(v for o in face.openings for v in (o.left, o.right))})
    for left, right in itertools.pairwise(cuts):
        if right - left < 1e-6:
            continue
        middle = (left + right) / 2
        level = 0.0
        holes = sorted((o.bottom, o.top) for o in face.openings if o.left < middle < o.right)
        for bottom, top in [*holes, (face.height, face.height)]:
            if bottom - level > 1e-6:
                yield left, right, level, bottom
            level = max(level, top)


def add_wall_face(
    geometry: Geometry, face: WallFace, material: str, plane: int, trim: Colour
) -> None:
    """Add a face with its holes, its reveals and its skirting board (painted `trim`)."""
    right = np.array([face.right_direction[0], 0.0, face.right_direction[1]])
    for a, b, bottom, top in _cells(face):
        solid = quad(
            face.at(a, top),
            right * (b - a),
            np.array([0.0, bottom - top, 0.0]),
            (face.u_start + a, face.height - top),
        )
        geometry.add(material, solid, label=WALL, plane=plane)
        if bottom == 0.0 and top > SKIRTING_HEIGHT:
            board = box((a, 0, 0), (b, SKIRTING_HEIGHT, SKIRTING_DEPTH)).moved(face.frame(0))
            geometry.add("paint", board, colour=trim, label=WALL)
    reach = face.inset + (OUTER_REVEAL if face.outer else 0.0)
    outward = -np.array([face.inward[0], 0.0, face.inward[1]]) * reach
    for hole in face.openings:
        for solid in _reveal(face, hole, right, outward):
            geometry.add(material, solid, label=WALL)


def _reveal(face: WallFace, hole: FaceOpening, right: Array, outward: Array) -> Iterator[Solid]:
    """Yield the sides of the hole through the wall."""
    down = np.array([0.0, hole.bottom - hole.top, 0.0])
    across = right * (hole.right - hole.left)
    yield quad(face.at(hole.left, hole.top), outward, down)
    yield quad(face.at(hole.right, hole.top) + outward, -outward, down)
    yield quad(face.at(hole.left, hole.top), across, outward)
    if hole.bottom > 0.0:
        yield quad(face.at(hole.left, hole.bottom) + outward, across, -outward)


def flat_solid(polygon: shapely.Polygon, y: float, *, up: bool) -> Solid:
    """Return the polygon as a floor (`up`) or ceiling at height `y`; UV = (x, z) in metres."""
    rings = [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    points = np.concatenate(rings)
    ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
    faces = mapbox_earcut.triangulate_float64(points, ends).reshape(-1, 3).astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    # (x, z) counter-clockwise is downwards in a right-handed frame with y up
    wrong = (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0] > 0) == up
    faces[wrong] = faces[wrong][:, ::-1]
    vertices = np.stack([points[:, 0], np.full(len(points), y), points[:, 1]], -1)
    normals = np.tile([0.0, 1.0 if up else -1.0, 0.0], (len(points), 1))
    return Solid(vertices, normals, points, faces)


@dataclass(frozen=True)
class Plane:
    """A labelled plane: points X with normal . X = offset, the normal points into the room."""

    key: SurfaceKey
    normal: tuple[float, float, float]
    offset: float


def room_planes(room: Room, faces: tuple[WallFace, ...]) -> tuple[Plane, ...]:
    """Return the planes of the floor, the ceiling, then each wall face in order."""
    planes = [
        Plane(SurfaceKey(room.id, "floor"), (0.0, 1.0, 0.0), 0.0),
        Plane(SurfaceKey(room.id, "ceiling"), (0.0, -1.0, 0.0), -room.height),
    ]
    for face in faces:
        normal = (float(face.inward[0]), 0.0, float(face.inward[1]))
        planes.append(Plane(SurfaceKey(room.id, "wall"), normal, float(face.inward @ face.left)))
    return tuple(planes)


def add_room_shell(
    geometry: Geometry,
    room: Room,
    faces: tuple[WallFace, ...],
    first_plane: int,
    wall_materials: dict[str, str],
    trim: Colour,
) -> None:
    """Add floor, ceiling and walls; planes are numbered as in :func:`room_planes`.

    `wall_materials` names another material than the room's for some wall ids (accent walls).
    """
    polygon = room_polygon(room)
    floor, ceiling = flat_solid(polygon, 0.0, up=True), flat_solid(polygon, room.height, up=False)
    geometry.add(f"{room.id}/floor", floor, label=FLOOR, plane=first_plane)
    geometry.add(f"{room.id}/ceiling", ceiling, label=CEILING, plane=first_plane + 1)
    for index, face in enumerate(faces):
        material = wall_materials.get(face.wall.id, f"{room.id}/wall")
        add_wall_face(geometry, face, material, first_plane + 2 + index, trim)
