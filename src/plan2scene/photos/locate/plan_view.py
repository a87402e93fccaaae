"""Rays in a room's plan view: how far each one reaches, and which opening it meets.

Directions are azimuths in the plan, ``(x, z) = (sin a, cos a)``, radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from plan2scene.house import House, Opening, Ring, Room, Wall
from plan2scene.photos.locate.locate_settings import LOCATE
from plan2scene.plans.geometry import point_along, ring_edges
from plan2scene.plans.usual_windows import USUAL_WINDOWS, built_area, guesses_windows

#: Kind of a stretch of outer wall that may have windows which the plan does not draw.
UNDRAWN = "undrawn"


@dataclass(frozen=True)
class Hole:
    """An opening on an edge of a room; metres along the edge and above the floor."""

    edge: int
    start: float
    end: float
    bottom: float
    top: float
    kind: str  # of house.OPENING_KINDS, or UNDRAWN
    room_behind: str | None
    opening_id: str = ""


@dataclass(frozen=True)
class RoomShape:
    """Edges of a room's outline and holes, and the openings on them; float64, metres."""

    room_id: str
    height: float
    start: np.ndarray  #: (e, 2), first point (x, z) of each edge
    along: np.ndarray  #: (e, 2), unit vector along it
    length: np.ndarray  #: (e,)
    outward: np.ndarray  #: (e, 2), unit normal out of the room
    holes: tuple[Hole, ...]
    level: str = ""
    #: Length e: id of the room's wall along each edge; empty where there is none.
    walls: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sight:
    """What `n` rays meet: (n,) float64 in metres, (n,) int64 indices."""

    reach: np.ndarray  #: distance to the room's edge
    edge: np.ndarray  #: index of that edge
    at: np.ndarray  #: place along that edge
    hole: np.ndarray  #: index of the room's opening at that place; -1 for none
    beyond: np.ndarray  #: distance to the far edge of the room behind that opening; NaN for none
    beyond_edge: np.ndarray  #: index of that edge; -1 for none
    beyond_hole: np.ndarray  #: index of the opening in that edge, of the room behind; -1 for none
    beyond_height: np.ndarray  #: ceiling height of the room behind; NaN for none

    def of(self, directions: np.ndarray) -> Sight:
        """Return the same for the rays with these indices, which may repeat."""
        return Sight(*(getattr(self, field.name)[directions] for field in fields(self)))


def room_shapes(house: House) -> dict[str, RoomShape]:
    """Return the shape of every room of a house, by id."""
    behind = _rooms_behind(house)
    return {room.id: _room_shape(house, room, behind) for room in house.rooms}


def searched_shapes(house: House) -> dict[str, RoomShape]:
    """Return :func:`room_shapes` with `UNDRAWN` holes in outer walls, for a search.

    They are added only if the house's windows are guesses; otherwise its plan draws all windows.
    """
    shapes = room_shapes(house)
    if not guesses_windows(house):
        return shapes
    for _, storey in house.storeys():
        built = built_area(storey.rooms)
        for room in storey.rooms:
            shape = shapes[room.id]
            if not room.open_air:
                shapes[room.id] = replace(shape, holes=(*shape.holes, *_undrawn(shape, built)))
    return shapes


def _undrawn(shape: RoomShape, built: BaseGeometry) -> Iterator[Hole]:
    """Yield the stretches of a room's edges behind which nothing is built, as `UNDRAWN` holes."""
    for edge, (start, along, length) in enumerate(
        zip(shape.start, shape.along, shape.length, strict=True)
    ):
        first = start + USUAL_WINDOWS.outside * shape.outward[edge]
        behind = LineString([first, first + length * along]).difference(built)
        for part in getattr(behind, "geoms", [behind]):
            ends = np.sort((np.array(part.coords).reshape(-1, 2) - first) @ along)
            if len(ends) and ends[-1] - ends[0] >= USUAL_WINDOWS.width[0]:
                yield Hole(edge, ends[0], ends[-1], 0.0, shape.height, UNDRAWN, None)


def dominant_direction(shape: RoomShape) -> float:
    """Return the angle in [0, pi/2) by which a room's walls are turned from the plan's axes.

    The turn maps azimuth 0 to that of a wall. It is the mean of the walls' azimuths modulo 90
    degrees, weighted by their lengths.
    """
    azimuth = np.arctan2(shape.along[:, 0], shape.along[:, 1])
    mean = np.angle((shape.length * np.exp(4j * azimuth)).sum()) / 4
    turn = float(np.mod(mean, np.pi / 2))
    return 0.0 if np.pi / 2 - turn < 1e-6 else turn


def look(
    shapes: Mapping[str, RoomShape], room_id: str, eyes: np.ndarray, azimuth: np.ndarray
) -> Sight:
    """Return what rays from `eyes` (n, 2) in a room at azimuths (n,) meet."""
    shape = shapes[room_id]
    ways = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    reach, edge, at = _first_exit(shape, eyes, ways, np.zeros(len(eyes)))
    hole = _hole_met(shape, edge, at)
    beyond_edge, beyond_hole = np.full(len(eyes), -1), np.full(len(eyes), -1)
    beyond, beyond_height = np.full(len(eyes), np.nan), np.full(len(eyes), np.nan)
    for index, opening in enumerate(shape.holes):
        met = hole == index
        if not met.any():
            continue
        if opening.room_behind is not None:
            behind = shapes[opening.room_behind]
            exits = _first_exit(behind, eyes[met], ways[met], reach[met] + LOCATE.entry_m)
            beyond[met], beyond_edge[met] = exits[:2]
            beyond_height[met] = behind.height
            beyond_hole[met] = _hole_met(behind, exits[1], exits[2])
    return Sight(reach, edge, at, hole, beyond, beyond_edge, beyond_hole, beyond_height)


def _hole_met(shape: RoomShape, edge: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the index (n,) of the opening that is `at` metres along each edge; -1 for none."""
    met = np.full(len(edge), -1)
    for index, hole in reversed(list(enumerate(shape.holes))):
        met[(edge == hole.edge) & (at > hole.start) & (at < hole.end)] = index
    return met


def _first_exit(
    shape: RoomShape, eyes: np.ndarray, ways: np.ndarray, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return distance, edge and metres along it (n,) where rays first leave a room past `after`."""
    facing = ways @ shape.outward.T
    to_start = shape.start[None] - eyes[:, None]
    away = (to_start * shape.outward).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = away / facing
        at = ((reach[..., None] * ways[:, None] - to_start) * shape.along).sum(axis=2)
    inside = (at >= -1e-6) & (at <= shape.length + 1e-6)
    valid = (facing > 1e-9) & inside & (reach > after[:, None])
    reach = np.where(valid, reach, np.inf)
    edge = np.argmin(reach, axis=1)
    rows = np.arange(len(eyes))
    return np.minimum(reach[rows, edge], LOCATE.far_m), edge, at[rows, edge]


def _room_shape(house: House, room: Room, behind: Mapping[tuple[str, str], str]) -> RoomShape:
    """Return the edges of a room, all with the room on the same side, and its openings."""
    edges = [
        edge
        for number, ring in enumerate(room.rings)
        for edge in ring_edges(_walked(ring, hole=number > 0))
        if math.dist(*edge) > 1e-6
    ]
    start, end = np.array(edges).transpose(1, 0, 2)
    length = np.linalg.norm(end - start, axis=1)
    along = (end - start) / length[:, None]
    outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
    bare = RoomShape(room.id, room.height, start, along, length, outward, (), room.level)
    own = [wall for wall in house.walls if room.id in wall.room_ids]
    return replace(bare, holes=tuple(_holes(house, bare, behind)), walls=_walls_along(bare, own))


def _walked(ring: Ring, *, hole: bool) -> Ring:
    """Return a ring ordered to turn from +x to +z, or from +z to +x if it is a `hole`."""
    area = sum(x0 * z1 - x1 * z0 for (x0, z0), (x1, z1) in ring_edges(ring))
    return ring[::-1] if (area > 0.0) == hole else ring


def _rooms_behind(house: House) -> dict[tuple[str, str], str]:
    """Return the room behind each (room, opening id) of an opening that joins two rooms."""
    behind: dict[tuple[str, str], str] = {}
    for door in house.doors:
        if door.room_b is not None and door.room_b != door.room_a:
            behind.setdefault((door.room_a, door.opening_id), door.room_b)
            behind.setdefault((door.room_b, door.opening_id), door.room_a)
    return behind


def _holes(house: House, shape: RoomShape, behind: Mapping[tuple[str, str], str]) -> list[Hole]:
    """Return the openings on a room's edges: those of its own walls, and others that lead into it.

    Guessed openings are left out.
    """
    holes: list[Hole] = []
    named: set[str] = set()
    own_walls = [wall for wall in house.walls if shape.room_id in wall.room_ids]
    for wall in [*own_walls, *(wall for wall in house.walls if wall not in own_walls)]:
        is_own_wall = shape.room_id in wall.room_ids
        for opening in wall.openings:
            joins = (shape.room_id, opening.id) in behind
            if opening.guessed or opening.id in named or not (is_own_wall or joins):
                continue
            hole = _placed(shape, wall, opening, behind.get((shape.room_id, opening.id)))
            if hole is not None:
                holes.append(hole)
                named.add(opening.id)
    return holes


def _walls_along(shape: RoomShape, walls: Sequence[Wall]) -> tuple[str, ...]:
    """Return the id of the wall that overlaps each edge most; empty where the overlap is small."""
    names = [""] * len(shape.length)
    most = np.zeros(len(shape.length))
    for wall in walls:
        _, at = _on_edges(shape, wall, (0.0, wall.length))
        shared = np.minimum(at[:, 1], shape.length) - np.maximum(at[:, 0], 0.0)
        for edge in np.flatnonzero(shared > np.maximum(most, LOCATE.near_m)):
            names[edge], most[edge] = wall.id, shared[edge]
    return tuple(names)


def _on_edges(
    shape: RoomShape, wall: Wall, span: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance (e,) of a wall's span to each edge, and its ends (e, 2) along the edge.

    In metres; infinite and NaN for edges that are not parallel to the span or not near it.
    """
    ends = np.array([point_along(wall, at) for at in span])
    width = max(float(np.linalg.norm(ends[1] - ends[0])), 1e-9)
    to_ends = ends[None] - shape.start[:, None]
    off = np.abs((to_ends * shape.outward[:, None]).sum(axis=2)).mean(axis=1)
    at = np.sort((to_ends * shape.along[:, None]).sum(axis=2), axis=1)
    parallel = np.abs(shape.along @ (ends[1] - ends[0]) / width)
    there = (parallel > LOCATE.parallel) & (off < LOCATE.near_m + wall.depth)
    return np.where(there, off, np.inf), np.where(there[:, None], at, np.nan)


def _placed(shape: RoomShape, wall: Wall, opening: Opening, room_behind: str | None) -> Hole | None:
    """Return an opening placed on the nearest parallel edge of a room; None if there is none."""
    width = opening.end - opening.start
    if width <= 1e-6:
        return None
    off, at = _on_edges(shape, wall, (opening.start, opening.end))
    shared = np.minimum(at[:, 1], shape.length) - np.maximum(at[:, 0], 0.0)
    fits = shared > 0.3 * width
    if not fits.any():
        return None
    edge = int(np.argmin(np.where(fits, off, np.inf)))
    start, end = max(float(at[edge, 0]), 0.0), min(float(at[edge, 1]), float(shape.length[edge]))
    top = min(opening.top, shape.height)
    span = start, end, opening.bottom, top
    return Hole(edge, *span, opening.kind, room_behind, opening.id)
