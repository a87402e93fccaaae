"""The paper's substance classifier: a VGG-16 whose last layer tells four substances.

Written here for the reason that :mod:`.inception` gives.
"""

from __future__ import annotations

import itertools

import torch
from torch import nn

from plan2scene.house import SUBSTANCES

#: Convolutions and their output channels between max-pools (Simonyan 2015, column D).
_STAGES = ((2, 64), (2, 128), (3, 256), (3, 512), (3, 512))
_POOLED = 7
_HIDDEN = 4096
#: Means and deviations of ImageNet, which VGG's weights expect taken off.
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
_SIDE = 224


class VggClassifier(nn.Module):
    """VGG-16 with the names of torchvision's checkpoints and four classes.

    All channels are divided by `divisor`; 1 is VGG-16.
    """

    def __init__(self, divisor: int = 1) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels = 3
        for count, width in _STAGES:
            for _ in range(count):
                layers += [nn.Conv2d(channels, width // divisor, 3, padding=1), nn.ReLU()]
                channels = width // divisor
            layers.append(nn.MaxPool2d(2))
        self.features = nn.Sequential(*layers)
        sizes = (channels * _POOLED**2, _HIDDEN // divisor, _HIDDEN // divisor, len(SUBSTANCES))
        head: list[nn.Module] = []
        for width, out in itertools.pairwise(sizes):
            head += [nn.Linear(width, out), nn.ReLU(), nn.Dropout()]
        self.classifier = nn.Sequential(*head[:-2])

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return logits (n, 4) of images (n, 3, h, w), RGB 0..255, resized to 224 pixels."""
        x = nn.functional.interpolate(rgb / 255.0, (_SIDE, _SIDE), mode="bilinear", antialias=True)
        mean, std = (torch.tensor(v, device=x.device).view(1, 3, 1, 1) for v in (_MEAN, _STD))
        maps = nn.functional.adaptive_avg_pool2d(self.features((x - mean) / std), _POOLED)
        return self.classifier(maps.flatten(1))
