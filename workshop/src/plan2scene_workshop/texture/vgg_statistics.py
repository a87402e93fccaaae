"""Texture statistics of the training loss: the filter bank's, or those of VGG-19 as in the paper.

The user supplies the weights of VGG-19 (``pretrained``).
"""

from __future__ import annotations

import pickle
from pathlib import Path

import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.metrics.vgg import imagenet_normalised, vgg_convolutions
from plan2scene.textures.model.statistics import FilterBankStatistics, gram, gram_distance

#: Convolutions of VGG-19's groups up to relu5_1.
_VGG19 = (2, 2, 4, 4, 1)
#: Indices of the tapped convolutions (relu1_1 ... relu5_1) among torchvision's ``features``.
_VGG19_TAPS = (0, 5, 10, 19, 28)
#: Errors that reading an unfit weights file raises.
_UNFIT = (OSError, RuntimeError, ValueError, TypeError, KeyError, pickle.UnpicklingError)


class FilterBankLoss(FilterBankStatistics):
    """Gram matrices of the fixed filter bank, and their distance."""

    def distance(self, images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """Return the :func:`gram_distance` (n,) of images to targets."""
        return gram_distance(self.grams(images), self.grams(targets))


class VggStatistics(nn.Module):
    """Gram matrices of VGG-19's relu1_1 ... relu5_1 with circular padding of 1 (the paper's).

    `path` is a state dict of torchvision's ``vgg19``, read with ``weights_only=True``.
    """

    def __init__(self, path: str | Path) -> None:
        super().__init__()
        *layers, _ = vgg_convolutions(_VGG19, padding_mode="circular").children()  # no last pool
        self.features = nn.Sequential(*layers).requires_grad_(False).eval()
        try:
            state = torch.load(path, map_location="cpu", weights_only=True)
            self.load_state_dict({name: state[name] for name in self.state_dict()})
        except _UNFIT as error:
            found = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError("a state dict of torchvision's vgg19", found, file=path) from None

    def grams(self, rgb: torch.Tensor) -> list[torch.Tensor]:
        """Return the five Gram matrices (n, c, c) of images (n, 3, h, w)."""
        x = imagenet_normalised(rgb)
        result = []
        for index, layer in enumerate(self.features.children()):
            x = layer(x)
            if index - 1 in _VGG19_TAPS:
                result.append(gram(x))
        return result

    def distance(self, images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """Return (n,): sum over layers of the mean squared difference of Gram matrices."""
        total = images.new_zeros(len(images))
        for mine, theirs in zip(self.grams(images), self.grams(targets), strict=True):
            total = total + (mine - theirs).square().mean((1, 2))
        return total


def load_statistics(
    source: str, path: str | Path | None = None, *, levels: int = 5, device: str = "cpu"
) -> FilterBankLoss | VggStatistics:
    """Return the texture statistics of a source.

    ``embedded`` has `levels` pyramid levels; ``pretrained`` reads its weights from `path`.
    """
    if source == "embedded":
        return FilterBankLoss(levels).to(device)
    if source == "pretrained" and path is not None:
        return VggStatistics(path).to(device)
    raise InputError("texture statistics 'embedded', or 'pretrained' with a file", repr(source))
