"""Skirting boards: a plain strip along the foot of a room's walls, open where doors are."""

from __future__ import annotations

from collections.abc import Iterable

from shapely.geometry import LineString, box
from shapely.geometry.base import BaseGeometry

from plan2scene.house import Room
from plan2scene.mesh.openings import Openings, Side
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder

SKIRTING_COLOUR: Colour = (240, 238, 232)
#: Metres: common sizes of joinery.
HEIGHT, DEPTH = 0.07, 0.014
#: A board ends so far beside a door, where its frame is, metres.
FRAME = 0.012
#: Shorter pieces are left out, metres.
LEAST_LENGTH = 0.05
#: Rooms of these types have tiles up to the wall, or are outside.
WITHOUT = {"Bathroom", "Outdoor", "Balcony", "Terrace", "Staircase"}


def skirting(room: Room, sides: Iterable[Side], openings: Openings) -> MeshPart | None:
    """Return the part ``{room}/skirting``; None for rooms without any.

    Parameters
    ----------
    room : Room
    sides : iterable of Side
        The faces of the room's walls.
    openings : Openings
        The holes of all faces.
    """
    if WITHOUT & set(room.types):
        return None
    builder = PartBuilder()
    for side in sides:
        for left, right in free_stretches(side, openings.hole(side)):
            builder.box(
                side.frame.axes(0.0), (left, 0.0, 0.0), (right, HEIGHT, DEPTH), SKIRTING_COLOUR
            )
    if not builder:
        return None
    return builder.build(f"{room.id}/skirting", extras={"kind": "skirting", "room_id": room.id})


def free_stretches(side: Side, holes: BaseGeometry) -> list[tuple[float, float]]:
    """Return (left, right) of the stretches of a face's foot without a hole, metres along it."""
    frame = side.frame
    foot: BaseGeometry = LineString([(0.0, HEIGHT / 2), (frame.length, HEIGHT / 2)])
    wide = [
        box(x0 - FRAME, y0, x1 + FRAME, y1)
        for x0, y0, x1, y1 in (part.bounds for part in getattr(holes, "geoms", [holes]))
        if x1 > x0
    ]
    for hole in wide:
        foot = foot.difference(hole)
    lines = [line for line in getattr(foot, "geoms", [foot]) if line.length > LEAST_LENGTH]
    return [(line.bounds[0], line.bounds[2]) for line in lines]
