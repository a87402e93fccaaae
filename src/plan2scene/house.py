"""The data model: a house as rooms, walls, openings and surfaces, in metres.

Plan coordinates are (x, z) in metres of a right-handed frame with y up, as in scene.json
(``docs/conventions.md``). The classes are frozen. A plan is validated once, when it is read
(:func:`plan2scene.plans.validate_house`); all later code trusts it.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

MAX_ID_LENGTH = 150  #: Longest id, so that file names built from it stay legal
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
OPEN_AIR = frozenset({"Outdoor", "Terrace", "Balcony"})  #: Types of rooms without a roof
#: Surface kinds of a room, in the order of the propagation network's blocks.
SURFACES = ("floor", "wall", "ceiling")
#: Substances in the order of the substance head's logits.
SUBSTANCES = ("wood", "plaster", "carpet", "tile")
DEFAULT_HEIGHT = 2.8  #: Height in metres of a room whose plan gives none
#: Values of :attr:`House.heights`: ceilings have usual heights, or heights measured in photos.
USUAL, FROM_PHOTOS = "usual", "photos"
#: Kinds of opening. A passage is a door-sized or wider hole without a leaf.
OPENING_KINDS = ("door", "window", "passage")

Point = tuple[float, float]  #: (x, z) in metres
Ring = tuple[Point, ...]  #: closed polygon ring, first point not repeated


class SurfaceKey(NamedTuple):
    """Names one texturable surface of a house.

    All walls of a room share ``wall``; only an accent wall has its own, ``wall.{wall id}``.
    """

    room_id: str
    surface: str

    @property
    def kind(self) -> str:
        """Return its kind, one of `SURFACES`."""
        return self.surface.partition(".")[0]

    @property
    def filename(self) -> str:
        """Stem of the texture file of this surface."""
        return f"{self.room_id}_{self.surface}"


def _plain(name: str) -> str:
    """Return a name for comparisons: its Unicode form, spaces and case are normalised."""
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())


@dataclass(frozen=True)
class Opening:
    """A hole in a wall: metres along the wall from its first point, and metres above the floor.

    `guessed`: the plan does not show it; it was added because such rooms usually have one.
    """

    id: str
    kind: str  # one of OPENING_KINDS
    start: float
    end: float
    bottom: float
    top: float
    guessed: bool = False


@dataclass(frozen=True)
class Wall:
    """A straight wall of one room (or two that share it) from `start` to `end`.

    `room_ids[0]` is the room on the inner side (the first material of scene.json); a second id
    is the room on the other side. The segment lies on the edges of the rooms' polygons; `depth`
    is the wall's thickness in metres.
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

    def full(self, opening: Opening) -> bool:
        """Return whether an opening reaches the top of the wall."""
        return opening.top >= self.height - 1e-3


@dataclass(frozen=True)
class Room:
    """A room: its types (several for open plan), outline and height in metres.

    `rings[0]` is the outline, further rings are holes. `level` is the id of one of the house's
    levels; empty where it has none. `name` is what people call it, in any script; empty where it
    is not known.
    """

    id: str
    types: tuple[str, ...]
    rings: tuple[Ring, ...]
    height: float
    level: str = ""
    name: str = ""

    @property
    def open_air(self) -> bool:
        """Whether the room has no roof: a balcony, terrace or yard."""
        return bool(self.types) and OPEN_AIR.issuperset(self.types)

    @property
    def title(self) -> str:
        """Return a title of the room: its name, else its id if that is a word, else its types.

        An id with a digit comes from a program; "room" is the editor's id of a new room.
        """
        word = re.fullmatch(r"(?!room$)[A-Za-z]{2}[^0-9]*", self.id)
        called = self.name or (self.id.replace("_", " ") if word else "")
        return called or " / ".join(self.types)

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
    """Box of an icon drawn in the plan: corners (x, z) in metres, and the level it is on."""

    type: str
    p1: Point
    p2: Point
    level: str = ""


@dataclass(frozen=True)
class Level:
    """A storey: the y of its floor and the usual height of its ceilings above it, metres."""

    id: str
    name: str
    elevation: float
    height: float


GROUND = Level("", "", 0.0, DEFAULT_HEIGHT)  #: The level of a plan without levels


@dataclass(frozen=True)
class Stairs:
    """A straight flight of stairs from a level's floor up to the next: a strip around its axis.

    `start` is the middle of its foot, `end` the middle of its head; both and `width` are in metres.
    `room_ids` are the room that it stands in and the room that it leads to; None for no room.
    """

    id: str
    level: str
    start: Point
    end: Point
    width: float
    room_ids: tuple[str | None, str | None] = (None, None)

    @property
    def length(self) -> float:
        """Length of the flight in plan, metres."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True)
class House:
    """A whole plan. `doors` holds each relation once (not both directions).

    `levels` go from the lowest to the highest; there are none in a plan of one storey at y = 0.
    Heights of walls and openings are above the floor of their rooms' level. `accents` are the
    walls that have their own texture on one side. The colours are sRGB: `door_colours` of door
    leaves, by the id of their opening, `trim_colours` of skirting and frames, by room, and
    `stair_colours` of steps, by flight; the id "" stands for all other doors, or rooms. `name` is
    what people call the house. `heights` is the source of its ceilings' heights: empty for the
    plan, `USUAL` if the plan gives none, `FROM_PHOTOS` if they were then measured in photos.
    """

    id: str
    rooms: tuple[Room, ...]
    walls: tuple[Wall, ...]
    doors: tuple[Door, ...] = ()
    objects: tuple[PlacedObject, ...] = ()
    icons: tuple[IconBox, ...] = ()
    levels: tuple[Level, ...] = ()
    stairs: tuple[Stairs, ...] = ()
    accents: tuple[SurfaceKey, ...] = ()
    door_colours: tuple[tuple[str, tuple[int, int, int]], ...] = ()
    trim_colours: tuple[tuple[str, tuple[int, int, int]], ...] = ()
    stair_colours: tuple[tuple[str, tuple[int, int, int]], ...] = ()
    name: str = ""
    heights: str = ""
    warnings: tuple[str, ...] = field(default=(), compare=False)

    @property
    def title(self) -> str:
        """Return what people call the house: its name, else its id."""
        return self.name or self.id

    def room(self, room_id: str) -> Room:
        """Return the room of that id (KeyError when there is none)."""
        for room in self.rooms:
            if room.id == room_id:
                return room
        raise KeyError(room_id)

    @property
    def labels(self) -> dict[str, str]:
        """Return a label for each room id that no other room has: name, id, or both."""
        named = [_plain(room.name) for room in self.rooms]
        return {
            room.id: f"{room.name} ({room.id})"
            if name and named.count(name) > 1
            else room.name or room.id
            for room, name in zip(self.rooms, named, strict=True)
        }

    def rooms_called(self, text: str) -> list[Room]:
        """Return the room whose id is `text`, else all rooms with that name or id in any case."""
        by_id = [room for room in self.rooms if room.id == text]
        plain = _plain(text)
        alike = [r for r in self.rooms if plain and plain in (_plain(r.name), _plain(r.id))]
        return by_id or alike

    def level_of(self, room_id: str) -> Level:
        """Return the level of a room; :data:`GROUND` where the house has no levels."""
        wanted = self.room(room_id).level
        return next((level for level in self.levels if level.id == wanted), GROUND)

    def level_above(self, level_id: str) -> Level | None:
        """Return the next higher level, None above the highest."""
        ids = [level.id for level in self.levels]
        number = ids.index(level_id) + 1 if level_id in ids else len(ids)
        return self.levels[number] if number < len(ids) else None

    def rise_of(self, stairs: Stairs) -> float:
        """Return a flight's height in metres: up to the next level, else to its room's ceiling."""
        above = self.level_above(stairs.level)
        if above is not None:
            elevations = {level.id: level.elevation for level in self.levels}
            return above.elevation - elevations[stairs.level]
        lower = stairs.room_ids[0]
        return DEFAULT_HEIGHT if lower is None else self.room(lower).height

    def storeys(self) -> tuple[tuple[Level, House], ...]:
        """Return each level, lowest first, with a house that has only the level's rooms.

        That house has no stairs and no levels, so its floors are at y = 0.
        """
        if not self.levels:
            return ((GROUND, self),)
        return tuple((level, self._storey(level.id)) for level in self.levels)

    def _storey(self, level_id: str) -> House:
        """Return the house of one level's rooms."""
        rooms = tuple(replace(r, level="") for r in self.rooms if r.level == level_id)
        ids = {room.id for room in rooms}
        return replace(
            self,
            rooms=rooms,
            walls=tuple(wall for wall in self.walls if wall.room_ids[0] in ids),
            doors=tuple(door for door in self.doors if door.room_a in ids),
            icons=tuple(replace(i, level="") for i in self.icons if i.level == level_id),
            levels=(),
            stairs=(),
        )

    def walls_of(self, room_id: str) -> Iterator[Wall]:
        """Yield the walls that bound a room."""
        return (wall for wall in self.walls if room_id in wall.room_ids)

    def surface_keys(self) -> tuple[SurfaceKey, ...]:
        """Return the keys of all surfaces, room by room, then those of accent walls."""
        ids = {room.id for room in self.rooms}
        accents = tuple(key for key in self.accents if key.room_id in ids)
        return tuple(key for room in self.rooms for key in room.surface_keys()) + accents

    def wall_key(self, room_id: str, wall_id: str) -> SurfaceKey:
        """Return the surface of a wall's side that faces a room."""
        accent_key = SurfaceKey(room_id, f"wall.{wall_id}")
        return accent_key if accent_key in self.accents else SurfaceKey(room_id, "wall")

    def passages(self) -> tuple[tuple[str, str, float], ...]:
        """Return for each passage the two rooms that it joins and its width in metres."""
        openings = (opening for wall in self.walls for opening in wall.openings)
        widths = {o.id: o.end - o.start for o in openings if o.kind == "passage"}
        return tuple(
            (door.room_a, door.room_b, widths[door.opening_id])
            for door in self.doors
            if door.opening_id in widths and door.room_a and door.room_b
        )

    def adjacency(self) -> tuple[tuple[str, str], ...]:
        """Return pairs of rooms joined by a door, passage or stairs, each pair once, sorted."""
        joined: list[tuple[str | None, str | None]] = [(d.room_a, d.room_b) for d in self.doors]
        joined += [stairs.room_ids for stairs in self.stairs]
        pairs = {(min(a, b), max(a, b)) for a, b in joined if a and b and a != b}
        return tuple(sorted(pairs))
