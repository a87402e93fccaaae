"""What a house shows in the user study: its plan, its photos, and a render of each method."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import atomic_directory, write_json
from plan2scene.mesh.preview import render_from_above, render_plan
from plan2scene.mesh.textures import load_textures
from plan2scene.photos.photo_files import read_photo

#: Side in pixels of plan and renders, and the longer side of photos.
RENDER_SIDE, PLAN_SIDE, PHOTO_SIDE = 720, 560, 320
_QUALITY = 88


def write_study_sheet(
    output: str | Path,
    *,
    house: House,
    photos: Mapping[str, Path],
    rooms_of_photo: Mapping[str, Sequence[str]],
    textures: Mapping[str, Path],
) -> None:
    """Write a folder with ``plan.jpg``, ``photo_{n}.jpg``, ``{method}.jpg`` and ``sheet.json``.

    The renders are from straight above without ceilings. Rooms in the plan name the numbers of
    their photos. ``sheet.json``: ``{"house", "photos": [file names], "methods": [...]}``.

    Parameters
    ----------
    photos : mapping
        Photo name to its file; those that cannot be read are left out, with a warning.
    rooms_of_photo : mapping
        Photo name to the rooms it shows.
    textures : mapping
        Method to the folder that it left.
    """
    with atomic_directory(output) as folder:
        folder.mkdir(parents=True, exist_ok=True)
        shown: list[str] = []
        numbers: dict[str, list[int]] = {}
        for name in sorted(rooms_of_photo):
            if name not in photos:
                continue
            try:
                image = read_photo(photos[name], house=house.id)
            except InputError as error:
                logging.getLogger("plan2scene").warning("%s", error)
                continue
            shown.append(f"photo_{len(shown) + 1}.jpg")
            _write_jpeg(folder / shown[-1], _reduced(image))
            for room in rooms_of_photo[name]:
                numbers.setdefault(room, []).append(len(shown))
        captions = {room.id: _caption(numbers.get(room.id, [])) for room in house.rooms}
        _write_jpeg(folder / "plan.jpg", render_plan(house, captions, PLAN_SIDE))
        for method, tiles in textures.items():
            render = render_from_above(house, load_textures(tiles, house), RENDER_SIDE)
            _write_jpeg(folder / f"{method}.jpg", render)
        sheet = {"house": house.id, "photos": shown, "methods": list(textures)}
        write_json(folder / "sheet.json", sheet)


def _caption(numbers: Sequence[int]) -> str:
    """Return what a room's label says of its photos."""
    if not numbers:
        return "no photo"
    return f"photo{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))}"


def _reduced(image: np.ndarray) -> np.ndarray:
    """Return an (h, w, 3) uint8 image whose longer side is at most `PHOTO_SIDE`."""
    scale = PHOTO_SIDE / max(image.shape[:2])
    if scale >= 1:
        return image
    size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def _write_jpeg(path: Path, image: np.ndarray) -> None:
    """Write an (h, w, 3) uint8 sRGB image as JPEG."""
    Image.fromarray(image).save(path, quality=_QUALITY, subsampling=0)
