"""Losses of the segmentation network: of labels, of teachers, and of rendered normals and depth."""

from __future__ import annotations

import torch
from torch import nn
from torch.nn import functional as F

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import DOOR, IGNORE, OTHER, WINDOW

_OTHERS = [OTHER, DOOR, WINDOW]


class GeometryHead(nn.Module):
    """A segmentation network with a further head for training only: normals and depth.

    Walls differ from wardrobes in shape. A network that knows the shape of a room relies less on
    colours. Shapes: the network's, and (n, 4, h / 4, w / 4) for normal and log depth.
    """

    def __init__(self, network: SegmentationNet) -> None:
        super().__init__()
        self.network = network
        channels = int(network.architecture["decoder"]) // 2
        self.geometry = nn.Sequential(
            nn.Conv2d(channels, channels, 3, padding=1), nn.ReLU(), nn.Conv2d(channels, 4, 1)
        )

    def forward(
        self, x: torch.Tensor, elevation: torch.Tensor | None = None
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the labels' logits and the geometry."""
        maps = self.network.maps(x, elevation)
        return self.network.head(maps[-1]), self.geometry(maps[-2])


def segmentation_loss(
    logits: torch.Tensor,
    labels: torch.Tensor,
    dice: float,
    smoothing: float = 0.0,
    openings: torch.Tensor | None = None,
) -> torch.Tensor:
    """Return cross-entropy + `dice` x soft Dice over the batch.

    Parameters
    ----------
    logits : (n, 4 or 6, h / 2, w / 2) float32
        Resized to the labels' size first, so that borders are learned at full resolution.
    labels : (n, h, w) int64
        255 is left out.
    openings : (n,) bool, optional
        Whether the true labels include doors and windows (by default all do). If not, the label
        other stands for any of other, door and window.
    """
    logits = F.interpolate(logits, size=labels.shape[1:], mode="bilinear")
    log = logits.log_softmax(dim=1)
    counted = torch.ones(len(log), log.shape[1], 1, 1, device=log.device)
    if openings is not None and log.shape[1] > WINDOW:
        told = openings.view(-1, 1, 1, 1)
        merged = log[:, _OTHERS].logsumexp(dim=1, keepdim=True)
        log = torch.cat([log[:, :1].where(told, merged), log[:, 1:]], dim=1)
        counted = counted * torch.cat([counted[:, :DOOR], counted[:, DOOR:] * told], dim=1)
    kept = labels != IGNORE
    true = labels.where(kept, 0)
    miss = -log.gather(1, true[:, None])[:, 0]
    if smoothing:
        spread = -(log * counted).sum(dim=1) / counted.sum(dim=1)
        miss = (1 - smoothing) * miss + smoothing * spread
    loss = (miss * kept).sum() / kept.sum().clamp(min=1)
    # Dice of four labels: with doors in it, a rise of their overlap would cost many wall pixels.
    found = log.exp()
    found = torch.cat([1 - found[:, 1:DOOR].sum(dim=1, keepdim=True), found[:, 1:DOOR]], dim=1)
    target = F.one_hot(true.where(true < DOOR, OTHER), DOOR).permute(0, 3, 1, 2) * kept[:, None]
    probability = found * kept[:, None]
    overlap = (probability * target).sum(dim=(0, 2, 3))
    total = (probability + target).sum(dim=(0, 2, 3))
    return loss + dice * (1 - ((2 * overlap + 1) / (total + 1)).mean())


def distillation_loss(
    logits: torch.Tensor, taught: torch.Tensor, labels: torch.Tensor
) -> torch.Tensor:
    """Return the mean Kullback-Leibler divergence of a network's output from its teachers'.

    Parameters
    ----------
    logits, taught : (n, labels, h / 2, w / 2) float32
        The network's logits and its teachers' averaged ones (Hinton et al. 2015, arXiv 1503.02531).
    labels : (n, h, w) int64
        Pixels with 255 (outside the photo, or in a view without teachers) do not count.
    """
    kept = labels[:, ::2, ::2] != IGNORE
    apart = F.kl_div(
        logits.log_softmax(dim=1), taught.log_softmax(dim=1), reduction="none", log_target=True
    )
    return (apart.sum(dim=1) * kept).sum() / kept.sum().clamp(min=1)


def geometry_loss(found: torch.Tensor, normals: torch.Tensor, depths: torch.Tensor) -> torch.Tensor:
    """Return the mean of 1 - cosine of normals plus the mean error of log depth up to view scale.

    Parameters
    ----------
    found : (n, 4, h / 4, w / 4) float32
        Of :class:`GeometryHead`.
    normals : (n, 3, h, w) float32
        In camera axes; zero where not known.
    depths : (n, h, w) float32
        Metres; zero where not known.
    """
    size = found.shape[2:]
    normals = F.interpolate(normals, size=size, mode="nearest")
    depths = F.interpolate(depths[:, None], size=size, mode="nearest")[:, 0]
    known = normals.square().sum(dim=1) > 0.5
    cosine = F.cosine_similarity(found[:, :3], normals, dim=1)
    angle = ((1 - cosine) * known).sum() / known.sum().clamp(min=1)
    seen = depths > 0
    count = seen.sum(dim=(1, 2), keepdim=True).clamp(min=1)
    gap = (found[:, 3] - depths.clamp(min=1e-3).log()) * seen
    gap = (gap - gap.sum(dim=(1, 2), keepdim=True) / count) * seen
    return angle + gap.abs().sum() / count.sum()
