"""The networks behind SUBS, FID and KID, chosen by the header of their weight file.

``embedded``    trained in ``workshop/``; gives substances and features (:mod:`.substance_network`)
``vgg16``       the paper's substance classifier, converted (:mod:`.vgg`)
``inception``   InceptionV3's features, converted (:mod:`.inception`)
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.images import METRIC_SIZE, metric_image
from plan2scene.metrics.inception import InceptionV3
from plan2scene.metrics.substance_network import SubstanceNetwork, load_substance_network
from plan2scene.metrics.vgg import VggClassifier
from plan2scene.weights import fitting, load_model_file, read_model_arrays

#: Name of the embedded network in column names.
EMBEDDED = "embedded"
_CONVERTED = {"vgg16": VggClassifier, "inception": InceptionV3}
_BATCH = 8  # images at once: bounds the memory


def network_name(path: str | Path) -> str:
    """Return the name of a weight file's network for column names; read only the file's header."""
    _, architecture = read_model_arrays(path, names=())
    name = architecture.get("network", EMBEDDED)
    if name not in (EMBEDDED, *_CONVERTED):
        raise InputError("weights of a metric's network", repr(name), file=path)
    return str(name)


def features_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n, d) float32 features of (h, w, 3) uint8 sRGB images; d depends on the network."""
    if network_name(path) == EMBEDDED:
        return describe_images(load_substance_network(path), images)[0]
    return _converted_outputs(path, "inception", images)


def substances_of(path: str | Path, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n,) int64 indices into ``house.SUBSTANCES`` of (h, w, 3) uint8 sRGB images."""
    if network_name(path) == EMBEDDED:
        return describe_images(load_substance_network(path), images)[1]
    return _converted_outputs(path, "vgg16", images).argmax(axis=1)


def describe(
    features_model: str | Path,
    substance_model: str | Path,
    predictions: Sequence[np.ndarray],
    references: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return features (n, d) of predictions and substances (n + m,) of them and references.

    If one network gives both, each image goes through it once.
    """
    images = [*predictions, *references]
    if Path(features_model) == Path(substance_model):
        features, classes = describe_images(load_substance_network(features_model), images)
        return features[: len(predictions)], classes
    return features_of(features_model, predictions), substances_of(substance_model, images)


def describe_images(
    network: SubstanceNetwork, images: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the embedded network's features (n, feature_dim) float32 and substances (n,) int64.

    `images` are (h, w, 3) uint8 sRGB, which are resized to 128 px; substances are indices into
    ``house.SUBSTANCES``.
    """
    if not images:
        return np.zeros((0, len(network.shift)), np.float32), np.zeros(0, np.int64)
    with torch.inference_mode():
        parts = [network(batch / 255.0) for batch in _batches(images)]
        features, logits = (torch.cat(part) for part in zip(*parts, strict=True))
    return features.numpy(), logits.argmax(dim=1).numpy()


def _converted_outputs(path: str | Path, network: str, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return the outputs (n, d) float32 of a converted network."""
    model = load_network(path, network)
    with torch.inference_mode():
        return torch.cat([model(batch) for batch in _batches(images)]).numpy()


def _batches(images: Sequence[np.ndarray]) -> tuple[torch.Tensor, ...]:
    """Return (n, 3, 128, 128) float32 batches of images, RGB 0..255; an empty one for none."""
    pixels = np.zeros((len(images), METRIC_SIZE, METRIC_SIZE, 3), np.uint8)
    for row, image in zip(pixels, images, strict=True):
        row[:] = metric_image(image)
    return torch.from_numpy(pixels).permute(0, 3, 1, 2).float().split(_BATCH)


def load_network(path: str | Path, network: str) -> nn.Module:
    """Return the network of a converted checkpoint (vgg16 or inception), in evaluation mode."""
    state, architecture = load_model_file(path)
    if architecture.pop("network", None) != network:
        raise InputError(f"weights of network {network}", str(sorted(architecture)), file=path)
    with fitting(network, path), torch.device("meta"):
        model = _CONVERTED[network](**architecture)
    with fitting(network, path):
        model.load_state_dict(state, assign=True)
    return model.eval()
