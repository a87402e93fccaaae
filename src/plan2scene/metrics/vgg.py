"""The paper's substance classifier: a VGG-16 whose last layer tells four substances (method.md)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import metric_image
from plan2scene.weights import load_model_file

#: Output channels of the 3x3 convolutions; None is a 2x2 max-pool (Simonyan 2015, column D).
_LAYERS: tuple[int | None, ...] = (
    *(64, 64, None),
    *(128, 128, None),
    *(256, 256, 256, None),
    *(512, 512, 512, None),
    *(512, 512, 512, None),
)
_POOLED = 7
_HIDDEN = 4096
#: Means and deviations of ImageNet, which VGG's weights expect taken off.
_MEAN, _STD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
_SIDE = 224
_BATCH = 8


class VggClassifier(nn.Module):
    """VGG-16 with the names of torchvision's checkpoints and four classes.

    Parameters
    ----------
    divisor : int
        Of all channels; 1 is VGG-16.
    """

    def __init__(self, divisor: int = 1) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels = 3
        for width in _LAYERS:
            if width is None:
                layers.append(nn.MaxPool2d(2))
                continue
            layers += [nn.Conv2d(channels, width // divisor, 3, padding=1), nn.ReLU()]
            channels = width // divisor
        self.features = nn.Sequential(*layers)
        hidden = _HIDDEN // divisor
        self.classifier = nn.Sequential(
            nn.Linear(channels * _POOLED**2, hidden),
            nn.ReLU(),
            nn.Dropout(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Dropout(),
            nn.Linear(hidden, len(SUBSTANCES)),
        )

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return logits (n, 4) of images (n, 3, h, w), RGB in [0, 1], resized to 224 pixels."""
        x = nn.functional.interpolate(rgb, (_SIDE, _SIDE), mode="bilinear", antialias=True)
        mean, std = (torch.tensor(v, device=x.device).view(1, 3, 1, 1) for v in (_MEAN, _STD))
        maps = nn.functional.adaptive_avg_pool2d(self.features((x - mean) / std), _POOLED)
        return self.classifier(maps.flatten(1))


def load_vgg_classifier(path: str | Path) -> VggClassifier:
    """Return the classifier of a converted checkpoint, in evaluation mode."""
    state, architecture = load_model_file(path)
    if architecture.get("network") != "vgg16":
        raise InputError("weights of a VGG-16", str(sorted(architecture)), file=path)
    with torch.device("meta"):
        model = VggClassifier(architecture["divisor"])
    try:
        model.load_state_dict(state, assign=True)
    except RuntimeError as error:
        raise InputError("weights that fit a VGG-16", str(error), file=path) from None
    return model.eval()


def classify_substances(model: VggClassifier, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n,) int64 indices into ``SUBSTANCES`` of (h, w, 3) uint8 sRGB images.

    Taken at the metrics' 128 pixels first, so that both sides of a pair come from one size.
    """
    classes = np.zeros(len(images), np.int64)
    with torch.inference_mode():
        for start in range(0, len(images), _BATCH):
            batch = np.stack([metric_image(image) for image in images[start : start + _BATCH]])
            rgb = torch.from_numpy(batch).permute(0, 3, 1, 2).float() / 255.0
            classes[start : start + _BATCH] = model(rgb).argmax(dim=1).numpy()
    return classes
