"""The metrics in the order of the tables; add one of image pairs by a function and a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score


@dataclass(frozen=True)
class Metric:
    """One metric; lower is better.

    `of_pair` gives the value for a prediction and its reference, (128, 128, 3) uint8 sRGB each. It
    is None for metrics by a network (SUBS) and of the whole set of surfaces (FID, KID).
    """

    decimals: int  #: as the paper prints it
    network: str = ""  #: key in the metadata of ``metrics.parquet`` for its network's name
    of_pair: Callable[[np.ndarray, np.ndarray], float] | None = None


#: By name. KID is not in the paper; unlike FID its expectation does not depend on a set's size.
METRICS: Mapping[str, Metric] = {
    "COLOR": Metric(3, of_pair=color_distance),
    "FREQ": Metric(3, of_pair=freq_distance),
    "SUBS": Metric(3, "substances"),
    "FID": Metric(1, "features"),
    "TILE": Metric(1, of_pair=lambda prediction, _: tile_score(prediction)),
    "KID": Metric(3, "features"),
}
#: Names of the columns of ``metrics.parquet`` that :func:`image_metrics` computes.
IMAGE_COLUMNS = tuple(name.lower() for name, metric in METRICS.items() if metric.of_pair)


def image_metrics(prediction: np.ndarray, reference: np.ndarray) -> dict[str, float]:
    """Return the metrics of two (128, 128, 3) uint8 sRGB images by column name."""
    return {
        name.lower(): metric.of_pair(prediction, reference)
        for name, metric in METRICS.items()
        if metric.of_pair
    }
