"""The networks behind SUBS, FID and KID by the header of their weight file.

``embedded``    trained here; tells substances and gives features (:mod:`.features`, numpy)
``vgg16``       the paper's substance classifier, converted (:mod:`.vgg`)
``inception``   InceptionV3's features, converted (:mod:`.inception`)

Torch is imported only for the last two.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import METRIC_SIZE, metric_image
from plan2scene.metrics.features import FEATURE_NETWORK, extract_features, load_features_network
from plan2scene.weights import fitting, load_model_file, read_model_arrays

if TYPE_CHECKING:
    from torch import nn

_BATCH = 8


def network_name(path: str | Path) -> str:
    """Return the name that columns give a weight file's network; reads its header only."""
    _, architecture = read_model_arrays(path, names=())
    name = architecture.get("network", FEATURE_NETWORK)
    if name not in (FEATURE_NETWORK, "vgg16", "inception"):
        raise InputError("weights of a metric's network", repr(name), file=path)
    return str(name)


def features_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n, d) float32 features of (h, w, 3) uint8 sRGB images, d of the network."""
    if network_name(path) == FEATURE_NETWORK:
        return extract_features(load_features_network(path), images)[0]
    return _outputs(path, "inception", images)


def substances_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n,) int64 indices into ``house.SUBSTANCES`` of (h, w, 3) uint8 sRGB images."""
    if network_name(path) == FEATURE_NETWORK:
        return extract_features(load_features_network(path), images)[1]
    return _outputs(path, "vgg16", images).argmax(axis=1)


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


def _outputs(path: str | Path, network: str, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n, d) float32 of a converted network for images taken at the metrics' 128 pixels."""
    import torch

    model = load_network(path, network)
    pixels = np.zeros((len(images), METRIC_SIZE, METRIC_SIZE, 3), np.uint8)
    for row, image in zip(pixels, images, strict=True):
        row[:] = metric_image(image)
    with torch.inference_mode():
        batches = torch.from_numpy(pixels).permute(0, 3, 1, 2).split(_BATCH)
        return torch.cat([model(batch.float()) for batch in batches]).numpy()


def load_network(path: str | Path, network: str) -> nn.Module:
    """Return ``vgg16`` or ``inception`` of a converted checkpoint, in evaluation mode."""
    import torch

    from plan2scene.metrics.inception import InceptionV3
    from plan2scene.metrics.vgg import VggClassifier

    state, architecture = load_model_file(path)
    if architecture.pop("network", None) != network:
        raise InputError(f"weights of network {network}", str(sorted(architecture)), file=path)
    with fitting(network, path), torch.device("meta"):
        model = {"vgg16": VggClassifier, "inception": InceptionV3}[network](**architecture)
    with fitting(network, path):
        model.load_state_dict(state, assign=True)
    return model.eval()
