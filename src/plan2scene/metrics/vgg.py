"""The paper's substance classifier: a VGG-16 whose last layer gives four substances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import torch
from torch import nn

from plan2scene.house import SUBSTANCES

#: Mean and standard deviation of ImageNet's RGB in [0, 1]; VGG's input is normalised by them.
IMAGENET_MEAN, IMAGENET_STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Output channels of the convolutions between max-pools (Simonyan 2015).
_WIDTHS = (64, 128, 256, 512, 512)
_SIDE = 224  # pixels of the input
_POOLED = 7  # side of the maps that the linear layers take
_HIDDEN = 4096


def vgg_convolutions(
    counts: Sequence[int], *, divisor: int = 1, padding_mode: Literal["zeros", "circular"] = "zeros"
) -> nn.Sequential:
    """Return VGG's 3x3 convolutions with ReLU, and a max-pool after each group.

    `counts` are the numbers of convolutions of the groups, (2, 2, 3, 3, 3) for VGG-16. Names and
    order are those of torchvision's ``features``. All channels are divided by `divisor`.
    """
    layers: list[nn.Module] = []
    channels = 3
    for count, width in zip(counts, _WIDTHS, strict=True):
        for _ in range(count):
            out = width // divisor
            layers += [nn.Conv2d(channels, out, 3, padding=1, padding_mode=padding_mode), nn.ReLU()]
            channels = out
        layers.append(nn.MaxPool2d(2))
    return nn.Sequential(*layers)


def imagenet_normalised(rgb: torch.Tensor) -> torch.Tensor:
    """Return images (n, 3, h, w), RGB in [0, 1], normalised by ImageNet's mean and deviation."""
    mean, std = (rgb.new_tensor(value).view(1, 3, 1, 1) for value in (IMAGENET_MEAN, IMAGENET_STD))
    return (rgb - mean) / std


class VggClassifier(nn.Module):
    """VGG-16 with the names of torchvision's checkpoints and four classes.

    All channels are divided by `divisor`; 1 is VGG-16.
    """

    def __init__(self, divisor: int = 1) -> None:
        super().__init__()
        hidden = _HIDDEN // divisor
        self.features = vgg_convolutions((2, 2, 3, 3, 3), divisor=divisor)
        self.classifier = nn.Sequential(
            nn.Linear(_WIDTHS[-1] // divisor * _POOLED**2, hidden),
            nn.ReLU(),
            nn.Dropout(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Dropout(),
            nn.Linear(hidden, len(SUBSTANCES)),
        )

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return logits (n, 4) of images (n, 3, h, w), RGB 0..255, resized to 224 pixels."""
        resized = nn.functional.interpolate(
            rgb / 255.0, (_SIDE, _SIDE), mode="bilinear", antialias=True
        )
        maps = self.features(imagenet_normalised(resized))
        return self.classifier(nn.functional.adaptive_avg_pool2d(maps, _POOLED).flatten(1))
