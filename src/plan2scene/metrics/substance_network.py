"""The embedded classifier of substances: SUBS uses its classes, FID and KID its features.

The paper takes SUBS from a VGG-16 and FID's features from InceptionV3, both downloaded. This small
network replaces them if nothing is downloaded. Values made with it are named "embedded": do not
compare them with values of those networks. It is trained in ``workshop/``.
"""

from __future__ import annotations

from pathlib import Path

import torch
from torch import nn

from plan2scene.house import SUBSTANCES
from plan2scene.weights import filled, load_model_file

_INPUT_MEAN, _INPUT_STD = 0.5, 0.25  #: Normalisation of sRGB in [0, 1] before the first layer
#: Added to the variance of a map before its root (the gradient at 0 would be infinite).
_SPREAD_FLOOR = 1e-5


class SubstanceNetwork(nn.Module):
    """Substance of a texture from the mean and spread of convolutional features.

    Strided convolutions give maps. The means and standard deviations of the maps over the image
    describe a stationary texture; a linear layer turns them into the penultimate features.

    Input: (n, 3, h, w) float32, sRGB in [0, 1], trained with h = w = 128. Features, of the
    penultimate layer: (n, `feature_dim`) float32, standardised over the training crops. Logits:
    (n, 4) float32, order of ``house.SUBSTANCES``. `widths` are the channels of the convolutions.
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
        maps = self.convolutions((images - _INPUT_MEAN) / _INPUT_STD)
        spread = torch.sqrt(maps.var(dim=(2, 3), unbiased=False) + _SPREAD_FLOOR)
        pooled = torch.cat([maps.mean(dim=(2, 3)), spread], dim=1)
        return torch.relu(self.penultimate(pooled))

    def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return (features, logits)."""
        hidden = self.hidden(images)
        return (hidden - self.shift) / self.scale, self.head(hidden)


def load_substance_network(path: str | Path) -> SubstanceNetwork:
    """Return the network of a weight file; InputError if the file is of another network."""
    state, header = load_model_file(path)
    return filled(
        lambda: SubstanceNetwork(header["widths"], header["feature_dim"]),
        state,
        "the substance network",
        path,
    )
