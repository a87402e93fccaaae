"""Writer of scene.json in the official form, with textures when there are any."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from plan2scene.house import Door, House, Opening, Room, SurfaceKey, Wall
from plan2scene.io import write_json

#: Thickness in metres of floor and ceiling plates, as in the reference converter.
PLATE_DEPTH = 0.05
#: Colour of an untextured surface.
PLAIN = "#e6e2dc"


def house_to_scene(
    house: House, textures: Mapping[SurfaceKey, tuple[bytes, float]] | None = None
) -> dict[str, Any]:
    """Return a house in metres as a scene.json document (JSON values only), without its warnings.

    `textures` are PNG bytes and metres per tile of each surface; a surface without one gets a
    plain colour. They are embedded as ``data:img/png;base64,...`` through materials, textures and
    images; the metres go into the texture's own key ``size_m``.

    Beyond the official form: ``size_m``, ``heights`` (`House.heights`), ``"passage": true`` on a
    hole of type Door that has no leaf, ``"guessed": true`` on a guessed hole, ``name`` of house and
    rooms, ``arch.icons``, ``arch.stairs`` and, for a house with levels, ``arch.levels`` and the
    ``level`` of each room, icon and flight.
    Programs that don't know these keys can ignore them: points have the elevation of their level.
    """
    textures = textures or {}
    elements: list[dict[str, Any]] = []
    elevations = {room.id: house.level_of(room.id).elevation for room in house.rooms}
    for room in house.rooms:
        y = elevations[room.id]
        elements += [_plate(room, "Floor", textures, y), _plate(room, "Ceiling", textures, y)]
    for wall in house.walls:
        sides = [house.wall_key(room_id, wall.id) for room_id in wall.room_ids]
        elements.append(_wall(wall, sides, textures, elevations[wall.room_ids[0]]))
    arch: dict[str, Any] = {
        "id": house.id,
        **({"name": house.name} if house.name else {}),
        **({"heights": house.heights} if house.heights else {}),
        "defaults": {
            "Wall": {"depth": 0.1, "extraHeight": 0.035},
            "Ceiling": {"depth": PLATE_DEPTH},
            "Floor": {"depth": PLATE_DEPTH},
        },
        "elements": elements,
        "rdr": _rdr(house.doors),
        "rooms": [
            {
                "id": room.id,
                **({"name": room.name} if room.name else {}),
                "types": list(room.types),
                **_on(room.level),
            }
            for room in house.rooms
        ],
        **_storeys(house),
    }
    used = [key for key in house.surface_keys() if key in textures]
    if used:
        arch.update(_images(used, textures))
    if house.icons:
        arch["icons"] = [
            {
                "type": icon.type,
                "bound_box": {"p1": list(icon.p1), "p2": list(icon.p2)},
                **_on(icon.level),
            }
            for icon in house.icons
        ]
    return {"format": "sceneState", "scene": _scene(house, arch), "selected": []}


def _on(level_id: str) -> dict[str, str]:
    """Return the entry ``level`` of a room, icon or flight; none in a house without levels."""
    return {"level": level_id} if level_id else {}


def _storeys(house: House) -> dict[str, Any]:
    """Return the entries of levels and stairs that a house has."""
    entries: dict[str, Any] = {}
    if house.levels:
        entries["levels"] = [asdict(level) for level in house.levels]
    if house.stairs:
        entries["stairs"] = [
            {
                "id": stairs.id,
                "from": list(stairs.start),
                "to": list(stairs.end),
                "width": stairs.width,
                **_on(stairs.level),
            }
            for stairs in house.stairs
        ]
    return entries


def write_scene_json(
    house: House,
    path: str | Path,
    textures: Mapping[SurfaceKey, tuple[bytes, float]] | None = None,
    evidence: Mapping[SurfaceKey, Mapping[str, Any]] | None = None,
) -> None:
    """Write a house as scene.json, atomically; see :func:`house_to_scene`.

    `evidence` (how the look of a surface is known) is written beside the scene, by
    ``room/surface``.
    """
    scene = house_to_scene(house, textures)
    if evidence:
        scene["evidence"] = {"/".join(key): dict(value) for key, value in evidence.items()}
    write_json(path, scene)


def _scene(house: House, arch: dict[str, Any]) -> dict[str, Any]:
    """Return the scene around `arch`."""
    objects = [
        {
            "modelId": item.model_id,
            "index": item.index,
            "parentIndex": item.parent_index,
            "transform": {"rows": 4, "cols": 4, "data": list(item.transform)},
        }
        for item in house.objects
    ]
    return {
        "up": {"x": 0, "y": 1, "z": 0},
        "front": {"x": 0, "y": 0, "z": 1},
        "unit": 1,
        "assetSource": ["3dw"],
        "assetTransforms": {
            "3dw": {
                "alignTo": {"up": [0, 1, 0], "front": [0, 0, 1]},
                "scaleTo": 1,
                "centerTo": [0.5, 0, 0.5],
            }
        },
        "arch": arch,
        "object": objects,
    }


def _material(key: SurfaceKey | None, textures: Mapping[SurfaceKey, Any], name: str) -> Any:
    """Return an element's material entry: a texture's id, else a plain colour."""
    if key in textures and key is not None:
        return {"name": name, "materialId": f"Material_{key.filename}"}
    return {"name": name, "diffuse": PLAIN}


def _plate(room: Room, kind: str, textures: Mapping[SurfaceKey, Any], y: float) -> dict[str, Any]:
    """Return the Floor or Ceiling element of a room whose floor is at height `y`."""
    element: dict[str, Any] = {
        "id": f"{room.id}_{kind[0].lower()}",
        "roomId": room.id,
        "type": kind,
        "points": [[[x, y, z] for x, z in ring] for ring in room.rings],
        "materials": [_material(SurfaceKey(room.id, kind.lower()), textures, "surface")],
        "depth": PLATE_DEPTH,
    }
    if kind == "Ceiling":
        element["offset"] = [0, room.height, 0]
    return element


def _wall(
    wall: Wall, sides: Sequence[SurfaceKey], textures: Mapping[SurfaceKey, Any], y: float
) -> dict[str, Any]:
    """Return a Wall element that stands at height `y`; the inner side is the first of `sides`."""
    inside, outside = [*sides, None][:2]
    return {
        "id": wall.id,
        "roomId": list(wall.room_ids) if len(wall.room_ids) > 1 else wall.room_ids[0],
        "type": "Wall",
        "points": [[x, y, z] for x, z in (wall.start, wall.end)],
        "holes": [_hole(opening) for opening in wall.openings],
        "materials": [
            _material(inside, textures, "inside"),
            _material(outside, textures, "outside"),
        ],
        "height": wall.height,
        "depth": wall.depth,
        "extra_height": wall.extra_height,
    }


def _hole(opening: Opening) -> dict[str, Any]:
    """Return a hole; a passage is a Door without a leaf."""
    hole: dict[str, Any] = {
        "id": opening.id,
        "type": "Window" if opening.kind == "window" else "Door",
        "box": {"min": [opening.start, opening.bottom], "max": [opening.end, opening.top]},
    }
    if opening.kind == "passage":
        hole["passage"] = True
    if opening.guessed:
        hole["guessed"] = True
    return hole


def _rdr(doors: tuple[Door, ...]) -> list[list[str | None]]:
    """Return the triples (room, hole, room); a door between two rooms has one for each direction.

    In the paper's data a door is a hole in each room's own wall, with an entry for each direction;
    then none is added.
    """
    own = {(door.room_a, door.room_b) for door in doors}
    triples: list[list[str | None]] = []
    for door in doors:
        triples.append([door.room_a, door.opening_id, door.room_b])
        if door.room_b is not None and (door.room_b, door.room_a) not in own:
            triples.append([door.room_b, door.opening_id, door.room_a])
    return triples


def _images(
    keys: list[SurfaceKey], textures: Mapping[SurfaceKey, tuple[bytes, float]]
) -> dict[str, list[dict[str, Any]]]:
    """Return the materials, textures and images of `keys`."""
    names = [key.filename for key in keys]
    return {
        "materials": [{"uuid": f"Material_{n}", "map": f"Texture_{n}"} for n in names],
        "textures": [
            {"uuid": f"Texture_{n}", "image": f"Image_{n}", "size_m": textures[key][1]}
            for n, key in zip(names, keys, strict=True)
        ],
        "images": [
            {
                "uuid": f"Image_{n}",
                "url": "data:img/png;base64," + base64.b64encode(textures[key][0]).decode("ascii"),
            }
            for n, key in zip(names, keys, strict=True)
        ],
    }
