"""The embedded segmentation network: a photo in, logits of its labels at half resolution out.

It is small enough to ship and to train on a few processor cores: an encoder of inverted residuals,
a block that averages features over rows, columns and the whole picture, and a light decoder to half
resolution.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, TypeVar

import torch
from torch import nn
from torch.nn import functional as F
from torch.nn.utils.fusion import fuse_conv_bn_eval

from plan2scene.photos.labels.imagenet import BLOCKS, imagenet_maps, load_imagenet

#: Mean and standard deviation of sRGB values in [0, 1] that the network's input is scaled by.
_MEAN, _STD = 0.5, 0.25


def _conv(n_in: int, n_out: int, size: int, stride: int = 1, groups: int = 1) -> nn.Sequential:
    """Return convolution and batch norm without activation."""
    return nn.Sequential(
        nn.Conv2d(n_in, n_out, size, stride, size // 2, groups=groups, bias=False),
        nn.BatchNorm2d(n_out),
    )


class InvertedResidual(nn.Module):
    """Expand by 1x1, filter each channel by 3x3, project by 1x1 (Sandler et al. 2018).

    Shapes: (n, n_in, h, w) -> (n, n_out, h / stride, w / stride).
    """

    def __init__(self, n_in: int, n_out: int, *, stride: int = 1, expansion: int = 4) -> None:
        super().__init__()
        hidden = n_in * expansion
        self.layers = nn.Sequential(
            _conv(n_in, hidden, 1),
            nn.Hardswish(),
            _conv(hidden, hidden, 3, stride, groups=hidden),
            nn.Hardswish(),
            _conv(hidden, n_out, 1),
        )
        self.residual = stride == 1 and n_in == n_out

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return the block's output, with the input added where shapes allow."""
        y: torch.Tensor = self.layers(x)
        return x + y if self.residual else y


class WholePicture(nn.Module):
    """Add filtered means of the features of each row, each column and the whole picture.

    Whether a grey region is ceiling or wall depends on what is below and beside it, far beyond
    the receptive field of a small encoder. Shapes: (n, c, h, w) -> (n, c, h, w).
    """

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.rows = nn.Conv2d(channels, channels, (5, 1), padding=(2, 0))
        self.columns = nn.Conv2d(channels, channels, (1, 5), padding=(0, 2))
        self.picture = nn.Conv2d(channels, channels, 1)
        self.mix = _conv(channels, channels, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return `x` with the three averages mixed in."""
        rows = self.rows(x.mean(dim=3, keepdim=True))
        columns = self.columns(x.mean(dim=2, keepdim=True))
        picture = self.picture(x.mean(dim=(2, 3), keepdim=True))
        y: torch.Tensor = self.mix(F.hardswish(x + rows + columns + picture))
        return x + y


class Attention(nn.Module):
    """Self-attention among all positions (Vaswani et al. 2017).

    A material that is floor in one place is floor elsewhere, too. A new block is the identity.
    Shapes: (n, c, h, w) -> (n, c, h, w), c a multiple of `HEAD`.
    """

    HEAD = 32  #: channels of an attention head

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.heads = channels // self.HEAD
        self.norm, self.norm_wide = nn.GroupNorm(1, channels), nn.GroupNorm(1, channels)
        self.ask = nn.Conv2d(channels, 3 * channels, 1)
        self.mix = nn.Conv2d(channels, channels, 1)
        self.wide = nn.Conv2d(channels, 2 * channels, 1)
        self.narrow = nn.Conv2d(2 * channels, channels, 1)
        for last in (self.mix, self.narrow):
            nn.init.zeros_(last.weight)
            nn.init.zeros_(last.bias)  # type: ignore[arg-type]

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return `x` plus the attended values and a feed-forward layer."""
        n, c, h, w = x.shape
        parts = self.ask(self.norm(x)).reshape(n, 3, self.heads, self.HEAD, h * w)
        query, key, value = (parts[:, k].transpose(2, 3) for k in range(3))
        attended = F.scaled_dot_product_attention(query, key, value)
        x = x + self.mix(attended.transpose(2, 3).reshape(n, c, h, w))
        y: torch.Tensor = x + self.narrow(F.hardswish(self.wide(self.norm_wide(x))))
        return y


class _Up(nn.Module):
    """Double the resolution, add the encoder's map of that resolution, filter (if `filtered`)."""

    def __init__(self, n_in: int, n_skip: int, n_out: int, *, filtered: bool = True) -> None:
        super().__init__()
        self.lateral = _conv(n_skip, n_out, 1)
        self.deep = _conv(n_in, n_out, 1)
        # At half resolution a block of its own would cost as much as the whole encoder.
        self.filter = InvertedResidual(n_out, n_out, expansion=2) if filtered else nn.Identity()

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        deep = F.interpolate(self.deep(x), size=skip.shape[2:], mode="bilinear")
        y: torch.Tensor = self.filter(F.hardswish(deep + self.lateral(skip)))
        return y


class SegmentationNet(nn.Module):
    """Photo -> logits of its labels at half resolution.

    (n, 3, h, w) float32 in [0, 1], h and w multiples of 32 -> (n, labels, h / 2, w / 2).

    `widths` are the channels at strides 2, 4, 8, 16, 32; `depths` the number of blocks at strides 4
    to 32; `decoder` the decoder's channels at strides 16 and 8 (half of it at 4, a quarter at 2);
    `attention` the number of attention blocks at stride 32, and in the decoder at 16. With
    `elevation` the network also takes each pixel's elevation above the horizon, where known.
    `labels` is 4 (other, floor, wall, ceiling) or 6 (door and window as well).

    Three are only kept here for `segmentation.Segmenter`. It scales photos relative to `long_side`
    pixels. It adds `logit_adjustment` to the logits, because photos have other shares of the labels
    than the renderings of the training (Menon et al. 2021, arXiv 2007.07314); for door and window
    only if they are asked for. It divides the logits by `temperature`, to calibrate the
    probabilities.
    """

    def __init__(
        self,
        *,
        widths: Sequence[int] = (16, 24, 56, 112, 192),
        depths: Sequence[int] = (2, 3, 5, 3),
        decoder: int = 64,
        attention: int = 0,
        long_side: int = 320,
        elevation: bool = False,
        labels: int = 4,
        temperature: float = 1.0,
        logit_adjustment: Sequence[float] = (),
    ) -> None:
        super().__init__()
        if len(logit_adjustment) not in (0, labels):
            raise ValueError(f"{len(logit_adjustment)} adjustments of {labels} labels")
        self.long_side, self.elevation = long_side, elevation
        self.architecture: dict[str, Any] = {
            "widths": list(widths),
            "depths": list(depths),
            "decoder": decoder,
            "attention": attention,
            "long_side": long_side,
            "elevation": elevation,
            "labels": labels,
            "temperature": temperature,
            "logit_adjustment": list(logit_adjustment) or [0.0] * labels,
        }
        # Two more channels hold row and column in [-1, 1]: floors are mostly low in a photo.
        channels = 7 if elevation else 5
        self.stem = nn.Sequential(_conv(channels, widths[0], 3, stride=2), nn.Hardswish())
        self.stages = nn.ModuleList(
            nn.Sequential(
                InvertedResidual(n_in, n_out, stride=2, expansion=2 if k == 0 else 4),
                *(InvertedResidual(n_out, n_out) for _ in range(depth - 1)),
            )
            for k, (n_in, n_out, depth) in enumerate(
                zip(widths[:-1], widths[1:], depths, strict=True)
            )
        )
        self.context = WholePicture(widths[4])
        self.attention, self.attention_up = (
            nn.Sequential(*(Attention(c) for _ in range(attention))) for c in (widths[4], decoder)
        )
        self.ups = nn.ModuleList(
            [
                _Up(widths[4], widths[3], decoder),
                _Up(decoder, widths[2], decoder),
                _Up(decoder, widths[1], decoder // 2),
                _Up(decoder // 2, widths[0], decoder // 4, filtered=False),
            ]
        )
        self.head = nn.Conv2d(decoder // 4, labels, 3, padding=1)

    def encoded(self, x: torch.Tensor, elevation: torch.Tensor | None = None) -> list[torch.Tensor]:
        """Return the encoder's maps at strides 2, 4, 8, 16, 32; arguments as in :meth:`forward`."""
        *skips, y = self._maps_of_encoder(x, elevation)
        return [*skips, self.attention(self.context(y))]

    def _maps_of_encoder(
        self, x: torch.Tensor, elevation: torch.Tensor | None
    ) -> list[torch.Tensor]:
        """Return the maps of :meth:`encoded` before `context` and `attention`."""
        n, _, h, w = x.shape
        rows = torch.linspace(-1, 1, h, device=x.device).view(1, 1, h, 1).expand(n, 1, h, w)
        columns = torch.linspace(-1, 1, w, device=x.device).view(1, 1, 1, w).expand(n, 1, h, w)
        planes = [(x - _MEAN) / _STD, rows, columns]
        if self.elevation:
            if elevation is None:
                elevation = x.new_full((n, h, w), torch.nan)
            known = ~elevation.isnan()
            planes += [(2 * elevation).where(known, 0)[:, None], known[:, None].to(x.dtype)]
        y = self.stem(torch.cat(planes, dim=1))
        encoded = [y]
        for stage in self.stages:
            y = stage(y)
            encoded.append(y)
        return encoded

    def maps(self, x: torch.Tensor, elevation: torch.Tensor | None = None) -> list[torch.Tensor]:
        """Return the decoder's maps at strides 16, 8, 4 and 2; arguments as in :meth:`forward`."""
        *skips, y = self.encoded(x, elevation)
        decoded: list[torch.Tensor] = []
        for up, skip in zip(self.ups, reversed(skips), strict=True):
            y = up(y, skip)
            if not decoded:
                y = self.attention_up(y)
            decoded.append(y)
        return decoded

    def forward(self, x: torch.Tensor, elevation: torch.Tensor | None = None) -> torch.Tensor:
        """Return logits; see the class for shapes.

        `elevation` is (n, h, w) float32 of :func:`.segmentation.elevation_map`; NaN where it is not
        known. A network that was made without `elevation` ignores it.
        """
        logits: torch.Tensor = self.head(self.maps(x, elevation)[-1])
        return logits


class ImagenetSegmentationNet(SegmentationNet):
    """A :class:`SegmentationNet` that adds maps of an ImageNet network to its encoder's maps.

    Renderings do not show what all real things look like. Training leaves both encoders unchanged:
    it learns an adapter at each stride, which begins with zero output, and trains the rest further.
    Shapes as in :class:`SegmentationNet`. The state does not contain the weights of the ImageNet
    encoder (:mod:`.imagenet`).
    """

    #: In training, probabilities that the own maps are dropped at strides 16 and 32, and that the
    #: ImageNet maps are dropped at all strides, so that the network does not rely on one encoder.
    alone = (0.25, 0.15)

    def __init__(self, **architecture: Any) -> None:
        super().__init__(**architecture)
        self.architecture["imagenet"] = True
        self._imagenet = (load_imagenet(),)  # in a tuple, or it would be part of the state
        self.adapters = nn.ModuleList(
            nn.Sequential(
                nn.BatchNorm2d(n_in),
                nn.Conv2d(n_in, n_out, 1),
                nn.Hardswish(),
                nn.Conv2d(n_out, n_out, 1),
            )
            for n_in, n_out in zip(BLOCKS.values(), self.architecture["widths"], strict=True)
        )
        for adapter in self.adapters:
            for parameter in list(adapter.children())[-1].parameters():
                nn.init.zeros_(parameter)
        self.stem.requires_grad_(False)
        self.stages.requires_grad_(False)

    def train(self, mode: bool = True) -> ImagenetSegmentationNet:
        """Set the training mode of all parts but the encoder, which stays in evaluation mode."""
        super().train(mode)
        self.stem.eval()
        self.stages.eval()
        return self

    def _maps_of_encoder(
        self, x: torch.Tensor, elevation: torch.Tensor | None
    ) -> list[torch.Tensor]:
        with torch.no_grad():
            own_maps = super()._maps_of_encoder(x, elevation)
            other = imagenet_maps(self._imagenet[0].to(x.device), x)
        chance = torch.full((1, 1, 1, 1), 0.5, device=x.device)
        if self.training:
            chance = torch.rand(len(x), 1, 1, 1, device=x.device)
        uses_own, uses_imagenet = chance >= self.alone[0], chance < 1.0 - self.alone[1]
        return [
            (own_maps[k] * uses_own if k >= 3 else own_maps[k]) + adapter(other[k]) * uses_imagenet
            for k, adapter in enumerate(self.adapters)
        ]


MOST_MEMBERS = 8  #: Largest number of networks in an ensemble; files may come from strangers


class Ensemble(nn.Module):
    """Networks of one architecture whose logits are averaged (Hansen & Salamon 1990).

    Networks from different training runs make different mistakes. Shapes and input are those of
    :class:`SegmentationNet`; `architecture` are its keywords.

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


_Network = TypeVar("_Network", bound=nn.Module)


def folded(network: _Network) -> _Network:
    """Return a copy of a network for inference, with the same outputs up to rounding.

    Each batch norm that follows a convolution in a sequence is folded into its weights. Weights are
    stored channels last, which suits convolutions on processors. Both save a third of the time. The
    copy shares nothing with `network`, is in evaluation mode and cannot be trained.
    """
    quick = copy.deepcopy(network).eval()
    for module in list(quick.modules()):
        if isinstance(module, nn.Sequential):
            _fold(module)
        elif isinstance(module, nn.Hardswish):
            module.inplace = True  # nothing else reads the output of the convolution before it
    quick.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return quick.requires_grad_(False)


def _fold(sequence: nn.Sequential) -> None:
    """Fold the batch norms of a sequence into the convolutions right before them."""
    for k in range(len(sequence) - 1):
        convolution, norm = sequence[k], sequence[k + 1]
        if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
            sequence[k] = fuse_conv_bn_eval(convolution, norm)
            sequence[k + 1] = nn.Identity()
