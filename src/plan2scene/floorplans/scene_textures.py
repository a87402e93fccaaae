"""Reader of the textures embedded in a scene.json."""

from __future__ import annotations

import base64
import binascii
from pathlib import Path
from typing import Any

from plan2scene.floorplans.parse import Source, parse_json
from plan2scene.floorplans.scene_json import find_arch
from plan2scene.floorplans.scene_walls import room_ids_of
from plan2scene.house import SurfaceKey
from plan2scene.io import read_text


def read_scene_textures(
    path: str | Path, house_id: str
) -> dict[SurfaceKey, tuple[bytes, float | None]]:
    """Return the textures embedded in a scene.json: image bytes and metres per tile by surface.

    A room's wall texture is that of its first textured wall (inner side). The size is None in
    files of other programs, which don't state it.
    """
    source = Source(str(path), house_id)
    _, arch = find_arch(source, parse_json(read_text(path), path, house_id))
    by_id: dict[str, dict[str, Any]] = {}
    for kind in ("materials", "textures", "images"):
        for entry in source.items(arch.get(kind), kind):
            by_id[str(source.mapping(entry, kind).get("uuid"))] = entry
    found: dict[SurfaceKey, tuple[bytes, float | None]] = {}
    for element in source.items(arch.get("elements"), "elements"):
        surface = str(source.mapping(element, "an element").get("type")).lower()
        used = source.items(element.get("materials"), "an element's materials")
        for room_id, material in zip(room_ids_of(source, element), used, strict=False):
            key = SurfaceKey(room_id, surface)
            name = source.mapping(material, "a material").get("materialId")
            if name is None or key in found:
                continue
            texture = by_id.get(str(by_id.get(str(name), {}).get("map")), {})
            image = by_id.get(str(texture.get("image")), {})
            size = texture.get("size_m")
            metres = None if size is None else source.number(size, "size_m", room_id)
            found[key] = (_image_bytes(source, image.get("url"), room_id), metres)
    return found


def _image_bytes(source: Source, url: Any, room: str) -> bytes:
    """Return the bytes of a data URL (`data:img/png` and `data:image/png` alike)."""
    head, comma, body = url.partition(",") if isinstance(url, str) else ("", "", "")
    if not comma or not head.startswith(("data:img/", "data:image/")):
        raise source.fault("a data URL of an image", repr(url)[:60], room)
    try:
        return base64.b64decode(body, validate=True)
    except binascii.Error as error:
        raise source.fault("base64 of an image", str(error), room) from None
