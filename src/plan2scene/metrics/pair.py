"""The metrics of one texture against one reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plan2scene.images import metric_image
from plan2scene.metrics.features import extract_features, load_features_network
from plan2scene.metrics.registry import image_metrics
from plan2scene.weights import MODELS


def pair_metrics(
    prediction: np.ndarray, reference: np.ndarray, *, model: Path = MODELS / "features.safetensors"
) -> dict[str, float | int]:
    """Return ``color``, ``freq``, ``tile`` (of the prediction) and ``subs`` of a texture.

    ``subs`` is 0 where the embedded classifier gives both the same substance, else 1.
    Images are (h, w, 3) uint8 sRGB, compared at the paper's 128x128 px (resized by area
    averaging where they are not; not square is stretched, as a tile would be).
    """
    pair = [metric_image(prediction), metric_image(reference)]
    _, (first, second) = extract_features(load_features_network(model), pair)
    figures = {name: float(value) for name, value in image_metrics(*pair).items()}
    return {**figures, "subs": int(first != second)}
