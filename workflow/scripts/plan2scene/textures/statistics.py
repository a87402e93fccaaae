"""Texture statistics: how alike two textures are, wherever their details lie.

Two sources with one interface, ``distance(images, targets) -> (n,)``: a fixed multi-scale filter
bank (``embedded``, nothing to download; after Ustyuzhaninov et al. 2016, who show that Gram
matrices of fixed rectified filters carry texture), and VGG-19 (``pretrained``, the paper's).
Images are ``(n, 3, h, w) float32`` RGB in [0, 1].
"""

from __future__ import annotations

import itertools
import math
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import torch
from torch import nn
from torch.nn import functional

from plan2scene.errors import InputError
from plan2scene.seeds import derive_seed

_FILTER_PX = 7
_RANDOM_FILTERS = 18
#: Gram norms below this belong to flat textures, whose noise should not count as a pattern.
_FLAT = 4e-4
#: Luminance and two opponent colours; chroma is scaled up because its contrast is lower.
_OPPONENT = [[0.299, 0.587, 0.114], [1.0, -1.0, 0.0], [-0.5, -0.5, 1.0]]


class TextureStatistics(Protocol):
    """What tells textures apart: a source of statistics."""

    def distance(self, images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """Return (n,) distances of images (n, 3, h, w) from targets, RGB in [0, 1]."""
        ...


def gram(features: torch.Tensor) -> torch.Tensor:
    """Return Gram matrices (n, c, c) of features (n, c, h, w), divided by h w."""
    flat = features.flatten(2)
    return flat @ flat.transpose(1, 2) / flat.shape[2]


def opponent(rgb: torch.Tensor) -> torch.Tensor:
    """Return luminance and two opponent colours (n, 3, h, w) of RGB (n, 3, h, w)."""
    matrix = torch.tensor(_OPPONENT, dtype=rgb.dtype, device=rgb.device)
    return torch.einsum("ij,njhw->nihw", matrix, rgb)


def _filter_bank() -> torch.Tensor:
    """Return the filters (k, 3, 7, 7): oriented edges and bars, blobs, and random mixtures.

    All have zero mean (the colour itself is no pattern) and unit norm.
    """
    line = torch.arange(_FILTER_PX, dtype=torch.float64) - _FILTER_PX // 2
    y, x = torch.meshgrid(line, line, indexing="ij")
    envelope = torch.exp(-(x**2 + y**2) / (2 * 1.5**2))
    shapes: list[tuple[int, torch.Tensor]] = []
    for step in range(4):
        along = math.cos(step * math.pi / 4) * x + math.sin(step * math.pi / 4) * y
        for phase in (0.0, math.pi / 2):
            shapes.append((0, envelope * torch.cos(1.6 * along + phase)))
    narrow = torch.exp(-(x**2 + y**2) / (2 * 0.8**2))
    blob = narrow / narrow.sum() - envelope / envelope.sum()
    shapes += [(channel, blob) for channel in range(3)]
    shapes += [(channel, envelope * along) for channel in (1, 2) for along in (x, y)]
    bank = torch.zeros(len(shapes) + _RANDOM_FILTERS, 3, _FILTER_PX, _FILTER_PX).double()
    for index, (channel, shape) in enumerate(shapes):
        bank[index, channel] = shape
    source = torch.Generator().manual_seed(derive_seed(0, "texture statistics") % 2**31)
    noise = torch.randn(_RANDOM_FILTERS, 3, _FILTER_PX, _FILTER_PX, generator=source)
    bank[len(shapes) :] = noise.double() * envelope
    support = envelope / envelope.sum()
    bank = bank - (bank.sum((2, 3), keepdim=True)) * support
    return (bank / bank.flatten(1).norm(dim=1).view(-1, 1, 1, 1)).float()


class FilterBankStatistics(nn.Module):
    """Gram matrices of a fixed rectified filter bank on the levels of an image pyramid.

    Parameters
    ----------
    levels : int
        Pyramid levels, each half the size of the one before; levels under 16 px are left out.
    periodic : bool
        Images repeat (tiles): filters wrap around. Otherwise they are mirrored at the border.
    """

    def __init__(self, levels: int = 5, *, periodic: bool = False) -> None:
        super().__init__()
        self.levels = levels
        self.padding = "circular" if periodic else "reflect"
        self.bank: torch.Tensor
        self.register_buffer("bank", _filter_bank(), persistent=False)

    def grams(self, rgb: torch.Tensor) -> list[torch.Tensor]:
        """Return one Gram matrix (n, 2 k, 2 k) per level: responses split by sign."""
        split = ([r.relu(), (-r).relu()] for r in self._responses(rgb))
        return [gram(torch.cat(signs, dim=1)) for signs in split]

    def log_energies(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return (n, levels * k): log mean squared response of each filter at each level."""
        energies = [r.square().mean(dim=(2, 3)) for r in self._responses(rgb)]
        return (torch.cat(energies, dim=1) + 1e-5).log()

    def _responses(self, rgb: torch.Tensor) -> Iterator[torch.Tensor]:
        """Yield the filters' responses (n, k, h, w) level by level."""
        image = opponent(rgb)
        for level in range(self.levels):
            if level:
                image = functional.avg_pool2d(image, 2)
            if min(image.shape[2:]) < 16 and level:
                break
            border = _FILTER_PX // 2
            padded = functional.pad(image, (border,) * 4, mode=self.padding)
            yield functional.conv2d(padded, self.bank)

    def distance(self, images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """Return (n,): the relative error of the Gram matrices, averaged over levels.

        The norm of the difference over the norm of the target's, hence the square root of the
        relative squared error: coarse levels and faint textures weigh as much as loud ones.
        """
        total = images.new_zeros(len(images))
        levels = list(zip(self.grams(images), self.grams(targets), strict=True))
        for mine, theirs in levels:
            gap = (mine - theirs).flatten(1).square().sum(1)
            total = total + (gap + 1e-12).sqrt() / (theirs.flatten(1).norm(dim=1) + _FLAT)
        return total / len(levels)


def _sectors(size: int, orientations: int) -> torch.Tensor:
    """Return (sectors, size * (size // 2 + 1)) weights that average a half spectrum by sector."""
    fy = torch.fft.fftfreq(size, 1 / size).view(-1, 1).expand(-1, size // 2 + 1)
    fx = torch.fft.rfftfreq(size, 1 / size).view(1, -1).expand(size, -1)
    radius = torch.hypot(fx, fy)
    edges = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0]
    edges = [edge for edge in edges if edge <= size / 2]
    angle = torch.remainder(torch.atan2(fy, fx), math.pi) / math.pi
    sector = torch.floor(angle * orientations + 0.5).long() % orientations
    rows = [
        ((radius >= low) & (radius < high) & (sector == turn)).flatten().float()
        for low, high in itertools.pairwise(edges)
        for turn in range(orientations)
    ]
    weights = torch.stack([row for row in rows if row.sum() > 0])
    return weights / weights.sum(1, keepdim=True)


class SpectrumStatistics(nn.Module):
    """Log power in rings (and, for luminance, sectors) of the windowed spectrum."""

    def __init__(self, sizes: tuple[int, ...] = (64, 128), orientations: int = 6) -> None:
        super().__init__()
        for size in sizes:
            self.register_buffer(f"sectors{size}", _sectors(size, orientations), persistent=False)
            self.register_buffer(f"rings{size}", _sectors(size, 1), persistent=False)

    def log_power(self, rgb: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return log power: luminance (n, sectors) and opponent colours (n, 2, rings)."""
        size = rgb.shape[2]
        image = opponent(rgb)
        image = image - image.mean(dim=(2, 3), keepdim=True)
        hann = torch.hann_window(size, periodic=False, dtype=rgb.dtype, device=rgb.device)
        power = torch.fft.rfft2(image * hann * hann.view(-1, 1)).abs().square() / size**2
        flat = power.flatten(2)
        luminance = flat[:, 0] @ self.get_buffer(f"sectors{size}").T
        chroma = flat[:, 1:] @ self.get_buffer(f"rings{size}").T
        return (luminance + 1e-5).log(), (chroma + 1e-5).log()

    def distance(self, images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """Return (n,): mean absolute difference of log amplitude over sectors and rings."""
        mine, theirs = self.log_power(images), self.log_power(targets)
        luminance = (mine[0] - theirs[0]).abs().mean(1)
        return 0.5 * luminance + 0.25 * (mine[1] - theirs[1]).abs().mean((1, 2))


def colour_distance(images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Return (n,): sliced Wasserstein distance of the colour distributions.

    Along each RGB channel and the opponent axes: mean absolute difference of sorted values.
    Images of both arguments have as many pixels.
    """
    sorted_values = []
    for rgb in (images, targets):
        values = torch.cat([rgb, 0.5 * opponent(rgb)], dim=1).flatten(2)
        sorted_values.append(values.sort(dim=2).values)
    return (sorted_values[0] - sorted_values[1]).abs().mean((1, 2))


#: Output channels of VGG-19's convolutions up to relu5_1; "pool" halves the size.
_VGG19: tuple[int | str, ...] = (
    64, 64, "pool", 128, 128, "pool", 256, 256, 256, 256, "pool", 512, 512, 512, 512, "pool", 512,
)  # fmt: skip
#: Indices of the tapped convolutions (relu1_1 ... relu5_1) among torchvision's ``features``.
_VGG19_TAPS = (0, 5, 10, 19, 28)


class VggStatistics(nn.Module):
    """Gram matrices of VGG-19's relu1_1 ... relu5_1 with circular padding of 1 (the paper's).

    Parameters
    ----------
    path : path
        A state dict of torchvision's ``vgg19`` (``features.0.weight`` ...), read with
        ``weights_only=True``.
    """

    _MEAN = (0.485, 0.456, 0.406)
    _STD = (0.229, 0.224, 0.225)

    def __init__(self, path: str | Path) -> None:
        super().__init__()
        try:
            state = torch.load(path, map_location="cpu", weights_only=True)
        except (OSError, RuntimeError, ValueError, pickle.UnpicklingError) as error:
            raise InputError("a state dict of torchvision's vgg19", str(error), file=path) from None
        layers: list[nn.Module] = []
        channels = 3
        for outputs in _VGG19:
            if isinstance(outputs, str):
                layers.append(nn.MaxPool2d(2))
                continue
            layer = nn.Conv2d(channels, outputs, 3, padding=1, padding_mode="circular")
            prefix = f"features.{len(layers)}"
            _fill(layer, state, prefix, path)
            layers += [layer, nn.ReLU()]
            channels = outputs
        self.features = nn.Sequential(*layers).requires_grad_(False).eval()

    def grams(self, rgb: torch.Tensor) -> list[torch.Tensor]:
        """Return the five Gram matrices (n, c, c) of images (n, 3, h, w)."""
        x = (rgb - rgb.new_tensor(self._MEAN).view(1, 3, 1, 1)) / rgb.new_tensor(self._STD).view(
            1, 3, 1, 1
        )
        result = []
        for index, layer in enumerate(self.features):
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


def _fill(layer: nn.Conv2d, state: object, prefix: str, path: str | Path) -> None:
    """Copy ``{prefix}.weight`` and ``.bias`` into a convolution; InputError when they don't fit."""
    for name in ("weight", "bias"):
        target = getattr(layer, name)
        value = state.get(f"{prefix}.{name}") if isinstance(state, dict) else None
        if not isinstance(value, torch.Tensor) or value.shape != target.shape:
            found = "nothing" if value is None else str(getattr(value, "shape", type(value)))
            raise InputError(f"{prefix}.{name} of shape {tuple(target.shape)}", found, file=path)
        with torch.no_grad():
            target.copy_(value)


def load_statistics(source: str, path: str | Path | None = None) -> TextureStatistics:
    """Return the texture statistics of a source: ``embedded``, or ``pretrained`` from `path`."""
    if source == "embedded":
        return FilterBankStatistics()
    if source == "pretrained" and path is not None:
        return VggStatistics(path)
    raise InputError("texture statistics 'embedded', or 'pretrained' with a file", repr(source))
