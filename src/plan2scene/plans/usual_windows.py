"""Guessed windows, where rooms usually have them, for plans without any (many agents' plans)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Opening, Room, Wall
from plan2scene.plans.geometry import point_along, room_polygon
from plan2scene.plans.wall_sides import inner_normal


@dataclass(frozen=True)
class UsualWindows:
    """Sizes and places of windows in dwellings, metres. Usual ones; none was chosen on homes."""

    #: Types of rooms that have a window.
    rooms: frozenset[str] = frozenset({"Reception", "Bedroom", "Kitchen", "Bathroom"})
    #: A window takes this share of the free wall, within limits, and stands in its middle.
    share: float = 0.45
    width: tuple[float, float] = (0.6, 1.8)
    bath_width: float = 0.7  #: largest width in a bathroom
    sill: float = 0.9
    bath_sill: float = 1.3
    top: float = 2.1
    below_ceiling: float = 0.2  #: least distance from a window's top to the ceiling
    beside: float = 0.25  #: least wall between a window and a corner or another opening
    #: A room of this area (m2) or more has a second window, in a wall of another direction.
    large_m2: float = 20.0
    #: Gaps between rooms narrower than twice this belong to the house: walls and voids.
    within: float = 0.75
    outside: float = 0.3  #: distance from a wall's line at which the check for a free view begins
    view: float = 2.0  #: least distance from a guessed window to the next wall outside


USUAL_WINDOWS = UsualWindows()


def built_area(rooms: Iterable[Room]) -> BaseGeometry:
    """Return the area of the rooms of a storey that have a roof, with the walls between them."""
    indoors = unary_union([room_polygon(room) for room in rooms if not room.open_air])
    closed = indoors.buffer(USUAL_WINDOWS.within, join_style="mitre")
    return closed.buffer(-USUAL_WINDOWS.within, join_style="mitre")


def guesses_windows(house: House) -> bool:
    """Return whether windows of a house are guessed, because its plan draws none."""
    return any(opening.guessed for wall in house.walls for opening in wall.openings)


def with_usual_windows(house: House) -> House:
    """Return a house with guessed windows in the outer walls of its rooms, if it has none.

    A house without a suitable outer wall stays as it is.
    """
    if any(opening.kind == "window" for wall in house.walls for opening in wall.openings):
        return house
    added: dict[str, Opening] = {}
    for _, storey in house.storeys():
        built = built_area(storey.rooms)
        for room in storey.rooms:
            if USUAL_WINDOWS.rooms & set(room.types):
                for wall, span in _chosen(storey, room, built):
                    added[wall.id] = _window(f"usual_window_{len(added) + 1}", room, span)
    walls = tuple(
        replace(wall, openings=(*wall.openings, added[wall.id])) if wall.id in added else wall
        for wall in house.walls
    )
    return replace(house, walls=walls)


def _chosen(
    storey: House, room: Room, built: BaseGeometry
) -> Iterator[tuple[Wall, tuple[float, float]]]:
    """Yield the walls of a room that get a window, with their free stretch."""
    open_air = {other.id for other in storey.rooms if other.open_air}
    polygon = room_polygon(room)
    stretches = []
    for wall in storey.walls_of(room.id):
        low, high = max(_free(wall), key=lambda span: span[1] - span[0])
        if high - low < USUAL_WINDOWS.width[0] or not set(wall.room_ids) <= {room.id, *open_air}:
            continue
        middle, inwards = point_along(wall, (low + high) / 2), inner_normal(wall, polygon)
        ends = (USUAL_WINDOWS.outside, USUAL_WINDOWS.view)
        if not LineString([middle - away * inwards for away in ends]).intersects(built):
            stretches.append((wall, (low, high)))
    stretches.sort(key=lambda item: item[1][0] - item[1][1])
    ways = [np.subtract(wall.end, wall.start) / wall.length for wall, _ in stretches]
    yield from stretches[:1]
    if polygon.area >= USUAL_WINDOWS.large_m2:
        across = (k for k, way in enumerate(ways) if abs(way @ ways[0]) < 0.7)
        yield from (stretches[k] for k in list(across)[:1])


def _free(wall: Wall) -> Iterator[tuple[float, float]]:
    """Yield (low, high) of a wall's stretches away from corners and openings, metres along it."""
    opening_spans = sorted((opening.start, opening.end) for opening in wall.openings)
    for (_, low), (high, _) in pairwise([(0.0, 0.0), *opening_spans, (wall.length, wall.length)]):
        yield low + USUAL_WINDOWS.beside, high - USUAL_WINDOWS.beside


def _window(name: str, room: Room, span: tuple[float, float]) -> Opening:
    """Return a window in the middle of a stretch of wall."""
    bath = "Bathroom" in room.types
    low, high = USUAL_WINDOWS.width
    width = float(np.clip(USUAL_WINDOWS.share * (span[1] - span[0]), low, high))
    half = min(width, USUAL_WINDOWS.bath_width) / 2 if bath else width / 2
    middle = (span[0] + span[1]) / 2
    top = min(USUAL_WINDOWS.top, room.height - USUAL_WINDOWS.below_ceiling)
    bottom = min(USUAL_WINDOWS.bath_sill if bath else USUAL_WINDOWS.sill, top - 0.4)
    return Opening(name, "window", middle - half, middle + half, bottom, top, guessed=True)
