"""All metrics of one texture against one reference (for the command line)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.metrics.color import color_distance
from plan2scene.metrics.features import (
    FEATURE_NETWORK,
    extract_features,
    load_features_network,
)
from plan2scene.metrics.freq import freq_distance
from plan2scene.metrics.images import metric_image
from plan2scene.metrics.tile import tile_score
from plan2scene.weights import MODELS


def pair_metrics(
    prediction: np.ndarray, reference: np.ndarray, *, model: str | Path | None = None
) -> dict[str, float | int | str]:
    """Return COLOR, FREQ, TILE (of the prediction) and SUBS of a texture.

    Parameters
    ----------
    prediction, reference : (s, s, 3) uint8
        sRGB, square; compared at 128 px.
    model : path, optional
        Weights of the features network; the embedded ones when None.

    Returns
    -------
    dict
        ``color, freq, tile`` (float), ``subs`` (1 when the substances differ), the two substances
        and the network that told them.
    """
    images = []
    for name, image in (("prediction", prediction), ("reference", reference)):
        if image.shape[0] != image.shape[1]:
            size = f"{image.shape[1]}x{image.shape[0]} pixels"
            raise InputError(f"a square {name}", size)
        images.append(metric_image(image))
    network = load_features_network(model or MODELS / "features.safetensors")
    _, classes = extract_features(network, images)
    return {
        "color": color_distance(*images),
        "freq": freq_distance(*images),
        "tile": tile_score(images[0]),
        "subs": int(classes[0] != classes[1]),
        "substance": SUBSTANCES[classes[0]],
        "substance_reference": SUBSTANCES[classes[1]],
        "subs_network": FEATURE_NETWORK,
    }
