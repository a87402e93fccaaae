"""The texture decoder: a small network applied to the noise at every pixel (paper section 5.2)."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional


class _Layer(nn.Module):
    """Holds a 1x1 convolution under the name that checkpoints use (``...layer.weight``)."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.layer = nn.Conv2d(inputs, outputs, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return (n, pixels, outputs) of (n, pixels, inputs), computed in the dtype of `x`."""
        weight, bias = self.layer.weight[:, :, 0, 0], self.layer.bias
        return functional.linear(x, weight.to(x.dtype), None if bias is None else bias.to(x.dtype))


class Decoder(nn.Module):
    """Style (n, style_dim) and noise (n, noise_maps, h, w) -> (n, 3, h, w) in [-1, 1].

    Parameters
    ----------
    style_dim, noise_maps : int
        Inputs per pixel: 64 style values (the same everywhere) and 48 noise maps.
    width, hidden : int
        Channels and number of the hidden layers after the first.
    low_precision : bool
        Multiply in bfloat16 (three times faster on CPUs that have it; weights stay float32).
    """

    def __init__(
        self, style_dim: int = 64, noise_maps: int = 48, width: int = 128, hidden: int = 4
    ) -> None:
        super().__init__()
        self.style_dim = style_dim
        self.low_precision = False
        self.first_conv = _Layer(style_dim + noise_maps, width)
        self.res_blocks = nn.ModuleList(_Layer(width, width) for _ in range(hidden))
        self.last_conv = _Layer(width, 3)

    def forward(self, style: torch.Tensor, noise: torch.Tensor) -> torch.Tensor:
        """Return tanh of the network's output, (n, 3, h, w) float32."""
        n, _, h, w = noise.shape
        dtype = torch.bfloat16 if self.low_precision else noise.dtype
        pixels = noise.to(dtype).flatten(2).transpose(1, 2)  # (n, h w, noise_maps)
        first = self.first_conv.layer
        weight = first.weight[:, :, 0, 0]
        # The style is constant over the tile: its share of the first layer is a bias per texture.
        bias = functional.linear(style, weight[:, : self.style_dim], first.bias)
        y = pixels @ weight[:, self.style_dim :].T.to(dtype) + bias.to(dtype).unsqueeze(1)
        y = functional.relu(y, inplace=True)
        for block in self.res_blocks:
            y = functional.relu(block(y), inplace=True)
        y = torch.tanh(self.last_conv(y).float())
        return y.transpose(1, 2).reshape(n, 3, h, w)


def low_precision_is_fast() -> bool:
    """Return whether this processor multiplies bfloat16 natively."""
    return bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())
