"""Training losses other than Gram matrices: spectra, differentiable metrics, and colours.

Images are ``(n, 3, h, w) float32`` RGB in [0, 1].
"""

from __future__ import annotations

from collections.abc import Sequence

import torch

from plan2scene.metrics.color_freq_tile import periodic_component
from plan2scene.textures.model.hsv import rgb_to_hsv
from plan2scene.textures.model.statistics import OPPONENT, SpectrumStatistics, opponent

#: Inner edges of the COLOR metric's bins of lightness and saturation, and the softness used here.
_THIRDS = (0.333, 0.666)
_SOFTNESS = 0.015


def spectrum_distance(
    statistics: SpectrumStatistics, images: torch.Tensor, targets: torch.Tensor
) -> torch.Tensor:
    """Return the mean absolute difference of log amplitude over sectors and rings: (n,)."""
    mine, theirs = statistics.log_power(images), statistics.log_power(targets)
    luminance = (mine[0] - theirs[0]).abs().mean(1)
    return 0.5 * luminance + 0.25 * (mine[1] - theirs[1]).abs().mean((1, 2))


def histogram_distance(images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Return (n,): L1 distance in [0, 1] of soft HSL histograms, a differentiable COLOR metric.

    The bins are those of :mod:`plan2scene.metrics.color_freq_tile` with softened edges.
    """
    gap = _soft_histogram(images) - _soft_histogram(targets)
    return gap.abs().sum((1, 2)) / 2.0


def _soft_histogram(rgb: torch.Tensor) -> torch.Tensor:
    """Return (n, 10, 9) shares of pixels by hue, and by lightness and saturation."""
    top, bottom = rgb.max(dim=1).values, rgb.min(dim=1).values
    lightness, span = (top + bottom) / 2.0, top - bottom
    room = (1.0 - (2.0 * lightness - 1.0).abs()).clamp(min=0.02)
    hue = rgb_to_hsv(rgb)[:, 0]
    hue = torch.where(span > 0.01, hue, hue.detach())  # the hue of a grey has no useful gradient
    bins = [
        _soft_bins(value.flatten(1), edges)
        for value, edges in ((lightness, _THIRDS), (span / room, _THIRDS))
    ]
    joint = (bins[0].unsqueeze(3) * bins[1].unsqueeze(2)).flatten(2)  # (n, pixels, 9)
    tenths = [k / 10 for k in range(1, 10)]
    return _soft_bins(hue.flatten(1), tenths).transpose(1, 2) @ joint / joint.shape[1]


def _soft_bins(values: torch.Tensor, edges: Sequence[float]) -> torch.Tensor:
    """Return soft bin memberships (n, pixels, bins), summing to 1, of values (n, pixels)."""
    steps = ((values.unsqueeze(2) - values.new_tensor(edges)) / _SOFTNESS).sigmoid()
    ends = torch.ones_like(values).unsqueeze(2)
    return torch.cat([ends, steps], dim=2) - torch.cat([steps, torch.zeros_like(ends)], dim=2)


def frequency_distance(tiles: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Return (n,): a differentiable FREQ metric of tiles (periodic) and crops (not periodic).

    It is the mean absolute difference, over integer radii, of mean spectral amplitudes of grey
    values 0..255.
    """
    grey = tiles.new_tensor(OPPONENT[0]).view(1, 3, 1, 1) * 255.0
    mine, theirs = ((rgb * grey).sum(1) for rgb in (tiles, targets))
    gap = _radial_amplitude(mine) - _radial_amplitude(_periodic_component(theirs))
    return gap.abs().mean(1)


def _periodic_component(images: torch.Tensor) -> torch.Tensor:
    """Return the periodic component of images (n, s, s) (Moisan 2011), without gradients."""
    grey = images.detach().double().cpu().numpy()
    return torch.stack([torch.from_numpy(periodic_component(image)) for image in grey]).to(images)


def _radial_amplitude(images: torch.Tensor) -> torch.Tensor:
    """Return (n, s // 2) mean amplitudes by integer radius of images (n, s, s)."""
    size = images.shape[-1]
    line = torch.fft.fftfreq(size, 1 / size, device=images.device)
    radius = torch.hypot(line.view(-1, 1), line.view(1, -1)).long().clamp(max=size // 2).flatten()
    spectrum = torch.fft.fft2(images - images.mean((1, 2), keepdim=True)) / size**2
    amplitude = torch.sqrt(spectrum.real**2 + spectrum.imag**2 + 1e-10).flatten(1)
    counts = torch.bincount(radius)
    sums = amplitude.new_zeros(len(images), len(counts)).index_add(1, radius, amplitude)
    return (sums / counts)[:, : size // 2]


def colour_distance(images: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Return (n,): sliced Wasserstein distance of the colour distributions.

    It is the mean absolute difference of sorted values along each RGB channel and opponent axis.
    Images of both arguments must have the same number of pixels.
    """
    sorted_values = []
    for rgb in (images, targets):
        values = torch.cat([rgb, 0.5 * opponent(rgb)], dim=1).flatten(2)
        sorted_values.append(values.sort(dim=2).values)
    return (sorted_values[0] - sorted_values[1]).abs().mean((1, 2))
