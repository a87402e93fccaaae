"""The data model: a house as rooms, walls, openings and surfaces, in metres.

Plan coordinates are (x, z) in metres of a right-handed frame with y up, as in scene.json
(``docs/conventions.md``). The classes are frozen; readers validate once
(:func:`plan2scene.floorplans.validate_house`), everything after trusts them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

#: Longest id, so that file names built from it stay legal.
MAX_ID_LENGTH = 150
#: Room types in the order of the paper's room-type flags.
ROOM_TYPES = (
    "Reception",
    "Bedroom",
    "Kitchen",
    "Bathroom",
    "Outdoor",
    "Unknown",
    "Closet",
    "Corridor",
    "Staircase",
    "Entrance",
    "Terrace",
    "Balcony",
)
#: Types of rooms without a roof.
OPEN_AIR = frozenset({"Outdoor", "Terrace", "Balcony"})
#: Surface kinds of a room, in the order of the propagation network's blocks.
SURFACES = ("floor", "wall", "ceiling")
#: Substances in the order of the substance head's logits.
SUBSTANCES = ("wood", "plaster", "carpet", "tile")
#: Height in metres of a room whose plan gives none.
DEFAULT_HEIGHT = 2.8
#: Kinds of opening. A passage is a door-sized or wider hole without a leaf.
OPENING_KINDS = ("door", "window", "passage")

Point = tuple[float, float]  #: (x, z) in metres
Ring = tuple[Point, ...]  #: closed polygon ring, first point not repeated


class SurfaceKey(NamedTuple):
    """Names one texturable surface of a house: all walls of a room share one."""

    room_id: str
    surface: str

    @property
    def filename(self) -> str:
        """Stem of the texture file of this surface."""
        return f"{self.room_id}_{self.surface}"


@dataclass(frozen=True)
class Opening:
    """A hole in a wall: metres along the wall from its first point, and metres above the floor."""

    id: str
    kind: str  # one of OPENING_KINDS
    start: float
    end: float
    bottom: float
    top: float


@dataclass(frozen=True)
class Wall:
    """A straight wall of one room (or two that share it) from `start` to `end`.

    `room_ids[0]` is the room on the inner side (the first material of scene.json); a second id
    is the room on the other side. The segment is the line of the rooms' polygons, `depth` the
    wall's thickness in metres.
    """

    id: str
    room_ids: tuple[str, ...]
    start: Point
    end: Point
    height: float
    depth: float = 0.1
    extra_height: float = 0.035
    openings: tuple[Opening, ...] = ()

    @property
    def length(self) -> float:
        """Length in metres."""
        return float(
            ((self.end[0] - self.start[0]) ** 2 + (self.end[1] - self.start[1]) ** 2) ** 0.5
        )


@dataclass(frozen=True)
class Room:
    """A room: its types (several for open plan), outline and height in metres.

    `rings[0]` is the outline, further rings are holes.
    """

    id: str
    types: tuple[str, ...]
    rings: tuple[Ring, ...]
    height: float

    @property
    def open_air(self) -> bool:
        """Whether the room has no roof: a balcony, terrace or yard."""
        return bool(self.types) and OPEN_AIR.issuperset(self.types)

    def surface_keys(self) -> tuple[SurfaceKey, ...]:
        """Return the floor, wall and ceiling key of this room."""
        return tuple(SurfaceKey(self.id, surface) for surface in SURFACES)


@dataclass(frozen=True)
class Door:
    """A room-door-room relation: `room_b` is None for a door to the outside."""

    room_a: str
    opening_id: str
    room_b: str | None


@dataclass(frozen=True)
class PlacedObject:
    """An object model placed by scene.json; `transform` is 16 numbers, column-major."""

    model_id: str
    index: int
    parent_index: int
    transform: tuple[float, ...]


@dataclass(frozen=True)
class IconBox:
    """Box of an icon drawn in the plan: corners (x, z) in metres."""

    type: str
    p1: Point
    p2: Point


@dataclass(frozen=True)
class House:
    """A whole plan. `doors` holds each relation once (not both directions)."""

    id: str
    rooms: tuple[Room, ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...] = ()
    objects: tuple[PlacedObject, ...] = ()
    icons: tuple[IconBox, ...] = ()
    warnings: tuple[str, ...] = field(default=(), compare=False)

    def room(self, room_id: str) -> Room:
        """Return the room of that id (KeyError when there is none)."""
        for room in self.rooms:
            if room.id == room_id:
                return room
        raise KeyError(room_id)

    def walls_of(self, room_id: str) -> Iterator[Wall]:
        """Yield the walls that bound a room."""
        return (wall for wall in self.walls if room_id in wall.room_ids)

    def surface_keys(self) -> tuple[SurfaceKey, ...]:
        """Return every surface key of the house, room by room."""
        return tuple(key for room in self.rooms for key in room.surface_keys())

    def adjacency(self) -> tuple[tuple[str, str], ...]:
        """Return pairs of rooms joined by a door or passage, each pair once, sorted."""
        pairs = {
            tuple(sorted((door.room_a, door.room_b)))
            for door in self.doors
            if door.room_b is not None and door.room_b != door.room_a
        }
        return tuple(sorted((a, b) for a, b in pairs))
