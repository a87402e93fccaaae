"""glTF 2.0 binary by trimesh's exporter: every part a named node, textures embedded, lamps, a sun.

`_finish` and `_File` do only what the exporter has no argument for: sampler, names, kinds of
buffers, colours that are not rounded to bytes, one copy of equal tiles, PNG files as they are.

Lamps and the sun are KHR_lights_punctual. Viewers do not adapt to brightness as eyes do, so lamps
as bright as real ones would burn out every surface. Their light is scaled: a viewer's own
environment light gives about pi lux, to which a lamp adds `Lights.lamp_lux` on a floor and the sun
`Lights.sun_lux`. Most viewers cast no shadows, so lamps are cones that look down and end where
their room ends.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from trimesh.exchange.gltf import export_glb
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from plan2scene import __version__
from plan2scene.colour import srgb_to_linear
from plan2scene.house import House, Room, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.baking import LAMP, LAMP_DROP_M, bake_occlusion, lamp_position
from plan2scene.mesh.parts import GLASS, MeshPart
from plan2scene.mesh.relief import normal_map, tangents
from plan2scene.mesh.texture_files import UNTEXTURED, TileTexture
from plan2scene.plans.geometry import room_polygon

#: Kinds of buffers, and the sampler of tiles: repeating, trilinear (the numbers are OpenGL's).
_VERTICES, _INDICES = 34962, 34963
_SAMPLER = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
#: Sampler of the occlusion: linear, clamped, without mipmaps, in which its parts would mix.
_PLAIN_SAMPLER = {"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}
#: Roughness by substance: waxed or glazed surfaces shine a little.
ROUGHNESS = {"wood": 0.6, "tile": 0.4, "plaster": 0.95, "carpet": 1.0}
#: Frame above the house's node; no id has a slash. The exporter leaves it out of the file.
_WORLD = "/"


def write_glb(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    path: str | Path,
    parts: Sequence[MeshPart] | None = None,
    *,
    unlit: bool = False,
    relief: bool = False,
) -> None:
    """Write a house as GLB, atomically: metres, y up, UV = metres / tile size with repeat wrapping.

    PBR metallic 0, roughness by substance; ambient occlusion of textured surfaces on TEXCOORD_1;
    a lamp in each room and a sun. Surfaces without a texture get a plain colour. `parts` are those
    of :func:`~plan2scene.mesh.assembly.assemble`, if already made. `unlit` shows colours as they
    are (KHR_materials_unlit), without occlusion and lamps; `relief` gives surfaces normal maps
    (:mod:`plan2scene.mesh.relief`). The same input gives the same bytes.
    """
    scene = trimesh.Scene(base_frame=_WORLD, metadata=_facts(house))
    scene.graph.update(frame_from=_WORLD, frame_to=house.id)
    for level in house.levels:
        facts = {"kind": "level", **asdict(level)}
        scene.graph.update(frame_from=house.id, frame_to=level_node(level.id), metadata=facts)
    materials: dict[object, PBRMaterial] = {}
    parts = assemble(house).parts if parts is None else parts
    textured = [part for part in parts if part.surface in textures]
    occlusion = None if unlit else bake_occlusion(parts, textured)
    shade = None if occlusion is None else _File(occlusion.png)
    for part in parts:
        tile = None if part.surface is None else textures.get(part.surface)
        key = part.surface or part.material
        if key not in materials:
            materials[key] = _material(part, tile, shade, relief=relief and not unlit)
        second = None if tile is None or occlusion is None else occlusion.uv[part.name]
        scene.add_geometry(
            _textured(part, tile, materials[key], second),
            node_name=part.name,
            geom_name=part.name,
            parent_node_name=level_node(str(part.extras.get("level", ""))) or house.id,
            metadata=_extras(part, tile),
        )
    factors = {"glass": list(GLASS)}
    for surface in house.surface_keys():
        if surface not in textures:
            colour = srgb_to_linear(np.array(UNTEXTURED[surface.kind], np.uint8))
            factors[surface.filename] = [round(float(c), 6) for c in colour] + [1.0]
    data = export_glb(
        scene,
        include_normals=True,
        tree_postprocessor=lambda tree: _finish(tree, house, factors, unlit=unlit),
    )
    with atomic_path(path) as temporary:
        temporary.write_bytes(data)


def level_node(level_id: str) -> str:
    """Return the name of a level's node; empty for none. No id has a colon."""
    return f"level:{level_id}" if level_id else ""


def _facts(house: House) -> dict[str, Any]:
    """Return what viewers show about a house."""
    rooms: list[dict[str, Any]] = []
    for room in house.rooms:
        own = {"id": room.id, "types": list(room.types), "height": room.height}
        own |= {"name": room.title} if room.title != " / ".join(room.types) else {}
        rooms.append({**own, "level": room.level} if house.levels else own)
    levels = {"levels": [asdict(level) for level in house.levels]} if house.levels else {}
    return {"house": house.id, "rooms": rooms, **levels}


class _File:
    """A PNG or JPEG file in the place of a PIL image: written as it is, not encoded again."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.format = "PNG" if data.startswith(b"\x89PNG") else "JPEG"

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        """Return the bytes: trimesh compares materials by them."""
        return np.frombuffer(self.data, dtype=np.uint8)

    def save(self, file: BinaryIO, format: str) -> None:
        """Write the file."""
        file.write(self.data)


def roughness(part: MeshPart, tile: TileTexture | None) -> float:
    """Return the roughness of a part's material, 0 (a mirror) to 1."""
    if part.material == "glass":
        return 0.1
    return 1.0 if tile is None else ROUGHNESS.get(tile.substance or "", 1.0)


def _material(
    part: MeshPart, tile: TileTexture | None, shade: _File | None, *, relief: bool
) -> PBRMaterial:
    """Return a part's material; `_finish` sets its plain colour."""
    glass = part.material == "glass"
    normals = None if tile is None or not relief else normal_map(tile)
    return PBRMaterial(
        name=part.material if part.surface is None else part.surface.filename,
        metallicFactor=0.0,
        roughnessFactor=roughness(part, tile),
        alphaMode="BLEND" if glass else None,
        doubleSided=glass,
        baseColorTexture=None if tile is None else _File(tile.image),
        occlusionTexture=None if tile is None else shade,
        normalTexture=None if normals is None else _File(normals),
    )


def _textured(
    part: MeshPart, tile: TileTexture | None, material: PBRMaterial, second: np.ndarray | None
) -> trimesh.Trimesh:
    """Return a part's mesh with its material, texture coordinates in tiles, linear colours.

    `second` are the texture coordinates in the occlusion.
    """
    uv = None
    if part.uv is not None and tile is not None:
        uv = tile.turns(part.uv) * [1, -1] + [0, 1]  # trimesh's v runs up the image
    attributes = {}
    if part.colours is not None:
        attributes["_COLOR_0"] = srgb_to_linear(part.colours).astype(np.float32)
    if second is not None:
        attributes["_TEXCOORD_1"] = second.astype(np.float32)
    if material.normalTexture is not None:
        attributes["_TANGENT"] = tangents(part)
    return trimesh.Trimesh(
        part.mesh.vertices,
        part.mesh.faces,
        vertex_normals=part.mesh.vertex_normals,
        vertex_attributes=attributes,
        visual=TextureVisuals(uv=uv, material=material),
        process=False,
    )


def _extras(part: MeshPart, tile: TileTexture | None) -> dict[str, Any]:
    """Return what viewers show about a part."""
    extras = dict(part.extras)
    if tile is not None:
        facts: dict[str, Any] = {
            "size_m": tile.size_m,
            "observed": tile.observed,
            "substance": tile.substance,
            "source": tile.source or None,
            "evidence": tile.evidence.get("words"),
        }
        if tile.extent_m is not None:
            facts["map_m"] = list(tile.extent_m)
            facts["pattern"] = tile.pattern or None
        extras.update({name: value for name, value in facts.items() if value is not None})
    return extras


def _finish(
    tree: dict[str, Any], house: House, factors: Mapping[str, list[float]], *, unlit: bool
) -> None:
    """Complete trimesh's glTF header in place; `factors` are base colours by material name."""
    tree["asset"]["generator"] = f"plan2scene {__version__}, trimesh {trimesh.__version__}"
    tree["scenes"][0]["name"] = house.id
    for mesh in tree["meshes"]:
        del mesh["extras"]
        primitive = mesh["primitives"][0]
        attributes = primitive["attributes"]
        # trimesh writes colours as bytes, too coarse if linear, and one UV set, and no tangents.
        for name in sorted(attributes.keys() & {"_COLOR_0", "_TANGENT", "_TEXCOORD_1"}):
            attributes[name[1:]] = attributes.pop(name)
        for target, used in (_VERTICES, attributes.values()), (_INDICES, [primitive["indices"]]):
            for accessor in used:
                view = tree["accessors"][accessor]["bufferView"]
                tree["bufferViews"][view]["target"] = target
    _join_images(tree, factors)
    if unlit:
        for material in tree["materials"]:
            material["extensions"] = {"KHR_materials_unlit": {}}
        tree["extensionsUsed"] = ["KHR_materials_unlit"]
    else:
        add_lights(tree, house)


def _join_images(tree: dict[str, Any], factors: Mapping[str, list[float]]) -> None:
    """Set plain colours, and make textures of equal files share one image, in place."""
    images: dict[int, dict[str, Any]] = {}  # by buffer view: equal files share one
    textures: list[dict[str, int]] = []

    def use(texture: dict[str, Any], name: str, sampler: int) -> None:
        image = tree["images"][texture["index"]]
        images.setdefault(image["bufferView"], {"name": name, **image})
        entry = {"sampler": sampler, "source": list(images).index(image["bufferView"])}
        if entry not in textures:
            textures.append(entry)
        texture["index"] = textures.index(entry)

    for material in tree["materials"]:
        pbr = material["pbrMetallicRoughness"]
        if material["name"] in factors:
            pbr["baseColorFactor"] = factors[material["name"]]
        if "baseColorTexture" in pbr:
            use(pbr["baseColorTexture"], material["name"], 0)
        if "normalTexture" in material:
            use(material["normalTexture"], f"{material['name']}_normal", 0)
        if "occlusionTexture" in material:
            use(material["occlusionTexture"], "occlusion", 1)
            material["occlusionTexture"]["texCoord"] = 1
    if images:
        tree["images"] = list(images.values())
        tree["samplers"] = [_SAMPLER, _PLAIN_SAMPLER][: max(t["sampler"] for t in textures) + 1]
        tree["textures"] = textures


EXTENSION = "KHR_lights_punctual"


@dataclass(frozen=True)
class Lights:
    """Light of lamps and of the sun; angles in radians."""

    lamp_lux: float = 0.8  #: mean light of a lamp on its room's floor
    sun_lux: float = 0.6  #: light of the sun on a surface that faces it
    sun: tuple[float, float, float] = (1.0, 0.97, 0.9)  #: its colour, linear RGB
    to_sun: tuple[float, float, float] = (-0.45, 0.78, 0.43)  #: direction: high, south-west
    whole: float = math.radians(35.0)  #: half angle of the inner cone, of a lamp's full intensity
    cone: float = math.radians(82.0)  #: half angle of a lamp's cone


LIGHTS = Lights()


#: A glTF light shines along the -z axis of its node.
_AHEAD = np.array([0.0, 0.0, -1.0])
_DECIMALS = 5


def add_lights(tree: dict[str, Any], house: House) -> None:
    """Add a house's lights to a glTF header in place, below the node that has the house's name."""
    lights: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    for room in house.rooms:
        if not room.open_air:
            lights.append(_lamp(room))
            nodes.append(_node(f"{room.id}/lamp", lamp_position(house, room.id), [0, -1, 0]))
            nodes[-1]["extras"] = {"kind": "lamp", "room_id": room.id}
    sun = {"type": "directional", "color": list(LIGHTS.sun), "intensity": LIGHTS.sun_lux}
    lights.append({**sun, "name": "sun"})
    points = np.array([point for room in house.rooms for point in room.rings[0]])
    x, z = (points.min(axis=0) + points.max(axis=0)) / 2
    over = np.array([x, 0.0, z]) + 10.0 * np.array(LIGHTS.to_sun)  # where programs draw the sun
    nodes.append(_node("sun", over, -np.array(LIGHTS.to_sun)))
    nodes[-1]["extras"] = {"kind": "sun"}
    for number, node in enumerate(nodes):
        node["extensions"] = {EXTENSION: {"light": number}}
    root = next(node for node in tree["nodes"] if node.get("name") == house.id)
    first = len(tree["nodes"])
    tree["nodes"].extend(nodes)
    root["children"] = [*root.get("children", []), *range(first, first + len(nodes))]
    tree.setdefault("extensions", {})[EXTENSION] = {"lights": lights}
    tree["extensionsUsed"] = [*tree.get("extensionsUsed", []), EXTENSION]


def _lamp(room: Room) -> dict[str, Any]:
    """Return the lamp of a room: the mean light on the floor is `LIGHTS.lamp_lux`.

    It is computed for a disk of the floor's area below a lamp that is equally bright each way.
    """
    polygon = room_polygon(room)
    height = max(room.height - LAMP_DROP_M, 0.5)
    square = polygon.area / math.pi
    share = 1 - height / math.sqrt(height**2 + square)
    x0, z0, x1, z1 = polygon.bounds
    return {
        "type": "spot",
        "color": LAMP.tolist(),
        "intensity": round(LIGHTS.lamp_lux * square / (2 * share), _DECIMALS),
        "range": round(math.hypot(x1 - x0, z1 - z0, height), _DECIMALS),
        "spot": {"innerConeAngle": LIGHTS.whole, "outerConeAngle": LIGHTS.cone},
        "name": f"{room.id}/lamp",
    }


def _node(name: str, place: np.ndarray, way: ArrayLike) -> dict[str, Any]:
    """Return the node of a light at `place` that shines along `way`, both (3,)."""
    along = np.asarray(way, dtype=np.float64)
    along = along / np.linalg.norm(along)
    turn = np.append(np.cross(_AHEAD, along), 1.0 + _AHEAD @ along)  # half way between both
    turn /= np.linalg.norm(turn)
    return {
        "name": name,
        "translation": [round(float(value), _DECIMALS) for value in place],
        "rotation": [float(value) for value in turn],
    }
