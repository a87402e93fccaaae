"""The networks behind SUBS, FID and KID by the header of their weight file.

``embedded``    trained here; tells substances and gives features (:mod:`.features`, numpy)
``vgg16``       the paper's substance classifier, converted (:mod:`.vgg`)
``inception``   InceptionV3's features, converted (:mod:`.inception`)

Torch is imported only for the last two.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.metrics.features import FEATURE_NETWORK, extract_features, load_features_network

#: Networks by what they give.
FEATURE_NETWORKS = (FEATURE_NETWORK, "inception")
SUBSTANCE_NETWORKS = (FEATURE_NETWORK, "vgg16")


def network_name(path: str | Path) -> str:
    """Return the name that columns give a weight file's network; reads its header only."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(path, framework="np") as file:
            header = json.loads((file.metadata() or {}).get("architecture", "{}"))
    except (SafetensorError, OSError, ValueError) as error:
        raise InputError("a safetensors file", str(error), file=path) from None
    name = header.get("network", FEATURE_NETWORK)
    if name not in {*FEATURE_NETWORKS, *SUBSTANCE_NETWORKS}:
        raise InputError("weights of a metric's network", repr(name), file=path)
    return str(name)


def features_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n, d) float32 features of (h, w, 3) uint8 sRGB images, d of the network."""
    if network_name(path) == FEATURE_NETWORK:
        return extract_features(load_features_network(path), images)[0]
    from plan2scene.metrics.inception import inception_features, load_inception

    return inception_features(load_inception(path), images)


def substances_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n,) int64 indices into ``house.SUBSTANCES`` of (h, w, 3) uint8 sRGB images."""
    if network_name(path) == FEATURE_NETWORK:
        return extract_features(load_features_network(path), images)[1]
    from plan2scene.metrics.vgg import classify_substances, load_vgg_classifier

    return classify_substances(load_vgg_classifier(path), images)


def describe(
    features_model: str | Path,
    substance_model: str | Path,
    predictions: Sequence[np.ndarray],
    references: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return features (n, d) of predictions and substances (n + m,) of them and references.

    One network for both looks at each image once.
    """
    images = [*predictions, *references]
    if Path(features_model) == Path(substance_model):
        features, classes = extract_features(load_features_network(features_model), images)
        return features[: len(predictions)], classes
    return features_of(features_model, predictions), substances_of(substance_model, images)
