"""Selection: which crop represents an observed surface (no torch)."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.colour import clipped_share
from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import image_from_bytes, medoid_index
from plan2scene.io import read_parquet, write_parquet
from plan2scene.parallel import each

if TYPE_CHECKING:
    import pandas as pd

_CLIPPED = 0.25
_COLUMNS = dict.fromkeys(["room_id", "surface", "crop_id", "medoid_id"], "object")
_COLUMNS |= dict.fromkeys(["embedding", "naive_embedding", "substance"], "object")
_COLUMNS |= {"metres": "float64", "n_crops": "int64"}


def select_surfaces(
    embeddings_parquet: str | Path,
    crops_parquet: str | Path,
    hidden_photos: Collection[str],
    output: str | Path,
    *,
    house: str,
    dataset: str,
    threads: int = 1,
) -> pd.DataFrame:
    """Choose a crop for every surface that a visible photo shows; write ``surfaces.parquet``.

    The crop with the least textureness score gives the code (paper section 5.3); burned-out crops
    are left out if there are others. All crops give the colour (:func:`surface_embedding`).
    NaiveSynth gets the mean of the crops' codes. Crops of `hidden_photos` are ignored.
    ``docs/conventions.md`` lists the columns. ``metres`` is the side of the square that the chosen
    crop covers, because its texture is at that scale; where that is unknown, the median over the
    surface's crops (NaN if none is known). `threads` surfaces are processed at a time; the choice
    does not depend on it.
    """
    import pandas as pd

    crops, _ = read_parquet(crops_parquet)
    embeddings, metadata = read_parquet(embeddings_parquet)
    if list(crops["crop_id"]) != list(embeddings["crop_id"]):
        raise InputError(
            f"an embedding for each of the {len(crops)} crops, in order",
            f"{len(embeddings)} embeddings of other crops",
            file=embeddings_parquet,
            house=house,
        )
    embedding_columns = ["embedding", "naive_embedding", "substance_probabilities", "textureness"]
    table = crops.join(embeddings[embedding_columns])
    table = table[~table["photo"].isin(set(hidden_photos))]
    groups = table.groupby(["room_id", "surface"], sort=True)
    of_surface = dict(iter(groups))
    chosen = each(_choose, of_surface.values(), threads)
    rows = [
        {"room_id": room, "surface": surface, **row}
        for (room, surface), row in zip(of_surface, chosen, strict=True)
    ]
    frame = pd.DataFrame(rows, columns=list(_COLUMNS)).astype(_COLUMNS)
    models = {str(k): v for k, v in metadata.items() if k in ("model", "naive_model")}
    write_parquet(output, frame, {"dataset": dataset, "house": house, **models})
    return frame


def _choose(group: pd.DataFrame) -> dict[str, Any]:
    """Return the row of one surface from its visible crops."""
    images = [image_from_bytes(data) for data in group["png"]]
    scores = group["textureness"].to_numpy(np.float64)
    clipped = np.array([clipped_share(image) for image in images])
    codes = np.stack([np.asarray(code, np.float32) for code in group["embedding"]])
    index, embedding = surface_embedding(codes, scores, clipped)
    best = group.iloc[index]
    medoid = group.iloc[medoid_index(images)]
    naive = np.stack([np.asarray(code, np.float32) for code in group["naive_embedding"]])
    votes = np.stack([np.asarray(p, np.float32) for p in group["substance_probabilities"]])
    known = group["metres"].to_numpy(np.float64)
    known = known[np.isfinite(known)]
    metres = float(best["metres"])
    if not np.isfinite(metres):
        metres = float(np.median(known)) if len(known) else float("nan")
    return {
        "crop_id": best["crop_id"],
        "medoid_id": medoid["crop_id"],
        "embedding": embedding,
        "naive_embedding": naive.mean(axis=0),
        "substance": SUBSTANCES[int(votes.mean(axis=0).argmax())],
        "metres": metres,
        "n_crops": len(group),
    }


def surface_embedding(
    codes: np.ndarray, textureness: np.ndarray, clipped: np.ndarray
) -> tuple[int, np.ndarray]:
    """Return the index of the crop that represents a surface, and the surface's embedding (d,).

    Light and colour casts differ from crop to crop and the score ignores them. So the colour is the
    median of all crops that are not burned out (of all crops if all are); the rest is the chosen
    crop's. `codes` (n, d) float32 are the crops' embeddings, each with its median R, G, B in [0, 1]
    last; `textureness` and `clipped` are as in :func:`best_crop`.
    """
    index = best_crop(textureness, clipped)
    good = clipped <= _CLIPPED if (clipped <= _CLIPPED).any() else np.ones(len(codes), dtype=bool)
    embedding = codes[index].copy()
    embedding[-3:] = np.median(codes[good, -3:], axis=0)
    return index, embedding


def best_crop(textureness: np.ndarray, clipped: np.ndarray) -> int:
    """Return the index of the least textureness score (n,), the first of equals; NaN is the worst.

    A burned-out crop is flat, so it scores well although it shows nothing. Crops whose share of
    `clipped` pixels (n,) is above a quarter rank after all others.
    """
    scores = np.where(np.isnan(textureness), np.inf, textureness)
    order = np.lexsort((scores, clipped > _CLIPPED))
    return int(order[0])
