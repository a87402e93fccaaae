"""The pictures of a house in the user study: its plan, its photos, and a render of each method."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

from PIL import Image

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import atomic_directory, write_json
from plan2scene.mesh.texture_files import textured
from plan2scene.photos.photo_files import read_photo
from plan2scene_app.pictures.preview import render_from_above, render_plan

#: Side in pixels of plan and renders, and the longer side of photos.
RENDER_SIDE, PLAN_SIDE, PHOTO_SIDE = 720, 560, 320


def write_study_sheet(
    output: str | Path,
    *,
    house: House,
    photos: Mapping[str, Path],
    rooms_of_photo: Mapping[str, Sequence[str]],
    textures: Mapping[str, Path],
) -> None:
    """Write a folder with ``plan.jpg``, ``photo_{n}.jpg``, ``{method}.jpg`` and ``sheet.json``.

    The renders are from straight above without ceilings. Each room's label in the plan has the
    numbers of its photos. ``sheet.json``: ``{"house", "photos": [file names], "methods": [...]}``.

    `photos` maps a photo's name to its file; a photo that cannot be read is left out, with a
    warning. `rooms_of_photo` maps a photo's name to its rooms, `textures` a method to its folder.
    """
    pictures: dict[str, Image.Image] = {}
    numbers: dict[str, list[str]] = {room.id: [] for room in house.rooms}
    for name in sorted(set(rooms_of_photo) & set(photos)):
        try:
            picture = Image.fromarray(read_photo(photos[name], house_id=house.id))
        except InputError as error:
            logging.getLogger("plan2scene").warning("%s", error)
            continue
        picture.thumbnail((PHOTO_SIDE, PHOTO_SIDE))
        for room in rooms_of_photo[name]:
            numbers[room].append(str(len(pictures) + 1))
        pictures[f"photo_{len(pictures) + 1}.jpg"] = picture
    sheet = {"house": house.id, "photos": list(pictures), "methods": list(textures)}
    captions = {
        room: f"photo{'s' * (len(shown) > 1)} {', '.join(shown)}" if shown else "no photo"
        for room, shown in numbers.items()
    }
    pictures["plan.jpg"] = Image.fromarray(render_plan(house, captions, PLAN_SIDE))
    for method, tiles in textures.items():
        render = render_from_above(*textured(tiles, house), RENDER_SIDE)
        pictures[f"{method}.jpg"] = Image.fromarray(render)
    with atomic_directory(output) as folder:
        folder.mkdir(parents=True, exist_ok=True)
        for name, picture in pictures.items():
            picture.save(folder / name, quality=88, subsampling=0)
        write_json(folder / "sheet.json", sheet)
