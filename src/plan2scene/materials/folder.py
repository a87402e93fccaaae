"""Real tileable textures from a folder per substance."""

from __future__ import annotations

import csv
from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import read_image
from plan2scene.io import safe_join
from plan2scene.materials.material import Material

#: Side in metres that a scanned texture of each substance usually covers (its files don't say).
SCAN_SIZE_M = {"wood": 1.4, "plaster": 1.6, "carpet": 0.6, "tile": 1.2}
#: Roughness given to scanned textures.
SCAN_ROUGHNESS = {"wood": 0.45, "plaster": 0.85, "carpet": 0.97, "tile": 0.25}


def load_texture_folder(
    path: str | Path, split: str | None = None, *, size_px: int = 256
) -> list[Material]:
    """Return the textures of a folder with subfolders wood, plaster, carpet, tile.

    Each subfolder (those missing are skipped) has PNG or JPEG images that tile; they are resized to
    squares of `size_px` (periodic, area or cubic). An optional ``index.csv`` has columns id (file
    stem) and split; `split`, ``train`` or ``val``, takes only its own.

    Raises InputError where no texture is of that split, or a split is asked for without an index.
    """
    folder = Path(path)
    chosen = None if split is None else _ids_of_split(folder, split)
    materials = []
    for substance in SUBSTANCES:
        for file in sorted((folder / substance).glob("*")):
            if file.suffix.lower() not in (".png", ".jpg", ".jpeg"):
                continue
            if chosen is not None and file.stem not in chosen:
                continue
            materials.append(_load(file, substance, size_px))
    if not materials:
        raise InputError(
            "images in folders named wood, plaster, carpet or tile",
            "none" if split is None else f"none of split {split}",
            file=folder,
        )
    return materials


def _ids_of_split(folder: Path, split: str) -> set[str]:
    """Return the ids that index.csv assigns to `split`."""
    index = safe_join(folder, "index.csv")
    if not index.is_file():
        raise InputError("index.csv with columns id and split", "no such file", file=index)
    with index.open(newline="", encoding="utf-8-sig") as handle:
        rows = list(csv.DictReader(handle))
    if not rows or not {"id", "split"} <= set(rows[0]):
        raise InputError("columns id and split", str(list(rows[0]) if rows else []), file=index)
    return {row["id"] for row in rows if row["split"] == split}


def _load(file: Path, substance: str, size_px: int) -> Material:
    """Return one texture as a material."""
    image = read_image(file)
    height, width = image.shape[:2]
    pad = 4  # resizing on the torus keeps the seam closed
    wide = cv2.copyMakeBorder(image, pad, pad, pad, pad, cv2.BORDER_WRAP)
    if (height, width) != (size_px, size_px):
        grid = (np.arange(size_px, dtype=np.float32) + 0.5) / size_px
        xs = np.broadcast_to(grid * width - 0.5 + pad, (size_px, size_px)).astype(np.float32)
        ys = np.broadcast_to((grid * height - 0.5 + pad)[:, None], (size_px, size_px))
        shrink = max(height, width) / size_px
        if shrink > 1:
            wide = cv2.GaussianBlur(wide, (0, 0), 0.45 * shrink)
        image = cv2.remap(wide, xs, np.ascontiguousarray(ys, np.float32), cv2.INTER_CUBIC)
    return Material(
        name=f"scan-{file.stem}",
        substance=substance,
        kind="scan",
        albedo=np.ascontiguousarray(image),
        size_m=SCAN_SIZE_M[substance],
        roughness=SCAN_ROUGHNESS[substance],
    )
