"""Several segmentation networks that answer as one: their logits are averaged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import nn

from plan2scene.photos.labels.network import SegmentationNet

#: Most networks of an ensemble: a stranger's file is not to ask for more.
MOST_MEMBERS = 8


class Ensemble(nn.Module):
    """Networks of one architecture whose logits are averaged (Hansen & Salamon 1990).

    Networks from different runs are wrong about different things. Shapes and input as of
    :class:`.network.SegmentationNet`, whose keywords `architecture` are.

    ValueError when there is no member or more than `MOST_MEMBERS`.
    """

    def __init__(self, *, members: int, **architecture: Any) -> None:
        super().__init__()
        if not 1 <= members <= MOST_MEMBERS:
            raise ValueError(f"{members} members, not 1 to {MOST_MEMBERS}")
        networks = [SegmentationNet(**architecture) for _ in range(members)]
        self.members = nn.ModuleList(networks)
        self.long_side, self.elevation = networks[0].long_side, networks[0].elevation
        self.architecture: dict[str, Any] = {**networks[0].architecture, "members": members}

    def forward(self, x: torch.Tensor, elevation: torch.Tensor | None = None) -> torch.Tensor:
        """Return the members' mean logits (n, labels, h / 2, w / 2)."""
        return torch.stack([member(x, elevation) for member in self.members]).mean(dim=0)


def ensemble_of(networks: Sequence[nn.Module]) -> Ensemble:
    """Return the ensemble of networks of the first's shapes; constants are the first's, too.

    RuntimeError for a network of other shapes.
    """
    architecture: dict[str, Any] = networks[0].architecture  # type: ignore[assignment]
    ensemble = Ensemble(members=len(networks), **architecture)
    for member, network in zip(ensemble.members, networks, strict=True):
        member.load_state_dict(network.state_dict())
    return ensemble
