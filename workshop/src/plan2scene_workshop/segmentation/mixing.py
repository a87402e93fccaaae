"""Statistics of features mixed between the views of a step: looks that no rendering has."""

from __future__ import annotations

from typing import Any

import torch
from torch.utils.hooks import RemovableHandle

from plan2scene.photos.labels.network import SegmentationNet

#: Parameter of the beta distribution that shares are drawn from: mostly near 0 or 1.
_ALPHA = 0.3


def mix_statistics(network: SegmentationNet, chance: float) -> list[RemovableHandle]:
    """Let a network in training mode see features of mixed statistics; return what ends it.

    At each of the strides 2, 4 and 8, a step's features are mixed by `chance`, each view's with
    another's (MixStyle, Zhou et al. 2021, https://arxiv.org/abs/2104.02008). Choices are torch's.
    """

    def hook(module: torch.nn.Module, _: Any, features: torch.Tensor) -> torch.Tensor:
        if not module.training or torch.rand(()).item() >= chance:
            return features
        return mixed(features)

    early = [network.stem, *list(network.stages)[:2]]
    return [module.register_forward_hook(hook) for module in early]


def mixed(features: torch.Tensor) -> torch.Tensor:
    """Return features (n, c, h, w) whose channels have means and deviations of two views' mixture.

    A view's own share comes from a beta distribution; where things are stays as it was.
    """
    n, x = len(features), features.float()
    with torch.no_grad():
        mean = x.mean(dim=(2, 3), keepdim=True)
        deviation = (x.var(dim=(2, 3), keepdim=True) + 1e-5).sqrt()
        own = torch.distributions.Beta(_ALPHA, _ALPHA).sample((n, 1, 1, 1)).to(x)
        other = torch.randperm(n)
        new_mean = own * mean + (1 - own) * mean[other]
        new_deviation = own * deviation + (1 - own) * deviation[other]
    return ((x - mean) / deviation * new_deviation + new_mean).to(features.dtype)
