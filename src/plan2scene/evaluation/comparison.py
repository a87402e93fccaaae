"""One house by all methods of the paper's table: their textures, and the metrics of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from plan2scene.evaluation.houses import EvaluatedHouse, measured, write_measured
from plan2scene.evaluation.measure import reference_images
from plan2scene.io import atomic_directory
from plan2scene.textures.house_textures import house_tiles
from plan2scene.textures.inputs import HouseData, Visible
from plan2scene.textures.tiles import read_tiles, write_tiles


def compare_house(
    house: EvaluatedHouse,
    drops: Mapping[str, Visible],
    methods: Sequence[str],
    textures: str | Path,
    metrics: str | Path,
    *,
    images: int = 1,
    ready: Mapping[tuple[str, str], str | Path] | None = None,
) -> None:
    """Write ``{drop}/{method}/`` of tiles to `textures`, and ``metrics.parquet`` of all of them.

    `drops` maps a drop fraction (``"0.6"``) to what the house shows at it; `images` are those of
    each surface for FID and KID, by methods that draw noise. `ready` maps a drop and a method to a
    folder of the texture stage whose tiles are taken instead of made.
    """
    data = HouseData(house.files)
    frames = []
    with atomic_directory(textures) as folder:
        for drop, visible in drops.items():
            inputs = data.at(visible, house.models.decoders, house.settings)
            references = reference_images(data.crops, visible.hidden_photos)
            for method in methods:
                made = (ready or {}).get((drop, method))
                tiles = read_tiles(made) if made else house_tiles(method, inputs)
                write_tiles(folder / drop / method, method, inputs.surfaces, tiles)
                frames.append(
                    measured(house, method, inputs, tiles, references, drop=drop, images=images)
                )
    write_measured(metrics, house, frames)
