"""One storey of a house as mesh parts, its floors at 0."""

from __future__ import annotations

from dataclasses import dataclass

from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Level, Stairs
from plan2scene.mesh.fixtures import fixtures
from plan2scene.mesh.objects import objects
from plan2scene.mesh.openings import Portal, find_openings, room_sides
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.plates import flat_parts, soffit
from plan2scene.mesh.railings import railing, railing_sides
from plan2scene.mesh.skirting import skirting
from plan2scene.mesh.walls import (
    OVERLAP,
    Above,
    Body,
    structure_part,
    threshold,
    wall_bodies,
    wall_face,
)
from plan2scene.plans.geometry import room_polygon


@dataclass(frozen=True)
class Storey:
    """A level's parts, and the plan areas that drawings and bodies of it need.

    `house` has the level's rooms alone. `well` is where stairs come up, open in the floors;
    `above` what is on top, with the stairs that its ceilings are open over. `flights` are the
    stairs that start or arrive here, with their number of steps.
    """

    level: Level
    house: House
    parts: tuple[MeshPart, ...]
    bodies: tuple[Body, ...]
    portals: tuple[Portal, ...]
    well: BaseGeometry
    above: Above | None
    flights: tuple[tuple[Stairs, int], ...] = ()


def build_storey(
    level: Level,
    house: House,
    below: BaseGeometry | None,
    well: BaseGeometry,
    above: Above | None,
) -> Storey:
    """Return the storey of a house without levels and stairs; names of parts may repeat.

    `below` is the plan area of the rooms that it stands on, None for the lowest level.
    """
    polygons = {room.id: room_polygon(room) for room in house.rooms}
    together = unary_union(list(polygons.values()))
    sides = room_sides(house, polygons)
    openings = find_openings(house, sides, polygons)
    rails = railing_sides(house, sides, polygons)
    walled = [side for side in sides if side not in rails]
    parts: list[MeshPart] = [railing(side) for side in rails]
    for room in house.rooms:
        parts.extend(flat_parts(room, polygons[room.id], well, above))
        own = [side for side in walled if side.room_id == room.id]
        faces = (
            wall_face(
                side, room, polygons[room.id], openings, house.wall_key(room.id, side.wall.id)
            )
            for side in own
        )
        boards = skirting(room, own, openings)
        parts.extend(part for part in (*faces, boards) if part is not None)
    bodies = wall_bodies(walled, together)
    low = 0.0 if below is None else -OVERLAP
    for body in bodies:
        part = structure_part(body, bodies, together, openings.portals, above, low=low)
        if part is not None:
            parts.append(part)
    portals = _largest(openings.portals)
    for portal in portals:
        strip = threshold(portal)
        parts.extend(([strip] if strip is not None else []) + fixtures(portal))
    parts.extend(objects(house, sides, polygons))
    if below is not None:
        parts.extend(soffit(level, together, bodies, below))
    return Storey(level, house, tuple(parts), tuple(bodies), tuple(portals), well, above)


def _largest(portals: list[Portal]) -> list[Portal]:
    """Return portals without those that mostly lie inside a wider one of the same wall."""
    kept: list[Portal] = []
    for portal in sorted(portals, key=lambda p: -p.width):
        inside = any(
            portal.side.wall.id == other.side.wall.id
            and min(portal.hole.right, other.hole.right) - max(portal.hole.left, other.hole.left)
            > 0.5 * portal.width
            and min(portal.hole.top, other.hole.top) > max(portal.hole.bottom, other.hole.bottom)
            for other in kept
        )
        if not inside:
            kept.append(portal)
    return [portal for portal in portals if portal in kept]
