"""Mixing of feature statistics between the views of a step: looks that no rendering has."""

from __future__ import annotations

from typing import Any

import torch
from torch.utils.hooks import RemovableHandle

from plan2scene.photos.labels.network import SegmentationNet

#: Parameter of the beta distribution of the mixing shares: most shares are near 0 or 1.
_ALPHA = 0.3


def mix_statistics(network: SegmentationNet, chance: float) -> list[RemovableHandle]:
    """Mix the feature statistics of a network in training mode; return the hooks, to remove later.

    At each of the strides 2, 4 and 8, a step's features are mixed with probability `chance`, each
    view's with another's (MixStyle, Zhou et al. 2021, https://arxiv.org/abs/2104.02008). The random
    numbers are torch's.
    """

    def hook(module: torch.nn.Module, _: Any, features: torch.Tensor) -> torch.Tensor:
        if not module.training or torch.rand(()).item() >= chance:
            return features
        return mixed(features)

    early = [network.stem, *list(network.stages)[:2]]
    return [module.register_forward_hook(hook) for module in early]


def mixed(features: torch.Tensor) -> torch.Tensor:
    """Return features (n, c, h, w) with channel means and deviations mixed from two views.

    The share of a view's own statistics comes from a beta distribution. Positions do not change.
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
