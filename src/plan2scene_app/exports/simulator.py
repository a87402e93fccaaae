"""A simulator pack: what is seen, what collides and what is what, with descriptors.

``house.glb`` (textured), ``collision.glb`` (convex pieces), ``semantic.glb`` (one colour an
instance) with ``semantic.txt``, ``house.stage_config.json`` for Habitat, and ``house.xml`` for
MuJoCo. Metres; the GLBs have y up. Sources: Habitat's stage attributes and HM3D's semantic text,
MuJoCo's XML reference; the Habitat files follow its documentation and were not opened in it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb

from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_path, write_json
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.house_mesh import assemble
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.textures import TileTexture
from plan2scene_app.exports.mjcf import mjcf_text
from plan2scene_app.exports.solids import Solid, house_solids

#: What the parts' kinds are called as categories.
CATEGORIES = {
    "structure": "wall",
    "threshold": "floor",
    "passage": "door frame",
    "glass": "window",
}
#: Neighbours get colours far apart; odd, so that it permutes all colours (the golden ratio's).
FACTOR = 10368889


def write_simulator(house: House, textures: dict[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write the pack of a house into a folder."""
    assembly = assemble(house)
    parts, solids = assembly.parts, house_solids(house, assembly)
    write_glb(house, textures, folder / "house.glb", parts)
    _write_scene(folder / "collision.glb", [_collision(solid) for solid in solids])
    instances = instances_of(parts)
    _write_scene(folder / "semantic.glb", [_painted(*instance[:2]) for instance in instances])
    rows = [
        f'{number},{_hex(colour)},"{category}",{region}'
        for number, (_, colour, category, region) in enumerate(instances, start=1)
    ]
    with atomic_path(folder / "semantic.txt") as temporary:
        text = "\n".join(["HM3D Semantic Annotations", *rows]) + "\n"
        temporary.write_text(text, encoding="utf-8")
    write_json(folder / "house.stage_config.json", stage_config())
    with atomic_path(folder / "house.xml") as temporary:
        temporary.write_text(mjcf_text(house, solids), encoding="utf-8")


def _hex(colour: tuple[int, int, int]) -> str:
    """Return a colour as six hexadecimal digits."""
    return "".join(f"{value:02X}" for value in colour)


def stage_config() -> dict[str, Any]:
    """Return Habitat's description of the stage."""
    return {
        "render_asset": "house.glb",
        "collision_asset": "collision.glb",
        "semantic_asset": "semantic.glb",
        "semantic_descriptor_filename": "semantic.txt",
        "has_semantic_textures": False,
        "up": [0.0, 1.0, 0.0],
        "front": [0.0, 0.0, -1.0],
        "units_to_meters": 1.0,
        "gravity": [0.0, -9.8, 0.0],
        "is_collidable": True,
        "requires_lighting": True,
    }


Instance = tuple[MeshPart, tuple[int, int, int], str, int]


def instances_of(parts: list[MeshPart]) -> list[Instance]:
    """Return each part with a colour of its own, its category and the number of its room.

    Regions count the rooms in order from 0; what belongs to none has -1.
    """
    rooms = list(dict.fromkeys(part.extras.get("room_id") for part in parts))
    rooms = [room for room in rooms if room is not None]
    found: list[Instance] = []
    for number, part in enumerate(parts, start=1):
        kind = str(part.extras.get("kind", ""))
        room = part.extras.get("room_id")
        region = rooms.index(room) if room is not None else -1
        found.append((part, instance_colour(number), CATEGORIES.get(kind, kind), region))
    return found


def instance_colour(number: int) -> tuple[int, int, int]:
    """Return a colour for an instance from 1 on: different for all up to 2**24 - 1."""
    value = number * FACTOR % 2**24
    return value >> 16, value >> 8 & 255, value & 255


def _collision(solid: Solid) -> tuple[str, trimesh.Trimesh]:
    """Return a solid's name and its pieces as one mesh."""
    return solid.name, trimesh.util.concatenate(list(solid.pieces))


def _painted(part: MeshPart, colour: tuple[int, int, int]) -> tuple[str, trimesh.Trimesh]:
    """Return a part's name and its mesh in its instance's colour."""
    colours = np.tile(np.array([*colour, 255], np.uint8), (len(part.mesh.vertices), 1))
    mesh = trimesh.Trimesh(
        part.mesh.vertices, part.mesh.faces, vertex_colors=colours, process=False
    )
    return part.name, mesh


def _write_scene(path: Path, meshes: list[tuple[str, trimesh.Trimesh]]) -> None:
    """Write named meshes as a GLB."""
    scene = trimesh.Scene()
    for name, mesh in meshes:
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    with atomic_path(path) as temporary:
        temporary.write_bytes(export_glb(scene))
