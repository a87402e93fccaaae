"""Export for Home Assistant's floor3d-card: OBJ with MTL, a lamp in each room, the card's YAML.

It follows the card's documentation (https://github.com/adizanni/floor3d-card): the house's corner
is at the origin, lengths are centimetres, every light has an object, every room a zoom. If the
house has storeys, names of objects begin with ``lvl000`` and so on, as the card's plugin for Sweet
Home 3D writes them: the card removes this prefix and shows a button for each storey. Ceilings are
left out, because the house is seen from above. Not tested in Home Assistant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from plan2scene.house import House, Room, SurfaceKey
from plan2scene.io import write_text
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.baking import lamp_position
from plan2scene.mesh.parts import MeshPart, PartBuilder
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.exports.obj import write_obj
from plan2scene_app.ids import free_id

#: The card's units per metre; half the side of a lamp's cube in metres; a lamp's light in lumens.
_PER_M, _LAMP_M, _LUMENS = 100.0, 0.08, 900
#: Distance of a zoom from its floor: the least in metres, and the distance as a multiple of the
#: room's longer side (the card's field of view is 45 degrees).
_NEAREST_M, _AWAY = 5.0, 1.5
_HEAD = """# Copy this folder to /config/www/{house}, put the names of your lights for those below
# and leave out what you do not have: the card takes entities that exist only.
"""


def write_home_assistant(
    house: House, textures: Mapping[SurfaceKey, TileTexture], folder: Path
) -> None:
    """Write ``house.obj``, ``house.mtl``, ``house_textures/`` and ``card.yaml`` into a folder."""
    visible_parts = [part for part in assemble(house).parts if not _is_ceiling(part)]
    parts = [*visible_parts, *(_lamp(house, room.id) for room in house.rooms)]
    low = np.min([part.mesh.bounds[0] for part in parts], axis=0)
    storeys = {level.id: f"lvl{number:03d}" for number, level in enumerate(house.levels)}
    used = {part.surface for part in visible_parts}
    tiles = {key: tile for key, tile in textures.items() if key in used}
    write_obj(house, tiles, folder / "house.obj", [_placed(part, low, storeys) for part in parts])
    text = yaml.safe_dump(card(house), sort_keys=False, allow_unicode=True)
    write_text(folder / "card.yaml", _HEAD.format(house=house.id) + text)


def card(house: House) -> dict[str, Any]:
    """Return the card's configuration: for each room a light (its lamp) and a zoom on its floor."""
    lights: set[str] = set()
    return {
        "type": "custom:floor3d-card",
        "name": house.title,
        "path": f"/local/{house.id}/",
        "objfile": "house.obj",
        "mtlfile": "house.mtl",
        "backgroundColor": "#e8e6e0",
        "globalLightPower": 0.4,
        "entities": [
            {
                "entity": f"light.{free_id(room.id, lights)}",
                "type3d": "light",
                "object_id": f"{room.id}/lamp",
                "light": {"lumens": _LUMENS},
            }
            for room in house.rooms
        ],
        "zoom_areas": [
            {
                "zoom": room.name or room.id.replace("_", " "),
                "object_id": f"{room.id}/floor",
                "distance": round(_PER_M * max(_NEAREST_M, _AWAY * _longest_side(room))),
            }
            for room in house.rooms
        ],
    }


def _longest_side(room: Room) -> float:
    """Return the longer side of a room's bounds, metres."""
    return float(np.ptp(np.array(room.rings[0]), axis=0).max())


def _is_ceiling(part: MeshPart) -> bool:
    return part.surface is not None and part.surface.kind == "ceiling"


def _lamp(house: House, room_id: str) -> MeshPart:
    """Return a small cube at the position of a room's lamp."""
    builder = PartBuilder()
    frame = np.vstack([np.eye(3), lamp_position(house, room_id)])
    low, high = (-_LAMP_M,) * 3, (_LAMP_M,) * 3
    builder.box(frame, low, high, (255, 244, 214))
    return builder.build(f"{room_id}/lamp", extras={"level": house.level_of(room_id).id})


def _placed(part: MeshPart, low: np.ndarray, storeys: Mapping[str, str]) -> MeshPart:
    """Return a part in the card's units, with its storey in its name; `low` (metres) is the origin.

    The height y is not moved.
    """
    mesh = part.mesh.copy()
    normals = np.array(part.mesh.vertex_normals)
    mesh.vertices = np.round((mesh.vertices - low * [1, 0, 1]) * _PER_M, 3)
    mesh.vertex_normals = normals
    storey = storeys.get(str(part.extras.get("level", "")), "")
    return replace(part, mesh=mesh, name=storey + part.name)
