"""Crops of other houses: where Crop looks when its own house has none (paper section 6.1)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.io import read_parquet, write_parquet
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.textures.baselines.nearest import Crop, PoolCrop


def write_pool(
    scenes: Sequence[str | Path],
    crops: Sequence[str | Path],
    houses: Sequence[str],
    output: str | Path,
    *,
    dataset: str,
) -> None:
    """Write ``crop_pool.parquet``: the medoid crop of every surface that these houses show.

    One crop a surface, so that rooms of many photos do not outweigh the others (and the file of
    129 houses stays near 50 MB). Columns ``house, room_id, types (joined by |), surface, crop_id,
    metres, sharpness, png``.
    """
    import pandas as pd

    frames = []
    for scene, path, house in zip(scenes, crops, houses, strict=True):
        plan = read_scene_json(scene, house)
        table, _ = read_parquet(path)
        table = table[table["medoid"].astype(bool)]
        types = ["|".join(plan.room(room).types) for room in table["room_id"]]
        frames.append(table.assign(house=house, types=types))
    columns = ["house", "room_id", "types", "surface", "crop_id", "metres", "sharpness", "png"]
    frame = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=columns)
    write_parquet(output, frame[columns], {"dataset": dataset})


def read_pool(path: str | Path, *, but: str) -> list[PoolCrop]:
    """Return the crops of a pool, those of house `but` left out."""
    frame, _ = read_parquet(path)
    missing = {"house", "types", "crop_id", "png"} - set(frame.columns)
    if missing:
        raise InputError("a crop pool", f"no {', '.join(sorted(missing))}", file=path)
    return [
        PoolCrop(row.house, tuple(row.types.split("|")), Crop.of(row))
        for row in frame.itertuples()
        if row.house != but
    ]
