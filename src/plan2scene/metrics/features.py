"""Substance classifier ("embedded"): SUBS, and the features of FID.

The paper takes SUBS from a VGG-16 and FID's features from InceptionV3, both downloaded. This
small network stands in for them where nothing is downloaded; every figure made with it is named
"embedded" and must not be compared in size with one of those networks. Inference is plain numpy:
a job that measures a dozen textures must not pay for importing torch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.images import METRIC_SIZE, metric_image
from plan2scene.weights import fitting, read_model_arrays

#: Name of this network in column names.
FEATURE_NETWORK = "embedded"
#: Normalisation of sRGB in [0, 1] before the first layer.
INPUT_MEAN, INPUT_STD = 0.5, 0.25
#: Added to the variance of a map before its root (the gradient at 0 would be infinite).
SPREAD_FLOOR = 1e-5
_NORM_FLOOR = 1e-5  # of batch normalisation
_BATCH = 16  # bounds the memory of the unrolled patches


@dataclass(frozen=True, eq=False)
class FeaturesNetwork:
    """The trained network: strided convolutions, mean and spread of their maps, two linear layers.

    Attributes
    ----------
    kernels : tuple of (out, in, k, k) float32
        Batch normalisation folded in; stride 2, zero padding k // 2, then ReLU.
    biases : tuple of (out,) float32
    penultimate, head : (weight (out, in), bias (out,)) float32
    shift, scale : (feature_dim,) float32
        Standardise the features over the training crops.
    """

    kernels: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    penultimate: tuple[np.ndarray, np.ndarray]
    head: tuple[np.ndarray, np.ndarray]
    shift: np.ndarray
    scale: np.ndarray

    @property
    def feature_dim(self) -> int:
        """Length of a feature vector."""
        return len(self.shift)

    def __call__(self, images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (features (n, feature_dim), logits (n, 4)) of (n, 128, 128, 3) uint8 sRGB."""
        maps = (images.astype(np.float32) / 255.0 - INPUT_MEAN) / INPUT_STD
        for kernel, bias in zip(self.kernels, self.biases, strict=True):
            maps = _convolve(maps, kernel, bias)
        spread = np.sqrt(maps.var(axis=(1, 2)) + SPREAD_FLOOR)
        pooled = np.concatenate([maps.mean(axis=(1, 2)), spread], axis=1)
        weight, bias = self.penultimate
        hidden = np.maximum(pooled @ weight.T + bias, 0.0)
        weight, bias = self.head
        return (hidden - self.shift) / self.scale, hidden @ weight.T + bias


def _convolve(maps: np.ndarray, kernel: np.ndarray, bias: np.ndarray) -> np.ndarray:
    """Return ReLU of a stride-2 convolution of (n, h, w, c) float32 with (out, c, k, k)."""
    out, channels, size, _ = kernel.shape
    pad = size // 2
    padded = np.pad(maps, ((0, 0), (pad, pad), (pad, pad), (0, 0)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, (size, size), axis=(1, 2))
    windows = windows[:, ::2, ::2]  # (n, h', w', c, k, k)
    patches = windows.reshape(-1, channels * size * size)
    result = patches @ kernel.reshape(out, -1).T + bias
    return np.maximum(result, 0.0).reshape(*windows.shape[:3], out)


def extract_features(
    network: FeaturesNetwork, images: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return features and substances of textures.

    Parameters
    ----------
    images : sequence of (h, w, 3) uint8
        sRGB, square; resized to 128 px where they are not.

    Returns
    -------
    (n, feature_dim) float32
    (n,) int64
        Index into ``house.SUBSTANCES``.
    """
    features = np.zeros((len(images), network.feature_dim), np.float32)
    classes = np.zeros(len(images), np.int64)
    for start in range(0, len(images), _BATCH):
        batch = np.stack([metric_image(image) for image in images[start : start + _BATCH]])
        if batch.shape[1:] != (METRIC_SIZE, METRIC_SIZE, 3) or batch.dtype != np.uint8:
            raise ValueError(f"expected square RGB uint8 images, found {batch.shape}")
        part, logits = network(batch)
        features[start : start + _BATCH] = part
        classes[start : start + _BATCH] = logits.argmax(axis=1)
    return features, classes


def load_features_network(path: str | Path) -> FeaturesNetwork:
    """Return the network of a weight file; InputError for one of another network."""
    state, architecture = read_model_arrays(path)
    kernels, biases = [], []
    with fitting("the features network", path):
        for index in range(len(architecture["widths"])):
            norm = f"convolutions.{3 * index + 1}"
            gain = state[f"{norm}.weight"] / np.sqrt(state[f"{norm}.running_var"] + _NORM_FLOOR)
            kernels.append(state[f"convolutions.{3 * index}.weight"] * gain[:, None, None, None])
            biases.append(state[f"{norm}.bias"] - state[f"{norm}.running_mean"] * gain)
        network = FeaturesNetwork(
            kernels=tuple(kernels),
            biases=tuple(biases),
            penultimate=(state["penultimate.weight"], state["penultimate.bias"]),
            head=(state["head.weight"], state["head.bias"]),
            shift=state["shift"],
            scale=state["scale"],
        )
        _, logits = network(np.zeros((1, METRIC_SIZE, METRIC_SIZE, 3), np.uint8))
        if logits.shape != (1, len(SUBSTANCES)):
            raise ValueError(f"scores {logits.shape}, which are (1, {len(SUBSTANCES)})")
    return network
