"""Export for simulators: a textured model, a collision model and a semantic model of a house.

``house.glb`` (textured), ``collision.glb`` (convex pieces), ``semantic.glb`` (one colour an
instance) with ``semantic.txt``, ``house.stage_config.json`` for Habitat, and ``house.xml`` for
MuJoCo: static convex geoms, doors as hinged bodies. Metres and radians; the GLBs have y up,
MuJoCo's z is up: (x, y, z) of the house becomes (x, -z, y). Sources: Habitat's stage attributes
and HM3D's semantic text, MuJoCo's XML reference; the Habitat files follow its documentation and
were not opened in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import trimesh
from trimesh.exchange.gltf import export_glb

from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_path, write_json
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.exports.solids import Solid, house_solids

#: Semantic category by the kind of a part; other kinds are categories themselves.
CATEGORIES = {
    "structure": "wall",
    "threshold": "floor",
    "passage": "door frame",
    "glass": "window",
}
#: Factor that makes the colours of consecutive instances very different: 2**24 over the golden
#: ratio. It is odd, so that no two instances get the same colour.
FACTOR = 10368889


def write_simulator(house: House, textures: dict[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write the files of a house for simulators into a folder."""
    assembly = assemble(house)
    parts, solids = assembly.parts, house_solids(house, assembly)
    write_glb(house, textures, folder / "house.glb", parts)
    fixed = [_collision(solid) for solid in solids if not solid.ajar]
    _write_scene(folder / "collision.glb", fixed)
    instances = instances_of(house, parts)
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
    """Return the stage configuration for Habitat."""
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


def instances_of(house: House, parts: list[MeshPart]) -> list[Instance]:
    """Return each part with a unique colour, its category and the number of its region.

    The house's rooms are numbered as regions from 0; a part without a room has -1.
    """
    rooms: list[object] = [room.id for room in house.rooms]
    instances: list[Instance] = []
    for number, part in enumerate(parts, start=1):
        room = part.extras.get("room_id")
        region = rooms.index(room) if room is not None else -1
        instances.append((part, instance_colour(number), category_of(part), region))
    return instances


def category_of(part: MeshPart) -> str:
    """Return a part's semantic category; an object of the plan has its own: ``toilet`` ..."""
    kind = str(part.extras.get("kind", ""))
    return str(part.extras.get("category", CATEGORIES.get(kind, kind)))


def instance_colour(number: int) -> tuple[int, int, int]:
    """Return the RGB colour of instance `number`, 1 to 2**24 - 1; all colours are different."""
    value = number * FACTOR % 2**24
    return value >> 16, value >> 8 & 255, value & 255


def _collision(solid: Solid) -> tuple[str, trimesh.Trimesh]:
    """Return a solid's name and its pieces as one mesh."""
    return solid.name, trimesh.util.concatenate(list(solid.pieces))


def _painted(part: MeshPart, colour: tuple[int, int, int]) -> tuple[str, trimesh.Trimesh]:
    """Return a part's name and its mesh, painted in the colour of its instance."""
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


#: Density of a door leaf, kg per cubic metre (hollow-core wood); damping and friction of its hinge.
DOOR_DENSITY = 350.0
HINGE_DAMPING, HINGE_FRICTION = 0.6, 0.1
OPEN_RAD = math.radians(100.0)
#: Colours by category, RGBA.
COLOURS = {
    "floor": "0.70 0.64 0.58 1",
    "ceiling": "0.96 0.95 0.94 0.15",
    "wall": "0.91 0.89 0.86 1",
    "door": "0.62 0.45 0.32 1",
    "window": "0.70 0.85 0.95 0.3",
}
OBJECT = "0.80 0.80 0.78 1"


def mjcf_text(house: House, solids: Sequence[Solid]) -> str:
    """Return the MJCF document of a house with these solids.

    Bodies have the names of their solids. In the keyframe ``open``, all inner doors are open.
    """
    root = ET.Element("mujoco", model=house.id)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep="0.002", integrator="implicitfast")
    assets, world = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody")
    contact = ET.SubElement(root, "contact")
    ET.SubElement(world, "light", pos="0 0 20", dir="0 0 -1", directional="true")
    opened = []
    for solid in solids:
        body = world
        if solid.hinge is not None:
            body = _leaf(world, contact, solid)
            opened.append(solid.hinge.opens * 0.9 * OPEN_RAD if len(solid.room_ids) > 1 else 0.0)
        for number, piece in enumerate(solid.pieces):
            _geom(assets, body, solid, f"{solid.name}/{number}", piece)
    if opened:
        keys = ET.SubElement(root, "keyframe")
        ET.SubElement(keys, "key", name="open", qpos=_numbers(opened))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _leaf(world: ET.Element, contact: ET.Element, solid: Solid) -> ET.Element:
    """Add the body of a door leaf, without contact with the house; return it."""
    hinge = solid.hinge
    if hinge is None:
        raise ValueError(f"{solid.name} has no hinge")
    body = ET.SubElement(world, "body", name=solid.name, pos=_numbers([hinge.x, -hinge.z, 0.0]))
    limits = sorted((0.0, hinge.opens * OPEN_RAD))
    ET.SubElement(
        body,
        "joint",
        name=f"{solid.name}/hinge",
        type="hinge",
        axis="0 0 1",
        range=_numbers(limits),
        damping=str(HINGE_DAMPING),
        frictionloss=str(HINGE_FRICTION),
    )
    ET.SubElement(contact, "exclude", body1="world", body2=solid.name)
    return body


def _geom(
    assets: ET.Element, body: ET.Element, solid: Solid, name: str, piece: trimesh.Trimesh
) -> None:
    """Add a convex piece by its vertices only: MuJoCo uses their convex hull."""
    points = z_up(piece.vertices)
    if solid.hinge is not None:
        points = points - [solid.hinge.x, -solid.hinge.z, 0.0]
    ET.SubElement(assets, "mesh", name=name, vertex=_numbers(points.ravel()))
    geom = ET.SubElement(
        body, "geom", name=name, type="mesh", mesh=name, rgba=COLOURS.get(solid.category, OBJECT)
    )
    if solid.hinge is not None:
        geom.set("density", str(DOOR_DENSITY))


def z_up(points: np.ndarray) -> np.ndarray:
    """Return world points (n, 3) with z up: (x, -z, y)."""
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def _numbers(values: object) -> str:
    """Return numbers as MJCF writes them."""
    return " ".join(f"{float(v) + 0.0:.6g}" for v in np.asarray(values).ravel())
