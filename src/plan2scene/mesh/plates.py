"""Floors, ceilings, and the underside of what juts out over the storey below."""

from __future__ import annotations

from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import Level, Room, SurfaceKey
from plan2scene.mesh.parts import MeshPart, PartBuilder
from plan2scene.mesh.walls import LIFT, OUTER_COLOUR, TOUCH, Above, Body, solid_area


def flat_parts(
    room: Room, polygon: BaseGeometry, well: BaseGeometry, above: Above | None
) -> list[MeshPart]:
    """Return a room's floor (facing up, y = 0) and ceiling (facing down, y = height).

    The floor is open where stairs come up (`well`), the ceiling where they go on; a room in the
    open air has no ceiling. UV in metres: columns along +x, rows along +z.
    """
    parts = []
    for surface, y in (("floor", 0.0), ("ceiling", room.height)):
        if surface == "ceiling" and room.open_air:
            continue
        builder = PartBuilder()
        builder.level(open_plate(polygon, surface, well, above), y, up=surface == "floor")
        if not builder:
            continue
        extras = {"kind": surface, "room_id": room.id, "surface": surface}
        key = SurfaceKey(room.id, surface)
        parts.append(builder.build(f"{room.id}/{surface}", "surface", key, extras))
    return parts


def open_plate(
    polygon: BaseGeometry, surface: str, well: BaseGeometry, above: Above | None
) -> BaseGeometry:
    """Return a room's plan area less the stairs that go through its floor or ceiling."""
    shaft = well
    if surface == "ceiling":
        shaft = Polygon() if above is None else above.well
    return polygon if shaft.is_empty else polygon.difference(shaft)


def soffit(
    level: Level, rooms: BaseGeometry, bodies: list[Body], below: BaseGeometry
) -> list[MeshPart]:
    """Return the part ``structure/soffit/{level}``: the underside of what juts out over a level.

    `rooms` and `bodies` are the level's, `below` the plan area of the rooms under it.
    """
    reach = max((body.side.wall.depth for body in bodies), default=0.0)
    walls = unary_union([body.area for body in bodies])
    out = unary_union([rooms, walls]).difference(below.buffer(reach + TOUCH, join_style="mitre"))
    builder = PartBuilder()
    builder.level(solid_area(out), -LIFT, up=False, colour=OUTER_COLOUR)
    if not builder:
        return []
    return [builder.build(f"structure/soffit/{level.id}", extras={"kind": "structure"})]
