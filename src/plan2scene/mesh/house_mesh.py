"""A house as mesh parts (paper section 3: the 3D house that textures are put on)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Level, Stairs
from plan2scene.mesh.parts import GRID_DECIMALS, MeshPart, numbered
from plan2scene.mesh.stairs import handrails, stair_parts, well_railings
from plan2scene.mesh.storey import Storey, build_storey
from plan2scene.mesh.walls import Above
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area, step_count


@dataclass(frozen=True)
class Assembly:
    """A house's storeys, the lowest first."""

    storeys: tuple[Storey, ...]

    @property
    def parts(self) -> list[MeshPart]:
        """Return the parts of all storeys, each at its level's elevation."""
        return [lifted(part, storey.level) for storey in self.storeys for part in storey.parts]


def lifted(part: MeshPart, level: Level) -> MeshPart:
    """Return a part of a storey where it is in the house; its extras name the level."""
    if not level.id:
        return part
    mesh = part.mesh.copy()
    normals = np.array(part.mesh.vertex_normals)
    mesh.vertices = np.round(mesh.vertices + [0.0, level.elevation, 0.0], GRID_DECIMALS)
    mesh.vertex_normals = normals
    return replace(part, mesh=mesh, extras={**part.extras, "level": level.id})


def build_parts(house: House) -> list[MeshPart]:
    """Return every part of a house, each with a name of its own.

    Floors, ceilings and wall faces carry their room's texture key and have exact areas: a
    floor's is its polygon's less where stairs come up, a wall face's is length x height less
    openings. Everything else (wall bodies, door leaves, window frames, glass) is plain.

    Parameters
    ----------
    house : House
        Validated by its reader.
    """
    return assemble(house).parts


def assemble(house: House) -> Assembly:
    """Return the storeys of a house with their parts, see :func:`build_parts`."""
    storeys = []
    below: BaseGeometry | None = None
    well: BaseGeometry = Polygon()
    arriving: list[Stairs] = []
    for level, rooms in house.storeys():
        stairs = [flight for flight in house.stairs if flight.level == level.id]
        higher = house.level_above(level.id)
        above = None
        if higher is not None:
            own = [room_polygon(room) for room in house.rooms if room.level == higher.id]
            shaft = unary_union([flight_area(flight) for flight in stairs])
            above = Above(higher.elevation - level.elevation, unary_union(own), shaft)
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
