"""Segmentation of a room photo into floor, wall, ceiling and other by the embedded network.

The paper takes the surfaces of a photo from a network trained on ADE20K (section 4). This one is
small enough to ship: inverted residuals, a block that sees the whole picture along rows, columns
and altogether, and a light decoder to half resolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from plan2scene.photos.camera.calibration import Camera
from plan2scene.photos.labels.elevation import elevation_map
from plan2scene.photos.labels.palette import LABELS
from plan2scene.weights import filled, load_model_file

#: Mean and standard deviation of sRGB values in [0, 1] that the network's input is scaled by.
_MEAN, _STD = 0.5, 0.25
#: Input height and width are multiples of this (the encoder's coarsest stride).
STRIDE = 32
#: Sizes that a photo is seen at, relative to the network's.
SCALES = (1.0, 1.4)


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
    """Add what the picture's rows, its columns and the picture as a whole hold on average.

    Whether a grey region is ceiling or wall depends on what is below and beside it, far beyond
    the reach of a small encoder. Shapes: (n, c, h, w) -> (n, c, h, w).
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
    """Photo -> logits of the four labels at half resolution.

    Parameters
    ----------
    widths : sequence of int
        Channels at strides 2, 4, 8, 16, 32.
    depths : sequence of int
        Blocks at strides 4, 8, 16, 32.
    decoder : int
        Channels of the decoder at strides 16 and 8; half of it at 4, a quarter at 2.
    long_side : int
        Pixels of the longer side that photos are scaled to before inference.
    elevation : bool
        Whether the network also sees how far above the horizon each pixel looks, where known.

    Shapes: (n, 3, h, w) float32 in [0, 1], h and w multiples of 32 -> (n, 4, h / 2, w / 2).
    """

    def __init__(
        self,
        *,
        widths: Sequence[int] = (16, 24, 56, 112, 192),
        depths: Sequence[int] = (2, 3, 5, 3),
        decoder: int = 64,
        long_side: int = 320,
        elevation: bool = False,
    ) -> None:
        super().__init__()
        self.long_side = long_side
        self.elevation = elevation
        self.architecture: dict[str, Any] = {
            "widths": list(widths),
            "depths": list(depths),
            "decoder": decoder,
            "long_side": long_side,
            "elevation": elevation,
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
        self.ups = nn.ModuleList(
            [
                _Up(widths[4], widths[3], decoder),
                _Up(decoder, widths[2], decoder),
                _Up(decoder, widths[1], decoder // 2),
                _Up(decoder // 2, widths[0], decoder // 4, filtered=False),
            ]
        )
        self.head = nn.Conv2d(decoder // 4, len(LABELS), 3, padding=1)

    def forward(self, x: torch.Tensor, elevation: torch.Tensor | None = None) -> torch.Tensor:
        """Return logits; see the class for shapes.

        `elevation` is (n, h, w) float32 of :func:`.elevation.elevation_map`; NaN where it is not
        known. A network that was made without it ignores it.
        """
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
        skips = [y]
        for stage in self.stages:
            y = stage(y)
            skips.append(y)
        y = self.context(y)
        for up, skip in zip(self.ups, reversed(skips[:-1]), strict=True):
            y = up(y, skip)
        logits: torch.Tensor = self.head(y)
        return logits


def network_size(size: tuple[int, int], long_side: int) -> tuple[int, int]:
    """Return the (height, width) that a photo of `size` is scaled to.

    Multiples of 32 with the longer side near `long_side`; the shape changes by a few percent.
    """
    scale = long_side / max(size)
    height, width = (max(STRIDE, round(side * scale / STRIDE) * STRIDE) for side in size)
    return height, width


def to_tensor(image: np.ndarray) -> torch.Tensor:
    """Return a (h, w, 3) uint8 sRGB image as (3, h, w) float32 in [0, 1]."""
    return torch.from_numpy(np.ascontiguousarray(image.transpose(2, 0, 1))).float() / 255.0


def upsampled_argmax(logits: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return the best class per pixel at `size` (h, w) of (c, h', w') float32 logits.

    One class at a time, so that a large photo never needs all of them at full size at once.
    """
    height, width = size
    best = np.full((height, width), -np.inf, np.float32)
    labels = np.zeros((height, width), np.uint8)
    for k, plane in enumerate(logits):
        value = cv2.resize(plane, (width, height), interpolation=cv2.INTER_LINEAR)
        better = value > best
        best[better] = value[better]
        labels[better] = k
    return labels


class Segmenter:
    """Labels photos by a :class:`SegmentationNet`.

    Each photo is seen at two sizes, at each of them also mirrored, and the answers are averaged:
    the smaller tells what is what, the larger where it ends.
    """

    def __init__(self, network: SegmentationNet) -> None:
        self.network = network.eval()

    def _logits(self, image: np.ndarray, camera: Camera | None) -> np.ndarray:
        """Return (4, h', w') float32 logits of a photo at half the larger network size."""
        photo_size = (image.shape[0], image.shape[1])
        sides = sorted(round(self.network.long_side * scale) for scale in SCALES)
        sizes = [network_size(photo_size, side) for side in sides]
        columns, rows = sizes[-1][1] // 2, sizes[-1][0] // 2
        total = np.zeros((len(LABELS), rows, columns), np.float32)
        for size in sizes:
            for k, plane in enumerate(self._logits_at(image, camera, size)):
                total[k] += cv2.resize(plane, (columns, rows), interpolation=cv2.INTER_LINEAR)
        return total / len(sizes)

    @torch.inference_mode()
    def _logits_at(
        self, image: np.ndarray, camera: Camera | None, size: tuple[int, int]
    ) -> np.ndarray:
        """Return (4, h / 2, w / 2) float32 logits of a photo seen at `size` (h, w)."""
        shrinks = image.shape[1] > size[1]
        way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        small = cv2.resize(image, size[::-1], interpolation=way)
        batch = to_tensor(small)[None]
        elevation = mirrored = None
        if camera is not None:
            photo_size = (camera.height, camera.width)
            rise = elevation_map(camera.matrix[:, 1], camera.focal_px, photo_size, size)
            elevation = torch.from_numpy(rise)[None]
            mirrored = elevation.flip(2)
        logits = self.network(batch, elevation)
        logits = (logits + self.network(batch.flip(3), mirrored).flip(3)) / 2
        return np.ascontiguousarray(logits[0].numpy())

    def labels(self, image: np.ndarray, camera: Camera | None = None) -> np.ndarray:
        """Return (h, w) uint8 labels (0 other, 1 floor, 2 wall, 3 ceiling) of a photo.

        Parameters
        ----------
        image : (h, w, 3) uint8 sRGB
            Any size; masks come back at that size.
        camera : Camera, optional
            The photo's, where one is known well: the network then knows where the horizon is.
        """
        return upsampled_argmax(self._logits(image, camera), (image.shape[0], image.shape[1]))


def load_segmenter(path: str | Path) -> Segmenter:
    """Return the segmenter of a weights file; InputError when it is none of this network."""
    state, architecture = load_model_file(path)
    name = "the segmentation network"
    network = filled(lambda: SegmentationNet(**architecture), state, name, path)
    return Segmenter(network)
