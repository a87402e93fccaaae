"""Crop encoders: the paper's ResNet-18 with instance normalisation, and one of fixed statistics.

Both turn crops into a bottleneck code and codes into the decoder's controls (paper section 5.2).
The second reads the energies of a fixed filter bank and the spectrum instead of learned features:
it learns from some thousand textures within minutes on a CPU, where the residual network needs
orders of magnitude more steps.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import nn
from torch.nn import functional

from plan2scene.textures.model.statistics import (
    FilterBankStatistics,
    SpectrumStatistics,
    colour_quantiles,
    moments_of,
)


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


class StatisticsEncoder(nn.Module):
    """Crop (n, 3, h, w) -> code and controls as :class:`Encoder`, through fixed statistics.

    Moments of the embedded filter bank's responses at four levels, log power by sector of the
    spectrum and the colours' distribution, standardised (buffers, set once from examples), then
    a network of one hidden layer. The colour is seen even where the code need not tell it: wood
    is known by it.

    Parameters
    ----------
    width : int
        Hidden units.
    code_dim, control_dim : int
        As of :class:`Encoder`.
    """

    def __init__(self, width: int, code_dim: int, control_dim: int) -> None:
        super().__init__()
        self.dropout = 0.0
        # In memory also where a network is built without ("meta"): to compute there, torch loads
        # its compiler, which takes as long as torch itself.
        with torch.device("cpu"), torch.no_grad():
            self.filters = FilterBankStatistics()
            self.spectrum = SpectrumStatistics()
            count = self.features(torch.zeros(1, 3, 128, 128)).shape[1]
        self.centre: torch.Tensor
        self.scale: torch.Tensor
        self.register_buffer("centre", torch.zeros(count))
        self.register_buffer("scale", torch.ones(count))
        self.hidden = nn.Linear(count, width)
        self.fc_bottleneck = nn.Linear(width, code_dim)
        self.fc_final = nn.Linear(code_dim, control_dim)

    def features(
        self, rgb: torch.Tensor, responses: Sequence[torch.Tensor] | None = None
    ) -> torch.Tensor:
        """Return the statistics (n, k) of crops (n, 3, 128, 128), RGB in [0, 1].

        They are the same of all encoders of this kind; `responses` are those of `filters` to the
        crops, where they are known.
        """
        moments = moments_of(self.filters.responses(rgb) if responses is None else responses)
        luminance, chroma = self.spectrum.log_power(rgb)
        parts = [moments, luminance, chroma.flatten(1), colour_quantiles(rgb)]
        return torch.cat(parts, dim=1)

    def standardise(self, features: torch.Tensor) -> None:
        """Set centre and scale from the features (n, k) of example crops."""
        self.centre.copy_(features.mean(0))
        self.scale.copy_(features.std(0) + 1e-3)

    def code_of_features(self, features: torch.Tensor) -> torch.Tensor:
        """Return codes (n, code_dim) of statistics (n, k)."""
        # Crops unlike all examples stay within what the network has seen.
        x = ((features - self.centre) / self.scale).clamp(-4.0, 4.0)
        hidden = functional.dropout(functional.relu(self.hidden(x)), self.dropout, self.training)
        return self.fc_bottleneck(hidden)

    def code(self, x: torch.Tensor) -> torch.Tensor:
        """Return the bottleneck code (n, code_dim) of RGB crops (n, 3, 128, 128)."""
        return self.code_of_features(self.features(x))

    def controls(self, code: torch.Tensor) -> torch.Tensor:
        """Return the decoder's controls (n, control_dim) of codes (n, code_dim)."""
        return self.fc_final(code)
