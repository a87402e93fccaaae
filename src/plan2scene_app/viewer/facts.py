"""What the viewer tells of a surface beside the GLB: its photo and crop, or how sure it is."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

import cv2

from plan2scene.house import House
from plan2scene.images import image_from_bytes
from plan2scene.io import read_json

#: Quality of the crops' JPEG files.
_QUALITY = 85
#: What the viewer needs of an entry of cameras.json.
_CAMERA = ("width", "height", "focal_px", "rotation", "position", "room_id", "located")


def read_facts(
    propagated: str | Path,
    crops: str | Path,
    cameras: str | Path | None,
    house: House | None = None,
) -> dict[str, Any]:
    """Return what :func:`build_viewer` puts into the page, as plain JSON values.

    Parameters
    ----------
    propagated : path
        ``propagated.parquet`` of the house with every photo shown.
    crops : path
        ``crops.parquet``.
    cameras : path or None
        ``cameras.json`` of located photos; None where crops came ready and no photo was read.
    house : House, optional
        Its levels lift the cameras; without it all is one storey at 0.

    Returns
    -------
    dict
        ``surfaces``: ``{"room/surface": {"photo", "crop"}}`` of observed ones, the chosen crop as
        a data URL; ``{"confidence", "source"}`` of the others. ``photos``: ``[{"name", "number"}]``
        by name, located ones with their camera (metres, world to camera).
    """
    import pyarrow.parquet as pq

    columns = ["room_id", "surface", "observed", "source", "confidence"]
    rows = pq.ParquetFile(propagated).read(columns).to_pylist()
    shown = {row["source"] for row in rows if row["observed"]}
    pictures = pq.ParquetFile(crops).read(["crop_id", "photo", "png"])
    by_id = {row["crop_id"]: row for row in pictures.to_pylist() if row["crop_id"] in shown}
    taken = {} if cameras is None else read_json(cameras)
    names = sorted(taken.keys() | set(pictures.column("photo").to_pylist()))
    return {
        "surfaces": {f"{row['room_id']}/{row['surface']}": _surface(row, by_id) for row in rows},
        "photos": [
            {"name": name, "number": number, **_camera(taken.get(name, {}), house)}
            for number, name in enumerate(names, 1)
        ],
    }


def _surface(row: dict[str, Any], crops: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the facts of one row of propagated.parquet."""
    if row["observed"]:
        crop = crops.get(row["source"])
        return {} if crop is None else {"photo": crop["photo"], "crop": _data_url(crop["png"])}
    confidence = row["confidence"]
    known = confidence is not None and confidence == confidence  # NaN: nobody says
    return {"confidence": round(confidence, 4) if known else None, "source": row["source"]}


def _data_url(png: bytes) -> str:
    """Return a crop as a small JPEG in a data URL."""
    image = cv2.cvtColor(image_from_bytes(png), cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return f"data:image/jpeg;base64,{base64.b64encode(data.tobytes()).decode('ascii')}"


def _camera(entry: dict[str, Any], house: House | None) -> dict[str, Any]:
    """Return a located photo's camera, its position in the house; nothing of others."""
    if entry.get("position") is None:
        return {}
    camera = {name: entry[name] for name in _CAMERA}
    if house is not None and house.levels:
        x, y, z = camera["position"]
        y += house.level_of(camera["room_id"]).elevation
        camera["position"] = [x, round(y, 4), z]
    return camera
