"""Textures of a house in the colours of its paint: what the 3D house shows.

Tiles and maps are made in the colours of the photos, which hold their light. A viewer lights the
house again, so its textures are to hold paint alone.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from plan2scene.colour import as_uint8, linear_to_srgb, median_colour, srgb_to_linear
from plan2scene.finishes import read_finishes
from plan2scene.house import SurfaceKey
from plan2scene.images import jpeg_bytes, read_image, write_png
from plan2scene.io import atomic_directory, write_json
from plan2scene.mesh.texture_files import texture_index
from plan2scene.paint.estimate import PaintPrior
from plan2scene.paint.light import relight
from plan2scene.paint.surfaces import door_paints, paint_gains, read_paint
from plan2scene.textures.by_hand import set_by_hand

#: JPEG quality of maps, as of those that are painted.
_QUALITY = 85
#: Linear value on from which brightened values bend, so that none burns out: above white paint.
_KNEE = 0.88
#: Least linear value of a texture's median.
_BLACK = 1e-3


def paint_textures(
    textures: str | Path,
    paint: str | Path,
    out_dir: str | Path,
    *,
    finishes: str | Path | None = None,
    crops: str | Path | None = None,
) -> None:
    """Write a textures folder whose tiles and maps have the colours of ``paint.parquet``.

    The folder has the files of the first one, and ``doors.json``: sRGB levels of door leaves by the
    id of their opening. What `finishes` (:mod:`plan2scene.finishes`) names is as set by
    hand; `crops` are those of the house.
    """
    chosen = read_finishes(finishes) if finishes else {}
    root = Path(textures)
    listed = texture_index(root / "textures.json")
    entries = {SurfaceKey(*name.rsplit("/", 1)): entry for name, entry in listed.items()}
    unseen = {key for key, entry in entries.items() if entry.get("observed") is False}
    tiles = {key: read_image(root / f"{key.filename}.png") for key in entries}
    shown = {
        key: np.maximum(srgb_to_linear(median_colour(tile)), _BLACK) for key, tile in tiles.items()
    }
    white = np.exp(PaintPrior().white[0]) * np.ones(3)
    paints, white_surfaces = read_paint(paint)
    gains = paint_gains(shown, paints, white_surfaces, unseen, white)
    doors = {
        name: as_uint8(linear_to_srgb(colour)).tolist()
        for name, colour in door_paints(paints, white_surfaces).items()
    }
    with atomic_directory(out_dir) as folder:
        for key, tile in tiles.items():
            write_png(folder / f"{key.filename}.png", relight(tile, gains[key], knee=_KNEE))
            whole = root / f"{key.filename}.jpg"
            if whole.is_file():
                lit = relight(read_image(whole), gains[key], knee=_KNEE)
                (folder / whole.name).write_bytes(jpeg_bytes(lit, quality=_QUALITY))
        write_json(folder / "doors.json", doors)
        for index in ("textures.json", "maps.json"):
            if (root / index).is_file():
                shutil.copyfile(root / index, folder / index)
        if chosen and crops:
            set_by_hand(folder, chosen, crops, paint)
