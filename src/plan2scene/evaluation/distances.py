"""FID and KID of a table's cell: predicted textures against the crops of the same surfaces.

Each surface counts once, however many crops show it and however many images were decoded for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.metrics.frechet import frechet_distance
from plan2scene.metrics.kernel import kernel_distance

if TYPE_CHECKING:
    import pandas as pd

#: What names a surface in the tables of metrics and of reference features.
SURFACE = ["house", "room_id", "surface"]


def feature_distances(part: pd.DataFrame, references: pd.DataFrame) -> dict[str, float]:
    """Return ``FID`` and ``KID`` of measured surfaces.

    Parameters
    ----------
    part : frame
        Rows of ``metrics.parquet``: ``features`` (d,) and ``further_features`` (k * d,).
    references : frame
        Rows of ``reference_features.parquet`` with a column ``house``: ``features`` of all crops.
    """
    crops = references.merge(part[SURFACE].drop_duplicates(), on=SURFACE)
    if crops.empty:
        raise InputError("reference features of the measured surfaces", "none")
    predicted, owners = _images(part)
    wanted = np.stack(list(crops["features"]))
    crop_owners = crops.groupby(SURFACE).ngroup().to_numpy()
    weights, crop_weights = (1.0 / np.bincount(x)[x] for x in (owners, crop_owners))
    return {
        "FID": frechet_distance(predicted, wanted, crop_weights, weights),
        "KID": kernel_distance(predicted, wanted, owners, crop_owners),
    }


def _images(part: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the features (n, d) of all images of surfaces and the row (n,) each belongs to."""
    dimension = len(part["features"].iloc[0])
    groups = [
        np.concatenate([row.features, row.further_features]).reshape(-1, dimension)
        for row in part.itertuples()
    ]
    return np.concatenate(groups), np.repeat(np.arange(len(groups)), [len(g) for g in groups])
