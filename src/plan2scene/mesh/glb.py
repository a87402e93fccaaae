"""glTF 2.0 binary: every part a named node, textures embedded, PBR metallic 0 roughness 1."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene import __version__
from plan2scene.house import House, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.mesh.house_mesh import build_parts
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.textures import UNTEXTURED, TileTexture

#: Linear base colour and opacity of window glass.
GLASS = (0.62, 0.75, 0.80, 0.28)

_FLOAT, _UINT, _USHORT = 5126, 5125, 5123
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_REPEAT, _LINEAR, _MIPMAP = 10497, 9729, 9987


def write_glb(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    path: str | Path,
    parts: Sequence[MeshPart] | None = None,
) -> None:
    """Write a house as GLB: metres, y up, UV = metres / tile size with repeat wrapping.

    Surfaces without a texture get a plain colour. The same input gives the same bytes.

    Parameters
    ----------
    house : House
    textures : mapping of SurfaceKey to TileTexture
    path : path
        Written atomically.
    parts : sequence of MeshPart, optional
        What :func:`~plan2scene.mesh.build_parts` returned, when at hand.
    """
    document = _Document(house, textures)
    for part in build_parts(house) if parts is None else parts:
        document.add(part)
    with atomic_path(path) as temporary:
        temporary.write_bytes(document.pack())


def linear(colour: Sequence[int] | np.ndarray) -> np.ndarray:
    """Return sRGB 0..255 as linear float64 0..1."""
    value = np.asarray(colour, dtype=np.float64) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


class _Document:
    """A glTF document in the making: JSON tables and one binary buffer."""

    def __init__(self, house: House, textures: Mapping[SurfaceKey, TileTexture]) -> None:
        self.house, self.textures = house, textures
        self.data = bytearray()
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"plan2scene {__version__}"},
            "scene": 0,
            "scenes": [{"name": house.id, "nodes": [0], "extras": self._scene_extras()}],
            "nodes": [{"name": house.id, "children": []}],
            "meshes": [],
            "materials": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }
        self._materials: dict[object, int] = {}
        self._images: dict[str, int] = {}

    def _scene_extras(self) -> dict[str, Any]:
        """Return the rooms' ids, types and heights for viewers."""
        rooms = [{"id": r.id, "types": list(r.types), "height": r.height} for r in self.house.rooms]
        return {"house": self.house.id, "rooms": rooms}

    def add(self, part: MeshPart) -> None:
        """Add a part as a node with a mesh of one primitive."""
        position = part.vertices.astype(np.float32)
        attributes = {
            "POSITION": self._accessor(position, "VEC3", bounds=True),
            "NORMAL": self._accessor(part.normals.astype(np.float32), "VEC3"),
        }
        tile = None if part.surface is None else self.textures.get(part.surface)
        if part.uv is not None and tile is not None:
            uv = tile.turns(part.uv).astype(np.float32)
            attributes["TEXCOORD_0"] = self._accessor(uv, "VEC2")
        if part.colours is not None:
            colours = linear(part.colours).astype(np.float32)
            attributes["COLOR_0"] = self._accessor(colours, "VEC3")
        small = len(position) < 65535
        index = part.faces.reshape(-1).astype(np.uint16 if small else np.uint32)
        primitive = {
            "attributes": attributes,
            "indices": self._accessor(index, "SCALAR", target=_ELEMENT_BUFFER),
            "material": self._material(part, tile),
        }
        self.json["meshes"].append({"name": part.name, "primitives": [primitive]})
        node = {
            "name": part.name,
            "mesh": len(self.json["meshes"]) - 1,
            "extras": self._extras(part, tile),
        }
        self.json["nodes"].append(node)
        self.json["nodes"][0]["children"].append(len(self.json["nodes"]) - 1)

    def _extras(self, part: MeshPart, tile: TileTexture | None) -> dict[str, Any]:
        """Return what viewers show about a part."""
        extras = dict(part.extras)
        if part.surface is not None and tile is not None:
            extras["size_m"] = tile.size_m
            facts = {
                "observed": tile.observed,
                "substance": tile.substance,
                "source": tile.source or None,
            }
            extras.update({name: value for name, value in facts.items() if value is not None})
        return extras

    def _material(self, part: MeshPart, tile: TileTexture | None) -> int:
        """Return the index of a part's material, made on first use."""
        key = part.surface or part.material
        if key in self._materials:
            return self._materials[key]
        pbr: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": 1.0}
        material: dict[str, Any] = {"name": part.material, "pbrMetallicRoughness": pbr}
        if part.material == "glass":
            pbr.update(baseColorFactor=list(GLASS), roughnessFactor=0.1)
            material.update(alphaMode="BLEND", doubleSided=True)
        elif part.surface is not None:
            material["name"] = part.surface.filename
            if tile is None:
                colour = linear(UNTEXTURED[part.surface.surface])
                pbr["baseColorFactor"] = [round(float(c), 6) for c in colour] + [1.0]
            else:
                pbr["baseColorTexture"] = {"index": self._texture(part.surface, tile)}
        self.json["materials"].append(material)
        self._materials[key] = len(self.json["materials"]) - 1
        return self._materials[key]

    def _texture(self, key: SurfaceKey, tile: TileTexture) -> int:
        """Return the index of the texture of a tile; equal tiles are embedded once."""
        if tile.digest not in self._images:
            view = self._view(tile.png)
            images = self.json.setdefault("images", [])
            images.append({"name": key.filename, "mimeType": "image/png", "bufferView": view})
            sampler = {
                "magFilter": _LINEAR,
                "minFilter": _MIPMAP,
                "wrapS": _REPEAT,
                "wrapT": _REPEAT,
            }
            self.json["samplers"] = [sampler]
            textures = self.json.setdefault("textures", [])
            textures.append({"sampler": 0, "source": len(images) - 1})
            self._images[tile.digest] = len(textures) - 1
        return self._images[tile.digest]

    def _view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes to the buffer, aligned to 4; return the index of their view."""
        self.data.extend(b"\0" * (-len(self.data) % 4))
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.data.extend(data)
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def _accessor(
        self, values: np.ndarray, kind: str, *, target: int = _ARRAY_BUFFER, bounds: bool = False
    ) -> int:
        """Append an array to the buffer; return the index of its accessor."""
        component = {"f": _FLOAT, "u": _USHORT if values.itemsize == 2 else _UINT}
        accessor: dict[str, Any] = {
            "bufferView": self._view(np.ascontiguousarray(values).tobytes(), target),
            "componentType": component[values.dtype.kind],
            "count": len(values),
            "type": kind,
        }
        if bounds:
            accessor["min"] = values.min(axis=0).astype(float).tolist()
            accessor["max"] = values.max(axis=0).astype(float).tolist()
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def pack(self) -> bytes:
        """Return the GLB: header, JSON chunk padded with spaces, binary chunk with zeros."""
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        size = 12 + 8 + len(text) + 8 + len(binary)
        head = struct.pack("<III", 0x46546C67, 2, size)
        return b"".join(
            [
                head,
                struct.pack("<II", len(text), 0x4E4F534A),
                text,
                struct.pack("<II", len(binary), 0x004E4942),
                binary,
            ]
        )
