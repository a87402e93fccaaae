"""The crop encoder: ResNet-18's layout with instance normalisation (paper section 4.3)."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional


class BasicBlock(nn.Module):
    """Two 3x3 convolutions with a shortcut; names follow torchvision's checkpoints."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.norm = nn.InstanceNorm2d(outputs)
        self.downsample: nn.Sequential | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.InstanceNorm2d(outputs)
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
    """

    def __init__(self, width: int = 64, code_dim: int = 8, control_dim: int = 96) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(3, width, 7, 2, 3, bias=False)
        self.norm = nn.InstanceNorm2d(width)
        self.layer1 = self._layer(width, width, 1)
        self.layer2 = self._layer(width, 2 * width, 2)
        self.layer3 = self._layer(2 * width, 4 * width, 2)
        self.layer4 = self._layer(4 * width, 8 * width, 2)
        self.fc_bottleneck = nn.Linear(8 * width, code_dim)
        self.fc_final = nn.Linear(code_dim, control_dim)

    @staticmethod
    def _layer(inputs: int, outputs: int, stride: int) -> nn.Sequential:
        return nn.Sequential(BasicBlock(inputs, outputs, stride), BasicBlock(outputs, outputs, 1))

    def code(self, x: torch.Tensor) -> torch.Tensor:
        """Return the bottleneck code (n, code_dim) of (n, 3, h, w)."""
        y = functional.relu(self.norm(self.conv1(x)))
        y = functional.max_pool2d(y, 3, 2, 1)
        y = self.layer4(self.layer3(self.layer2(self.layer1(y))))
        return self.fc_bottleneck(y.mean(dim=(2, 3)))

    def controls(self, code: torch.Tensor) -> torch.Tensor:
        """Return the decoder's controls (n, control_dim) of codes (n, code_dim)."""
        return self.fc_final(code)
