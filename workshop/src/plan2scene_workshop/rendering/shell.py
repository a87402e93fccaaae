"""The shell of a room: floor, ceiling, wall faces with holes for openings, reveals, skirting.

A room's polygon runs along the middle of its walls; the visible face of a wall lies half a
thickness inside it. Reveals join the faces of the two rooms through an opening.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely

from plan2scene.house import House, Room, SurfaceKey, Wall
from plan2scene.mesh.polygons import triangulate
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import (
    FaceOpening,
    Frame,
    arc_offset,
    inner_normal,
    openings_on,
    reveal_quads,
    walked_rings,
    wall_frame,
)
from plan2scene_workshop.rendering.geometry import Array, Colour, Geometry, Solid, box, quad

#: A wall's end that is closer than this to a corner of the room is at the corner, metres.
CORNER_TOLERANCE = 0.02
#: Distance in metres by which reveals of an outer wall extend beyond the room's polygon.
OUTER_REVEAL = 0.16
SKIRTING_HEIGHT, SKIRTING_DEPTH = 0.08, 0.012


@dataclass(frozen=True)
class WallFace:
    """The inner side of a wall in one room; metres."""

    room_id: str
    wall: Wall
    plane: Frame  #: the visible face, half the wall's thickness inside the room's outline
    height: float
    inset: float  #: distance from the outline to the face
    outer: bool  #: no room lies on the other side
    u_start: float  #: start of this face along the room's walls, so that textures continue
    openings: tuple[FaceOpening, ...]

    @property
    def length(self) -> float:
        """Length in metres."""
        return self.plane.length

    def at(self, along: float, y: float, out: float = 0.0) -> Array:
        """Return the world point `along` from the left end, at height `y`, `out` into the room."""
        x, z = self.plane.plan(along, out)
        return np.array([x, y, z])

    def frame(self, along: float, y: float = 0.0, out: float = 0.0) -> Array:
        """Return the 4x4 frame at a point of the face: x along it, y up, z into the room."""
        matrix = np.eye(4)
        matrix[:3] = self.plane.axes(along, out).T
        matrix[1, 3] = y
        return matrix


def wall_faces(house: House, room: Room) -> tuple[WallFace, ...]:
    """Return the faces of the room's walls, in the order of its outline's edges."""
    polygon = room_polygon(room)
    others = [room_polygon(other) for other in house.rooms if other.id != room.id]
    edges = shapely.linestrings([e for ring in walked_rings(room) for e in pairwise(ring)])
    faces = []
    for wall in house.walls_of(room.id):
        line = wall_frame(wall, inner_normal(wall, polygon))
        middle = shapely.Point(*line.plan(line.length / 2))
        faces.append(
            (int(shapely.distance(edges, middle).argmin()), _face(room, wall, line, others))
        )
    return tuple(face for _, face in sorted(faces, key=lambda item: item[0]))


def _face(room: Room, wall: Wall, line: Frame, others: list[shapely.Polygon]) -> WallFace:
    """Return the face in front of a wall's line; corners of the room shift its ends."""
    inset = wall.depth / 2
    ends = line.plan(np.array([0.0, line.length]))
    begin, cut = (inset * _corner(room, end) for end in ends)
    length = line.length - begin - cut
    plane = Frame(line.plan(begin, inset), line.right, line.normal, length)
    openings = []
    for hole in openings_on(wall, line):
        left, right = max(hole.left - begin, 0.0), min(hole.right - begin, length)
        if right - left > 0.05:
            openings.append(replace(hole, left=left, right=right))
    behind = shapely.Point(*line.plan(line.length / 2, -inset - 0.02))
    outer = len(wall.room_ids) < 2 and not any(other.contains(behind) for other in others)
    height = min(wall.height, room.height)
    u_start = arc_offset(room, plane)
    return WallFace(room.id, wall, plane, height, inset, outer, u_start, tuple(openings))


def _corner(room: Room, point: Array) -> float:
    """Return how much an inset of 1 shortens a wall at this end (0: no corner)."""
    for ring in walked_rings(room):
        distance = np.hypot(*(ring[:-1] - point).T)
        k = int(distance.argmin())
        if distance[k] < CORNER_TOLERANCE:
            before, after = ring[k] - ring[k - 1 if k else -2], ring[k + 1] - ring[k]
            size = float(np.hypot(*before) * np.hypot(*after))
            sine = before[0] * after[1] - before[1] * after[0]
            return float(sine / max(size + before @ after, 1e-6 * size))  # tan(turn / 2)
    return 0.0


def add_wall_face(
    geometry: Geometry, face: WallFace, material: str, plane: int, trim: Colour
) -> None:
    """Add a face with its holes, its reveals and its skirting board (painted `trim`)."""
    holes = shapely.unary_union(
        [shapely.box(o.left, o.bottom, o.right, o.top) for o in face.openings]
    )
    points, faces = triangulate(shapely.box(0.0, 0.0, face.length, face.height).difference(holes))
    normal = np.array([face.plane.normal[0], 0.0, face.plane.normal[1]])
    uv = np.stack([face.u_start + points[:, 0], face.height - points[:, 1]], -1)
    solid = Solid(face.plane.world(points), np.tile(normal, (len(points), 1)), uv, faces)
    geometry.add(material, solid, label=WALL, plane=plane)
    bottom = shapely.LineString([(0.0, SKIRTING_HEIGHT), (face.length, SKIRTING_HEIGHT)])
    for line in shapely.get_parts(bottom.difference(holes)):
        if line.length > 1e-6:
            a, _, b, _ = line.bounds
            board = box((a, 0, 0), (b, SKIRTING_HEIGHT, SKIRTING_DEPTH)).moved(face.frame(0))
            geometry.add("paint", board, colour=trim, label=WALL)
    reach = face.inset + (OUTER_REVEAL if face.outer else 0.0)
    for hole in face.openings:
        back = face.plane.plan(np.array([hole.left, hole.right]), -reach)
        left, right, head, sill = reveal_quads(face.plane, hole, back)
        sides = [left, right, np.roll(head, -1, axis=0)]  # the head's texture runs along the wall
        for corners in sides + ([sill] if hole.bottom > 0.0 else []):
            side = quad(corners[3], corners[2] - corners[3], corners[0] - corners[3])
            geometry.add(material, side, label=WALL)


def flat_solid(polygon: shapely.Polygon, y: float, *, up: bool) -> Solid:
    """Return the polygon as a floor (`up`) or ceiling at height `y`; UV = (x, z) in metres."""
    points, faces = triangulate(polygon)
    # a counter-clockwise polygon in (x, z) faces downwards in a right-handed frame with y up
    faces = faces[:, ::-1] if up else faces
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
        x, z = face.plane.normal.tolist()
        offset = float(face.plane.normal @ face.plane.left)
        planes.append(Plane(SurfaceKey(room.id, "wall"), (x, 0.0, z), offset))
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

    `wall_materials` gives the materials of accent walls by wall id; others have the room's.
    """
    polygon = room_polygon(room)
    floor, ceiling = flat_solid(polygon, 0.0, up=True), flat_solid(polygon, room.height, up=False)
    geometry.add(f"{room.id}/floor", floor, label=FLOOR, plane=first_plane)
    geometry.add(f"{room.id}/ceiling", ceiling, label=CEILING, plane=first_plane + 1)
    for index, face in enumerate(faces):
        material = wall_materials.get(face.wall.id, f"{room.id}/wall")
        add_wall_face(geometry, face, material, first_plane + 2 + index, trim)
