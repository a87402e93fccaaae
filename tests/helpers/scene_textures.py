import base64
import json

from plan2scene.house import SurfaceKey


def scene_textures(path):
    """Return image bytes and metres per tile by surface (a room's first textured wall)."""
    arch = json.loads(path.read_text())["scene"]["arch"]
    by_id = {e["uuid"]: e for kind in ("materials", "textures", "images") for e in arch[kind]}
    found = {}
    for element in arch["elements"]:
        rooms = element["roomId"] if isinstance(element["roomId"], list) else [element["roomId"]]
        for room_id, material in zip(rooms, element["materials"], strict=False):
            if "materialId" in material:
                texture = by_id[by_id[material["materialId"]]["map"]]
                data = base64.b64decode(by_id[texture["image"]]["url"].split(",")[1], validate=True)
                key = SurfaceKey(room_id, element["type"].lower())
                found.setdefault(key, (data, texture["size_m"]))
    return found
