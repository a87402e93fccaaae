"""The metrics in the order of the tables; a new one of image pairs is a function and a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score


@dataclass(frozen=True)
class Metric:
    """One metric; lower is better.

    `of_pairs` gives values (...) of predictions and references, (..., 128, 128, 3) uint8 sRGB each;
    None for what a network says (SUBS) or the whole set of surfaces (FID, KID).
    """

    decimals: int  #: as the paper prints it
    network: str = ""  #: metadata of ``metrics.parquet`` that names the network behind it
    of_pairs: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None


#: By name. KID is not the paper's: unlike FID it depends on no set's size.
METRICS: Mapping[str, Metric] = {
    "COLOR": Metric(3, of_pairs=color_distance),
    "FREQ": Metric(3, of_pairs=freq_distance),
    "SUBS": Metric(3, "substances"),
    "FID": Metric(1, "features"),
    "TILE": Metric(1, of_pairs=lambda predictions, _: tile_score(predictions)),
    "KID": Metric(3, "features"),
}
#: Names of the columns of ``metrics.parquet`` that :func:`image_metrics` gives.
IMAGE_COLUMNS = tuple(name.lower() for name, metric in METRICS.items() if metric.of_pairs)


def image_metrics(predictions: np.ndarray, references: np.ndarray) -> dict[str, np.ndarray]:
    """Return the values (...) of pairs of (..., 128, 128, 3) uint8 sRGB images by column."""
    return {
        name.lower(): metric.of_pairs(predictions, references)
        for name, metric in METRICS.items()
        if metric.of_pairs
    }
