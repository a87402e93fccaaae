"""Further images of decoded textures, for FID and KID of small sets (the paper takes 24 seeds).

FID needs more images than its features have dimensions, and a test split has fewer surfaces. A
texture that is decoded from noise has as many images as there are seeds: those here differ from
the one on disk in their noise only. Nothing else is measured on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.seeds import derive_seed
from plan2scene.textures.methods import EMBEDDING_COLUMNS


@dataclass(frozen=True)
class FurtherSeeds:
    """What further images are decoded from.

    Attributes
    ----------
    propagated, model : path
        Embeddings of the house's surfaces and weights of the method's texture model.
    count : int
        Images of each surface, the one on disk included.
    seed : int
        The global seed.
    size_px : int
        Side at which they are decoded.
    seam_correction : bool
        As the method's textures on disk.
    """

    propagated: str | Path
    model: str | Path
    count: int
    seed: int
    size_px: int
    seam_correction: bool


def further_images(
    seeds: FurtherSeeds, keys: Sequence[SurfaceKey], *, method: str, house: str
) -> list[np.ndarray]:
    """Return ``count - 1`` images (size, size, 3) uint8 of each surface, one surface's together."""
    from plan2scene.textures.model.network import load_texture_model
    from plan2scene.textures.model.synthesis import decode_textures
    from plan2scene.textures.seams import make_seamless

    table, _ = read_parquet(seeds.propagated)
    rows = {SurfaceKey(row.room_id, row.surface): i for i, row in enumerate(table.itertuples())}
    column = table[EMBEDDING_COLUMNS[method]]
    places = [(key, k) for key in keys for k in range(1, seeds.count)]
    if not places:
        return []
    codes = np.stack([np.asarray(column.iloc[rows[key]], np.float32) for key, _ in places])
    noise = [derive_seed(seeds.seed, house, key.room_id, key.surface, k) for key, k in places]
    model = load_texture_model(seeds.model)
    images = decode_textures(model, codes, noise, seeds.size_px)
    if seeds.seam_correction and not model.architecture.periodic:
        return [make_seamless(image)[0] for image in images]
    return list(images)
