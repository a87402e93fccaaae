"""A house as mesh parts, storey by storey (paper section 3: the house that textures are put on)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Level, Stairs
from plan2scene.mesh.fittings import objects
from plan2scene.mesh.joinery import LEAF_COLOUR, fixtures, is_glazed, is_hatch
from plan2scene.mesh.parts import GRID_DECIMALS, MeshPart, numbered
from plan2scene.mesh.stairs import handrails, railing, stair_parts, well_railings
from plan2scene.mesh.structure import (
    OVERLAP,
    Above,
    Body,
    flat_parts,
    skirting,
    soffit,
    structure_part,
    threshold,
    wall_bodies,
    wall_face,
)
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area, step_count
from plan2scene.plans.wall_sides import Portal, find_openings, railing_sides, room_sides


@dataclass(frozen=True)
class Storey:
    """A level's parts, and the plan areas that drawings and exports of it need.

    `house` has the rooms of this level alone. `well` is the plan area where stairs come up: its
    floors are open there. `above` is what is on top. `flights` are the stairs that start or
    arrive here, with their number of steps.
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
    level: Level, house: House, below: BaseGeometry | None, well: BaseGeometry, above: Above | None
) -> Storey:
    """Return the storey of a `house` that has one level's rooms alone; part names may repeat.

    `below` is the plan area of the rooms that it stands on, None for the lowest level.
    """
    polygons = {room.id: room_polygon(room) for room in house.rooms}
    together = unary_union(list(polygons.values()))
    sides = room_sides(house, polygons)
    openings = find_openings(house, sides, polygons)
    rails = railing_sides(house, sides, polygons)
    walled = [side for side in sides if side not in rails]
    trims = dict(house.trim_colours)
    all_trim = trims.get("")
    parts: list[MeshPart] = [railing(side) for side in rails]
    for room in house.rooms:
        parts.extend(flat_parts(room, polygons[room.id], well, above))
        room_walls = [side for side in walled if side.room_id == room.id]
        faces = (
            wall_face(
                side, room, polygons[room.id], openings, house.wall_key(room.id, side.wall.id)
            )
            for side in room_walls
        )
        boards = skirting(room, room_walls, openings, trims.get(room.id, all_trim))
        parts.extend(part for part in (*faces, boards) if part is not None)
    bodies = wall_bodies(walled, together)
    low = 0.0 if below is None else -OVERLAP
    for body in bodies:
        part = structure_part(body, bodies, together, openings.portals, above, low=low)
        if part is not None:
            parts.append(part)
    portals = _largest(openings.portals)
    leaves = dict(house.door_colours)
    usual_colour = leaves.get("", LEAF_COLOUR)
    swinging = [portal for portal in portals if portal.hole.opening.kind == "door"]
    doors = Counter(room for portal in swinging for room in (portal.side.room_id, portal.other))
    rooms = {room.id: room for room in house.rooms}
    indoors = {room.id for room in house.rooms if not room.open_air}
    for portal in portals:
        strip = threshold(portal)
        leaf = leaves.get(portal.hole.opening.id, usual_colour)
        # A leaf opens into the room with fewer doors, not into a hall.
        inwards = portal.other is None or doors[portal.side.room_id] <= doors[portal.other]
        opens_into = portal.side.room_id if inwards else portal.other
        both = (portal.side.room_id, portal.other)
        trim = next((trims[room] for room in both if room in trims), all_trim)
        fixture_parts = fixtures(
            portal,
            leaf,
            trim,
            inwards=inwards,
            swept=polygons.get(opens_into or ""),
            hatch=is_hatch(portal, indoors),
            glazed=is_glazed(portal, rooms),
        )
        parts.extend(([strip] if strip is not None else []) + fixture_parts)
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


@dataclass(frozen=True)
class Assembly:
    """A house's storeys, the lowest first."""

    storeys: tuple[Storey, ...]

    @property
    def parts(self) -> list[MeshPart]:
        """Return the parts of all storeys, each at its level's elevation."""
        return [lifted(part, storey.level) for storey in self.storeys for part in storey.parts]


def lifted(part: MeshPart, level: Level) -> MeshPart:
    """Return a storey's part, moved up to its level's elevation; its extras name the level."""
    if not level.id:
        return part
    mesh = part.mesh.copy()
    normals = np.array(part.mesh.vertex_normals)
    mesh.vertices = np.round(mesh.vertices + [0.0, level.elevation, 0.0], GRID_DECIMALS)
    mesh.vertex_normals = normals
    return replace(part, mesh=mesh, extras={**part.extras, "level": level.id})


def assemble(house: House) -> Assembly:
    """Return the storeys of a validated house; every part has a unique name.

    Floors, ceilings and wall faces carry their room's texture key. Their areas are exact: a
    floor's is that of its polygon less the wells of stairs, a wall face's is length x height less
    openings. All other parts (wall bodies, door leaves, window frames, glass) are plain.
    """
    storeys = []
    below: BaseGeometry | None = None
    well: BaseGeometry = Polygon()
    arriving: list[Stairs] = []
    for level, rooms in house.storeys():
        stairs = [flight for flight in house.stairs if flight.level == level.id]
        higher = house.level_above(level.id)
        above = None
        if higher is not None:
            polygons_above = [room_polygon(room) for room in house.rooms if room.level == higher.id]
            shaft = unary_union([flight_area(flight) for flight in stairs])
            above = Above(higher.elevation - level.elevation, unary_union(polygons_above), shaft)
        storey = build_storey(level, rooms, below, well, above)
        flights = [(flight, step_count(house.rise_of(flight))) for flight in (*arriving, *stairs)]
        ways = stair_parts(house, stairs) + handrails(house, rooms, stairs)
        ways += well_railings(rooms, arriving, stairs)
        storeys.append(replace(storey, parts=(*storey.parts, *ways), flights=tuple(flights)))
        arriving = stairs if above is not None else []
        below = unary_union([room_polygon(room) for room in rooms.rooms])
        well = Polygon() if above is None else above.well
    names = iter(numbered(part.name for storey in storeys for part in storey.parts))
    return Assembly(
        tuple(
            replace(storey, parts=tuple(replace(part, name=next(names)) for part in storey.parts))
            for storey in storeys
        )
    )
