"""Occupancy map of each storey in the format of ROS: ``map.pgm`` and ``map.yaml``.

These are for the lowest level; a higher level has ``map_{level}.pgm`` and ``map_{level}.yaml``.

Pixels are 254 free, 0 occupied, 205 unknown, as in the trinary mode of `nav2_map_server`. The map's
x runs along the plan's x, its y along the plan's -z, so that the map is not mirrored from above.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
import yaml
from shapely.ops import unary_union

from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import Storey, assemble
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene_app.exports.solids import storey_solids

FREE, OCCUPIED, UNKNOWN = 254, 0, 205
RESOLUTION_M = 0.05
#: Width of the unknown margin around the house, metres.
MARGIN_M = 0.5
#: Heights, metres, between which a solid blocks a robot: thresholds are lower, lintels higher.
BODY_M = (0.05, 1.8)


def occupancy(
    storey: Storey, resolution_m: float = RESOLUTION_M
) -> tuple[np.ndarray, tuple[float, float]]:
    """Return a storey's map and its position.

    Inner doors are open; windows and doors to the outside are shut. Stairs are occupied, and so are
    the holes in the floor through which stairs come up.

    Returns
    -------
    grid : (h, w) uint8
        Row 0 has the greatest y.
    origin : (2,) tuple of float
        (x, y) of the map's lower left corner in metres; y is the plan's -z.
    """
    rooms = unary_union([room_polygon(room) for room in storey.house.rooms])
    floors, blocked = [rooms], [storey.well]
    for solid in storey_solids(storey):
        inner_door = solid.category == "door" and len(solid.room_ids) > 1
        for piece in solid.pieces:
            low, high = piece.bounds[:, 1]
            area = shapely.MultiPoint(piece.vertices[:, [0, 2]]).convex_hull
            if solid.category == "floor":
                floors.append(area)
            elif not inner_door and low < BODY_M[1] and high > BODY_M[0]:
                blocked.append(area)
    free, walls = unary_union(floors), unary_union(blocked)
    x0, z0, x1, z1 = unary_union([free, walls]).buffer(MARGIN_M).bounds
    width, height = (int(np.ceil((b - a) / resolution_m)) for a, b in ((x0, x1), (z0, z1)))
    x = x0 + (np.arange(width) + 0.5) * resolution_m
    z = z0 + (np.arange(height) + 0.5) * resolution_m
    grid = np.full((height, width), UNKNOWN, np.uint8)
    grid[shapely.contains_xy(free, *np.meshgrid(x, z))] = FREE
    # Every cell that a wall touches is occupied, so that thin walls leave no gap.
    half = resolution_m / 2
    cells = shapely.box(
        *(np.stack(np.meshgrid(x, z)) - half), *(np.stack(np.meshgrid(x, z)) + half)
    )
    shapely.prepare(walls)
    touched = shapely.intersects(walls, cells)
    grid[touched] = OCCUPIED
    return grid, (float(x0), float(-(z0 + height * resolution_m)))


def write_map(house: House, textures: dict[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write the maps of a house's storeys; the textures are not needed."""
    del textures
    for number, storey in enumerate(assemble(house).storeys):
        _write_storey(storey, folder, f"map_{storey.level.id}" if number else "map")


def _write_storey(storey: Storey, folder: Path, name: str) -> None:
    grid, origin = occupancy(storey)
    height, width = grid.shape
    with atomic_path(folder / f"{name}.pgm") as temporary:
        temporary.write_bytes(f"P5\n{width} {height}\n255\n".encode() + grid.tobytes())
    facts = {
        "image": f"{name}.pgm",
        "mode": "trinary",
        "resolution": RESOLUTION_M,
        "origin": [round(origin[0], 6), round(origin[1], 6), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.25,
    }
    with atomic_path(folder / f"{name}.yaml") as temporary:
        temporary.write_text(yaml.safe_dump(facts, sort_keys=False), encoding="utf-8")
