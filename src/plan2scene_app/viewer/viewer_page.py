"""viewer.html: style, three.js, program, GLB and facts in one page that needs no network."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.images import (
    MAX_PHOTO_PIXELS,
    decode_image,
    image_from_bytes,
    jpeg_bytes,
    to_small_srgb,
)
from plan2scene.io import atomic_path
from plan2scene.stage_json import read_stage_json
from plan2scene_app.html_page import html_page, inline_json, source_hash

_FOLDER = Path(__file__).parent
#: The program's files, in the order in which they go into the page.
PROGRAM = (
    *("house.js", "light.js", "eye.js", "sight.js", "walk.js", "travel.js", "map.js"),
    *("tools.js", "headset.js", "viewer.js"),
)
#: Facts of a house of which only the GLB is known.
NO_FACTS: Mapping[str, Any] = {"surfaces": {}, "photos": []}


def build_viewer(
    glb: str | Path,
    output: str | Path,
    *,
    house_id: str,
    title: str = "",
    facts: Mapping[str, Any] = NO_FACTS,
) -> None:
    """Write the viewer of a house.

    The page's content policy allows only its own two scripts and its style, by their hashes, and no
    requests. Names are escaped; the program shows them as text.

    Parameters
    ----------
    glb : path
        The house as :func:`plan2scene.mesh.write_glb` makes it.
    output : path
        An HTML file; it opens from the disk in any browser with WebGL 2.
    house_id : str
    title : str
        The house's name for people; by default its id.
    facts : mapping
        What a click on a surface or photo shows, see :func:`read_facts`.

    Raises
    ------
    InputError
        If `glb` is not a GLB file.
    """
    data = Path(glb).read_bytes()
    if data[:4] != b"glTF":
        raise InputError("a GLB file", f"bytes {data[:4]!r}", file=glb, house=house_id)
    style = _text("viewer.css")
    library = _text("three.min.js")
    program = "\n".join(_text(name) for name in PROGRAM)
    scripts = f"{source_hash(library)} {source_hash(program)}"
    policy = (
        f"default-src 'none'; script-src {scripts}; style-src {source_hash(style)}; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    page = html_page(
        _FOLDER / "viewer.html",
        title=title or house_id,
        style=style,
        policy=policy,
        library=library,
        program=program,
        facts=inline_json(facts),
        glb=base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii"),
    )
    with atomic_path(output) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _text(name: str) -> str:
    """Return the text of a file in this package."""
    return (_FOLDER / name).read_text(encoding="utf-8")


#: JPEG quality of the crops.
_QUALITY = 85
#: Longer side in pixels, and JPEG quality, of the photos that the page shows over the house.
_PHOTO_PX, _PHOTO_QUALITY = 560, 60
#: Keys of an entry of cameras.json that the viewer needs.
_CAMERA = ("width", "height", "focal_px", "rotation", "position", "room_id", "located")


def read_facts(
    propagated: str | Path,
    crops: str | Path,
    cameras: str | Path | None,
    house: House | None = None,
    photos: Path | None = None,
) -> dict[str, Any]:
    """Return what :func:`build_viewer` puts into the page, as plain JSON values.

    Parameters
    ----------
    propagated : path
        ``propagated.parquet`` of the house with every photo shown.
    crops : path
        ``crops.parquet``.
    cameras : path or None
        ``cameras.json`` of located photos; None if crops were ready-made and no photo was read.
    house : House, optional
        Cameras are lifted by the elevations of its levels; without it there is one level at 0.
    photos : path, optional
        Folder of the photos; reduced copies of the located ones are put into the page.

    Returns
    -------
    dict
        ``surfaces``: ``{"room/surface": {"photo", "crop"}}`` for observed ones, with the chosen
        crop as a data URL; ``{"confidence", "source"}`` for the others. ``photos``: ``[{"name",
        "number"}]`` by name; located ones also have their camera (metres, world to camera) and, if
        `photos` is given, their ``image`` (a data URL).
    """
    import pyarrow.parquet as pq

    columns = ["room_id", "surface", "observed", "source", "confidence"]
    rows = pq.ParquetFile(propagated).read(columns).to_pylist()
    chosen = {row["source"] for row in rows if row["observed"]}
    pictures = pq.ParquetFile(crops).read(["crop_id", "photo", "png"])
    by_id = {row["crop_id"]: row for row in pictures.to_pylist() if row["crop_id"] in chosen}
    taken = {} if cameras is None else read_stage_json(cameras, "cameras", house=house)
    names = sorted(taken.keys() | set(pictures.column("photo").to_pylist()))
    return {
        "surfaces": {f"{row['room_id']}/{row['surface']}": _surface(row, by_id) for row in rows},
        "photos": [
            {"name": name, "number": number, **_camera(name, taken.get(name, {}), house, photos)}
            for number, name in enumerate(names, 1)
        ],
    }


def _surface(row: dict[str, Any], crops: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the facts of one row of propagated.parquet."""
    if row["observed"]:
        crop = crops.get(row["source"])
        return (
            {}
            if crop is None
            else {"photo": crop["photo"], "crop": _data_url(image_from_bytes(crop["png"]))}
        )
    confidence = row["confidence"]
    known = confidence is not None and confidence == confidence  # NaN: unknown
    return {"confidence": round(confidence, 4) if known else None, "source": row["source"]}


def _data_url(image: np.ndarray, quality: int = _QUALITY) -> str:
    """Return (h, w, 3) uint8 sRGB as a JPEG in a data URL."""
    data = base64.b64encode(jpeg_bytes(image, quality=quality)).decode("ascii")
    return f"data:image/jpeg;base64,{data}"


def _small(photo: Path) -> np.ndarray:
    """Return a photo (h, w, 3) uint8 sRGB, its longer side at most `_PHOTO_PX`."""
    image = decode_image(
        photo, lambda opened: to_small_srgb(opened, _PHOTO_PX), max_pixels=MAX_PHOTO_PIXELS
    )
    share = min(1.0, _PHOTO_PX / max(image.shape[:2]))
    return cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)


def _camera(
    name: str, entry: dict[str, Any], house: House | None, photos: Path | None
) -> dict[str, Any]:
    """Return a photo's camera with its position in the house; empty if it is not located."""
    if entry.get("position") is None or entry.get("room_id") is None:
        return {}
    camera = {name: entry[name] for name in _CAMERA}
    if house is not None and house.levels:
        x, y, z = camera["position"]
        y += house.level_of(camera["room_id"]).elevation
        camera["position"] = [x, round(y, 4), z]
    if photos is not None and (photos / name).is_file():
        camera["image"] = _data_url(_small(photos / name), _PHOTO_QUALITY)
    return camera
