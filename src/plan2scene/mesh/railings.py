"""Railings of balconies and terraces, in the place of walls that nobody lives behind."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House
from plan2scene.mesh.frames import Frame
from plan2scene.mesh.openings import Side
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder

COLOUR: Colour = (82, 84, 86)
#: Metres: height of a railing; its posts, bars and rails; the gap that no child fits through.
HEIGHT, POST, BAR, RAIL, GAP = 1.05, 0.045, 0.014, 0.035, 0.11
#: A post about every so many metres.
BAY = 1.2
#: A wall with a room this near behind it, metres, is that room's too.
BEHIND = 0.5


def railing_sides(
    house: House, sides: Sequence[Side], polygons: Mapping[str, BaseGeometry]
) -> list[Side]:
    """Return the sides that are railings: of rooms in the open air, no opening, no room behind."""
    open_air = {room.id for room in house.rooms if room.open_air}
    indoors = unary_union([polygons[room.id] for room in house.rooms if room.id not in open_air])
    found = []
    for side in sides:
        wall, frame = side.wall, side.frame
        if not open_air.issuperset(wall.room_ids) or wall.openings:
            continue
        ends = np.array([0.0, frame.length])
        strip = Polygon([*frame.plan(ends), *frame.plan(ends[::-1], -BEHIND)])
        if strip.intersection(indoors).area < 0.1 * strip.area:
            found.append(side)
    return found


def railing(side: Side) -> MeshPart:
    """Return the part ``{room}/railing/{wall}``: posts, two rails, bars."""
    builder = PartBuilder()
    add_railing(builder, side.frame, min(HEIGHT, side.wall.height))
    room = side.room_id
    extras = {"kind": "railing", "room_id": room, "wall_id": side.wall.id}
    return builder.build(f"{room}/railing/{side.wall.id}", extras=extras)


def add_railing(builder: PartBuilder, frame: Frame, top: float = HEIGHT) -> None:
    """Add posts, rails and bars behind a face's line, up to `top` metres."""
    axes, length = frame.axes(0.0), frame.length

    def upright(s: float, width: float, low: float, high: float) -> None:
        half = width / 2
        builder.box(axes, (s - half, low, -width), (s + half, high, 0.0), COLOUR)

    posts = np.linspace(POST / 2, length - POST / 2, max(2, round(length / BAY) + 1))
    for s in posts:
        upright(float(s), POST, 0.0, top - RAIL)
    for low in (0.08, top - RAIL):
        builder.box(axes, (0.0, low, -RAIL), (length, low + RAIL, 0.0), COLOUR)
    for first, second in itertools.pairwise(posts):
        count = int((second - first) / GAP)
        for s in np.linspace(first, second, count + 2)[1:-1]:
            upright(float(s), BAR, 0.08 + RAIL, top - RAIL)
