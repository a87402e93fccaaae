"""The textures of a house by every method of a table, at several drop fractions."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from plan2scene.images import write_png
from plan2scene.io import atomic_directory
from plan2scene.textures.decoding import further_images
from plan2scene.textures.house_textures import house_tiles
from plan2scene.textures.inputs import (
    HouseData,
    HouseFiles,
    TextureInputs,
    TextureSettings,
    Visible,
)
from plan2scene.textures.methods import method_named
from plan2scene.textures.tiles import write_tiles

#: Files of maps, which the table does not compare.
_MAPS = shutil.ignore_patterns("*.jpg", "maps.json")


def table_textures(
    files: HouseFiles,
    drops: Mapping[str, Visible],
    methods: Sequence[str],
    out_dir: str | Path,
    *,
    models: Mapping[str, Path],
    settings: TextureSettings,
    images: int = 1,
    ready: Mapping[tuple[str, str], str | Path] | None = None,
) -> None:
    """Write ``{drop}/{method}/`` to `out_dir`, each as the texture stage makes it.

    `drops` says what the house shows at each fraction (``"0.6"``). Methods that draw noise make so
    many `images` of each surface with crops for FID and KID, the tile included; the others than the
    tile are ``more/{k}/{room_id}_{surface}.png``, k from 1. `ready` are folders of the texture
    stage by drop and method, whose tiles are copied.
    """
    data = HouseData(files)
    with atomic_directory(out_dir) as folder:
        for drop, visible in drops.items():
            inputs = data.at(visible, models, settings)
            for method in methods:
                made, target = (ready or {}).get((drop, method)), folder / drop / method
                if made:
                    shutil.copytree(made, target, ignore=_MAPS)
                else:
                    write_tiles(target, method, inputs.surfaces, house_tiles(method, inputs))
                if method_named(method).noise and images > 1:
                    _write_more(target / "more", method, inputs, images - 1)


def _write_more(folder: Path, method: str, inputs: TextureInputs, count: int) -> None:
    """Write `count` further images of each surface with crops."""
    crops = inputs.data.crops
    seen = set(zip(crops["room_id"], crops["surface"], strict=True))
    keys = [surface.key for surface in inputs.surfaces if tuple(surface.key) in seen]
    images = iter(further_images(inputs, method_named(method), keys, count))
    for key in keys:
        for number in range(1, count + 1):
            write_png(folder / str(number) / f"{key.filename}.png", next(images))
