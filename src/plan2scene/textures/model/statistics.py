"""Texture statistics: how alike two textures are, regardless of where their details lie.

A fixed multi-scale filter bank (after Ustyuzhaninov et al. 2016, who show that Gram matrices of
fixed rectified filters describe texture), the spectrum by sector, and quantiles of the colours.
Images are ``(n, 3, h, w) float32`` RGB in [0, 1].
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence

import torch
from torch import nn
from torch.nn import functional

from plan2scene.seeds import derive_seed

_FILTER_PX = 7
_RANDOM_FILTERS = 18
_SIZES, _ORIENTATIONS = (64, 128), 6  #: Sides of images, px; sectors of a half circle of a spectrum
#: Added to Gram norms: flat textures have less, and their noise should not count as a pattern.
_FLAT = 4e-4
#: Luminance and two opponent colours; chroma is scaled up because its contrast is lower.
OPPONENT = [[0.299, 0.587, 0.114], [1.0, -1.0, 0.0], [-0.5, -0.5, 1.0]]


def gram(features: torch.Tensor) -> torch.Tensor:
    """Return Gram matrices (n, c, c) of features (n, c, h, w), divided by h w."""
    flat = features.flatten(2)
    return flat @ flat.transpose(1, 2) / flat.shape[2]


def opponent(rgb: torch.Tensor) -> torch.Tensor:
    """Return luminance and two opponent colours (n, 3, h, w) of RGB (n, 3, h, w)."""
    matrix = torch.tensor(OPPONENT, dtype=rgb.dtype, device=rgb.device)
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

    Each level is half the size of the one before; levels under 16 px are left out. Images are
    mirrored at the border.
    """

    def __init__(self, levels: int = 5) -> None:
        super().__init__()
        self.levels = levels
        self.bank: torch.Tensor
        self.register_buffer("bank", _filter_bank(), persistent=False)

    def grams(self, rgb: torch.Tensor) -> list[torch.Tensor]:
        """Return :func:`grams_of` the images' responses."""
        return grams_of(self.responses(rgb))

    def responses(self, rgb: torch.Tensor) -> Iterator[torch.Tensor]:
        """Yield the filters' responses (n, k, h, w) level by level."""
        image = opponent(rgb)
        for level in range(self.levels):
            if level:
                image = functional.avg_pool2d(image, 2)
            if min(image.shape[2:]) < 16 and level:
                break
            border = _FILTER_PX // 2
            padded = functional.pad(image, (border,) * 4, mode="reflect")
            yield functional.conv2d(padded, self.bank)


def grams_of(responses: Iterable[torch.Tensor]) -> list[torch.Tensor]:
    """Return one Gram matrix (n, 2 k, 2 k) per level: responses (n, k, h, w) split by sign."""
    return [gram(torch.cat([level.relu(), (-level).relu()], dim=1)) for level in responses]


def moments_of(responses: Iterable[torch.Tensor]) -> torch.Tensor:
    """Return (n, levels * (k + 2 m)) moments of the responses (n, k, h, w) at each level.

    They are the log mean square of all k filters, then skewness and log kurtosis of the m filters
    that are not random mixtures. Joints between tiles make both large; weave and grain do not.
    """
    parts = []
    for level in responses:
        energy = level.square().mean(dim=(2, 3)) + 1e-5
        shaped = level[:, :-_RANDOM_FILTERS]
        power = energy[:, :-_RANDOM_FILTERS]
        skewness = (shaped**3).mean(dim=(2, 3)) / power**1.5
        kurtosis = (shaped**4).mean(dim=(2, 3)) / power**2
        parts += [energy.log(), skewness, (kurtosis + 0.1).log()]
    return torch.cat(parts, dim=1)


def gram_distance(images: Sequence[torch.Tensor], targets: Sequence[torch.Tensor]) -> torch.Tensor:
    """Return the relative error of the Gram matrices, averaged over levels: (n,).

    It is the norm of the difference over the norm of the target, so coarse levels and faint
    textures have the same weight as strong ones.
    """
    total = images[0].new_zeros(len(images[0]))
    for mine, theirs in zip(images, targets, strict=True):
        gap = (mine - theirs).flatten(1).square().sum(1)
        total = total + (gap + 1e-12).sqrt() / (theirs.flatten(1).norm(dim=1) + _FLAT)
    return total / len(targets)


def _sectors(size: int, orientations: int) -> torch.Tensor:
    """Return (sectors, size * (size // 2 + 1)) weights that average a half spectrum by sector."""
    with torch.device("cpu"):  # the data decide which rows there are: not on "meta"
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
        weights /= weights.sum(1, keepdim=True)
    return weights.to(torch.get_default_device())


class SpectrumStatistics(nn.Module):
    """Log power in rings (and, for luminance, sectors) of the windowed spectrum."""

    def __init__(self) -> None:
        super().__init__()
        for size in _SIZES:
            self.register_buffer(f"sectors{size}", _sectors(size, _ORIENTATIONS), persistent=False)
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


def colour_quantiles(rgb: torch.Tensor) -> torch.Tensor:
    """Return (n, 21) quantiles of luminance and opponent colours.

    First the three medians, then for each of the three the signed square roots of the differences
    of six quantiles from the median.
    """
    levels = rgb.new_tensor([0.5, 0.02, 0.1, 0.25, 0.75, 0.9, 0.98])
    values = opponent(rgb).flatten(2)[:, :, ::4]
    quantiles = torch.quantile(values, levels, dim=2).permute(1, 2, 0)
    median, away = quantiles[:, :, 0], quantiles[:, :, 1:] - quantiles[:, :, :1]
    roots = away.sign() * (away.abs() + 1e-3).sqrt()
    return torch.cat([median, roots.flatten(1)], dim=1)
