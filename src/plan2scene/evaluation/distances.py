"""FID and KID of a table's cell: predicted textures against the crops of the same surfaces.

Each surface counts once, however many crops show it and however many images were decoded for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.metrics.feature_sets import frechet_distance, kernel_distance

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
    # One row per image: that of the surface first, then the further ones.
    dimension = len(part["features"].iloc[0])
    pairs = zip(part["features"], part["further_features"], strict=True)
    images = [np.concatenate(pair).reshape(-1, dimension) for pair in pairs]
    owners = np.repeat(np.arange(len(images)), [len(own) for own in images])
    crop_owners = crops.groupby(SURFACE).ngroup().to_numpy()
    sets = (np.concatenate(images), np.stack(list(crops["features"])), owners, crop_owners)
    return {"FID": frechet_distance(*sets), "KID": kernel_distance(*sets)}
