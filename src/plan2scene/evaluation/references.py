"""Reference crops: the crop of each surface that metrics compare its tile with."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes, medoid_index, metric_image

if TYPE_CHECKING:
    import pandas as pd

#: By surface with crops: the medoid of its visible crops, if any, and the medoid of all.
References: TypeAlias = Mapping[SurfaceKey, tuple[np.ndarray | None, np.ndarray]]


def reference_images(crops: pd.DataFrame, hidden_photos: Collection[str]) -> References:
    """Return for each surface with crops the medoid of its visible crops and that of all.

    Both are (128, 128, 3) uint8; the first is None if only hidden photos show the surface.
    """
    hidden = set(hidden_photos)
    result = {}
    for (room_id, surface), group in crops.groupby(["room_id", "surface"], sort=False):
        images = [metric_image(image_from_bytes(png)) for png in group["png"]]
        visible_images = [
            i for i, photo in zip(images, group["photo"], strict=True) if photo not in hidden
        ]
        visible = visible_images[medoid_index(visible_images)] if visible_images else None
        key = SurfaceKey(str(room_id), str(surface))
        result[key] = (visible, images[medoid_index(images)])
    return result
