"""The crop encoder: ResNet-18's layout, normalised without statistics of a batch.

With ``norm="instance"`` it is the paper's. Instance normalisation forgets how strong a pattern is
and leaves every channel's mean at zero before pooling; ``norm="group"`` keeps both (stem and
shortcuts unnormalised, group normalisation in the residual branches) with the same parameters.
"""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional

#: Kinds of normalisation.
NORMS = ("instance", "group")
_GROUPS = 4


class BasicBlock(nn.Module):
    """Two 3x3 convolutions with a shortcut; names follow torchvision's checkpoints."""

    def __init__(self, inputs: int, outputs: int, stride: int, norm: str) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.norm = _branch_norm(norm, outputs)
        self.downsample: nn.Sequential | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), _trunk_norm(norm, outputs)
            )

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return (n, outputs, h / stride, w / stride) of (n, inputs, h, w)."""
        shortcut = x if self.downsample is None else self.downsample(x)
        y = functional.relu(self.norm(self.conv1(x)))
        return functional.relu(self.norm(self.conv2(y)) + shortcut)


class Encoder(nn.Module):
    """Crop (n, 3, h, w) -> bottleneck code (n, code_dim) and decoder controls (n, control_dim).

    Parameters
    ----------
    width : int
        Channels of the stem; 64 is ResNet-18 and fits the authors' checkpoints.
    code_dim : int
        Size of the bottleneck, 8 in the paper.
    control_dim : int
        Transform coefficients and style values together, 96 in the paper.
    norm : str
        ``"instance"`` (the paper's) or ``"group"``.
    """

    def __init__(
        self, width: int = 64, code_dim: int = 8, control_dim: int = 96, norm: str = "instance"
    ) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
        self.norm = _trunk_norm(norm, width)
        self.layer1 = self._layer(width, width, 1, norm)
        self.layer2 = self._layer(width, 2 * width, 2, norm)
        self.layer3 = self._layer(2 * width, 4 * width, 2, norm)
        self.layer4 = self._layer(4 * width, 8 * width, 2, norm)
        self.fc_bottleneck = nn.Linear(8 * width, code_dim)
        self.fc_final = nn.Linear(code_dim, control_dim)

    @staticmethod
    def _layer(inputs: int, outputs: int, stride: int, norm: str) -> nn.Sequential:
        return nn.Sequential(
            BasicBlock(inputs, outputs, stride, norm), BasicBlock(outputs, outputs, 1, norm)
        )

    def code(self, x: torch.Tensor) -> torch.Tensor:
        """Return the bottleneck code (n, code_dim) of (n, 3, h, w)."""
        y = functional.relu(self.norm(self.conv1(x)))
        y = functional.max_pool2d(y, 3, 2, 1)
        y = self.layer4(self.layer3(self.layer2(self.layer1(y))))
        return self.fc_bottleneck(y.mean(dim=(2, 3)))

    def controls(self, code: torch.Tensor) -> torch.Tensor:
        """Return the decoder's controls (n, control_dim) of codes (n, code_dim)."""
        return self.fc_final(code)


def _branch_norm(norm: str, channels: int) -> nn.Module:
    """Return the normalisation inside residual branches."""
    if norm not in NORMS:
        raise ValueError(f"expected a norm of {NORMS}, found {norm!r}")
    if norm == "instance":
        return nn.InstanceNorm2d(channels)
    return nn.GroupNorm(_GROUPS, channels, affine=False)


def _trunk_norm(norm: str, channels: int) -> nn.Module:
    """Return the normalisation of stem and shortcuts."""
    return nn.InstanceNorm2d(channels) if norm == "instance" else nn.Identity()
