"""Real tileable textures from a folder per substance."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import read_image
from plan2scene.materials.material import Material

#: Side in metres that a scanned texture of each substance usually covers (its files don't say).
SCAN_SIZE_M = {"wood": 1.4, "plaster": 1.6, "carpet": 0.6, "tile": 1.2}
#: Roughness given to scanned textures.
SCAN_ROUGHNESS = {"wood": 0.45, "plaster": 0.85, "carpet": 0.97, "tile": 0.25}


def load_texture_folder(path: str | Path, *, size_px: int = 256) -> list[Material]:
    """Return the textures of a folder with subfolders wood, plaster, carpet, tile.

    Each subfolder (those missing are skipped) has PNG or JPEG images that tile; they are resized to
    squares of `size_px` (periodic, area or cubic). A material's name is ``scan-{file stem}``.
    InputError where there is no texture.
    """
    materials = [
        _load(file, substance, size_px)
        for substance in SUBSTANCES
        for file in sorted((Path(path) / substance).glob("*"))
        if file.suffix.lower() in (".png", ".jpg", ".jpeg")
    ]
    if not materials:
        expected = "images in folders named wood, plaster, carpet or tile"
        raise InputError(expected, "none", file=path)
    return materials


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
