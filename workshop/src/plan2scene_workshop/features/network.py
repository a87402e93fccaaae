"""The features network in torch, for training; metrics run it in numpy (metrics/features.py)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from torch import nn

from plan2scene.house import SUBSTANCES
from plan2scene.metrics.features import INPUT_MEAN, INPUT_STD, SPREAD_FLOOR
from plan2scene.weights import save_model_file


class SubstanceNetwork(nn.Module):
    """Substance of a texture from the mean and spread of convolutional features.

    Four strided convolutions; their maps' means and standard deviations over the image (what a
    stationary texture is told by) go through a linear layer to the penultimate features.

    Shapes
    ------
    input : (n, 3, 128, 128) float32, sRGB in [0, 1]
    features : (n, `feature_dim`) float32, standardised over the training crops
    logits : (n, 4) float32, order of ``house.SUBSTANCES``

    `widths` are the channels of the convolutions, `feature_dim` those of the penultimate layer.
    """

    shift: torch.Tensor
    scale: torch.Tensor

    def __init__(self, widths: tuple[int, ...] = (16, 32, 64, 96), feature_dim: int = 64) -> None:
        super().__init__()
        self.architecture = {"widths": list(widths), "feature_dim": feature_dim}
        layers: list[nn.Module] = []
        channels = 3
        for index, width in enumerate(widths):
            kernel = 5 if index == 0 else 3
            layers += [
                nn.Conv2d(channels, width, kernel, 2, kernel // 2, bias=False),
                nn.BatchNorm2d(width),
                nn.ReLU(),
            ]
            channels = width
        self.convolutions = nn.Sequential(*layers)
        self.penultimate = nn.Linear(2 * channels, feature_dim)
        self.head = nn.Linear(feature_dim, len(SUBSTANCES))
        self.register_buffer("shift", torch.zeros(feature_dim))
        self.register_buffer("scale", torch.ones(feature_dim))

    def hidden(self, images: torch.Tensor) -> torch.Tensor:
        """Return the penultimate activations before they are standardised, (n, feature_dim)."""
        maps = self.convolutions((images - INPUT_MEAN) / INPUT_STD)
        spread = torch.sqrt(maps.var(dim=(2, 3), unbiased=False) + SPREAD_FLOOR)
        pooled = torch.cat([maps.mean(dim=(2, 3)), spread], dim=1)
        return torch.relu(self.penultimate(pooled))

    def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return (features, logits)."""
        hidden = self.hidden(images)
        return (hidden - self.shift) / self.scale, self.head(hidden)


def as_tensor(images: np.ndarray) -> torch.Tensor:
    """Return (n, h, w, 3) uint8 sRGB images as (n, 3, h, w) float32 in [0, 1]."""
    moved = np.ascontiguousarray(np.moveaxis(images, -1, 1))
    return torch.from_numpy(moved).float() / 255.0


def save_features_network(network: SubstanceNetwork, path: str | Path) -> None:
    """Write the network as safetensors with its architecture."""
    save_model_file(path, network.state_dict(), network.architecture)
