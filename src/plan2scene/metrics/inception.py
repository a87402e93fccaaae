"""InceptionV3 up to its last pooling: the features of FID and KID (Szegedy et al. 2016).

The names of tensors are those of torchvision's ``inception_v3``, which both variants' files have:

``tensorflow``   the network that FID was defined with (Heusel et al. 2017), 1008 classes, as
                 ``pt_inception-2015-12-05`` of pytorch-fid, torch-fidelity and torchmetrics. Its
                 average pools do not count the padding, its last block pools by the maximum, and
                 images are resized as in TensorFlow 1.
``torchvision``  torchvision's weights of 1000 classes. Not the published FID's network.

torchvision's own class is not used: its wheel loads only with the build of torch that it was made
for (else ``operator torchvision::nms does not exist``), and it lacks the ``tensorflow`` variant.
"""

from __future__ import annotations

import torch
from torch import nn
from torch.nn.functional import avg_pool2d, interpolate, max_pool2d, relu

#: Variant by the number of classes in a checkpoint.
VARIANTS = {1008: "tensorflow", 1000: "torchvision"}
_SIDE = 299  # pixels of the input

_Size = int | tuple[int, int]


class _Convolution(nn.Module):
    """A convolution without bias, batch normalisation and ReLU."""

    def __init__(
        self, channels: int, out: int, size: _Size, *, stride: int = 1, padding: _Size = 0
    ) -> None:
        super().__init__()
        self.conv = nn.Conv2d(channels, out, size, stride, padding, bias=False)
        self.bn = nn.BatchNorm2d(out, eps=0.001)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return relu(self.bn(self.conv(x)))


def _average(x: torch.Tensor, border: bool) -> torch.Tensor:
    """Return the 3x3 average of maps at each pixel; the zero padding counts if `border`."""
    return avg_pool2d(x, 3, stride=1, padding=1, count_include_pad=border)


class _BlockA(nn.Module):
    """Branches of 1x1, 5x5 and twice 3x3 kernels: 224 / divisor maps and `pooled`."""

    def __init__(self, channels: int, pooled: int, d: int, border: bool) -> None:
        super().__init__()
        self.border = border
        self.branch1x1 = _Convolution(channels, 64 // d, 1)
        self.branch5x5_1 = _Convolution(channels, 48 // d, 1)
        self.branch5x5_2 = _Convolution(48 // d, 64 // d, 5, padding=2)
        self.branch3x3dbl_1 = _Convolution(channels, 64 // d, 1)
        self.branch3x3dbl_2 = _Convolution(64 // d, 96 // d, 3, padding=1)
        self.branch3x3dbl_3 = _Convolution(96 // d, 96 // d, 3, padding=1)
        self.branch_pool = _Convolution(channels, pooled // d, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        branches = [
            self.branch1x1(x),
            self.branch5x5_2(self.branch5x5_1(x)),
            self.branch3x3dbl_3(self.branch3x3dbl_2(self.branch3x3dbl_1(x))),
            self.branch_pool(_average(x, self.border)),
        ]
        return torch.cat(branches, 1)


class _BlockB(nn.Module):
    """Halves the maps' side: 480 / divisor new maps beside the pooled ones."""

    def __init__(self, channels: int, d: int) -> None:
        super().__init__()
        self.branch3x3 = _Convolution(channels, 384 // d, 3, stride=2)
        self.branch3x3dbl_1 = _Convolution(channels, 64 // d, 1)
        self.branch3x3dbl_2 = _Convolution(64 // d, 96 // d, 3, padding=1)
        self.branch3x3dbl_3 = _Convolution(96 // d, 96 // d, 3, stride=2)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        double = self.branch3x3dbl_3(self.branch3x3dbl_2(self.branch3x3dbl_1(x)))
        return torch.cat([self.branch3x3(x), double, max_pool2d(x, 3, stride=2)], 1)


class _BlockC(nn.Module):
    """Branches of 7x7 kernels, each as 1x7 and 7x1: 768 / divisor maps."""

    def __init__(self, channels: int, inner: int, d: int, border: bool) -> None:
        super().__init__()
        self.border = border
        n, out, flat, tall = inner // d, 192 // d, (1, 7), (7, 1)
        self.branch1x1 = _Convolution(channels, out, 1)
        self.branch7x7_1 = _Convolution(channels, n, 1)
        self.branch7x7_2 = _Convolution(n, n, flat, padding=(0, 3))
        self.branch7x7_3 = _Convolution(n, out, tall, padding=(3, 0))
        self.branch7x7dbl_1 = _Convolution(channels, n, 1)
        self.branch7x7dbl_2 = _Convolution(n, n, tall, padding=(3, 0))
        self.branch7x7dbl_3 = _Convolution(n, n, flat, padding=(0, 3))
        self.branch7x7dbl_4 = _Convolution(n, n, tall, padding=(3, 0))
        self.branch7x7dbl_5 = _Convolution(n, out, flat, padding=(0, 3))
        self.branch_pool = _Convolution(channels, out, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        double = self.branch7x7dbl_3(self.branch7x7dbl_2(self.branch7x7dbl_1(x)))
        branches = [
            self.branch1x1(x),
            self.branch7x7_3(self.branch7x7_2(self.branch7x7_1(x))),
            self.branch7x7dbl_5(self.branch7x7dbl_4(double)),
            self.branch_pool(_average(x, self.border)),
        ]
        return torch.cat(branches, 1)


class _BlockD(nn.Module):
    """Halves the maps' side: 512 / divisor new maps beside the pooled ones."""

    def __init__(self, channels: int, d: int) -> None:
        super().__init__()
        n = 192 // d
        self.branch3x3_1 = _Convolution(channels, n, 1)
        self.branch3x3_2 = _Convolution(n, 320 // d, 3, stride=2)
        self.branch7x7x3_1 = _Convolution(channels, n, 1)
        self.branch7x7x3_2 = _Convolution(n, n, (1, 7), padding=(0, 3))
        self.branch7x7x3_3 = _Convolution(n, n, (7, 1), padding=(3, 0))
        self.branch7x7x3_4 = _Convolution(n, n, 3, stride=2)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        seven = self.branch7x7x3_3(self.branch7x7x3_2(self.branch7x7x3_1(x)))
        branches = [
            self.branch3x3_2(self.branch3x3_1(x)),
            self.branch7x7x3_4(seven),
            max_pool2d(x, 3, stride=2),
        ]
        return torch.cat(branches, 1)


class _BlockE(nn.Module):
    """Branches that end in 1x3 and 3x1 kernels side by side: 2048 / divisor maps.

    If `largest`, the pooling branch takes the maximum of 3x3 pixels, not the average.
    """

    def __init__(self, channels: int, d: int, border: bool, *, largest: bool = False) -> None:
        super().__init__()
        self.border, self.largest = border, largest
        n = 384 // d
        self.branch1x1 = _Convolution(channels, 320 // d, 1)
        self.branch3x3_1 = _Convolution(channels, n, 1)
        self.branch3x3_2a = _Convolution(n, n, (1, 3), padding=(0, 1))
        self.branch3x3_2b = _Convolution(n, n, (3, 1), padding=(1, 0))
        self.branch3x3dbl_1 = _Convolution(channels, 448 // d, 1)
        self.branch3x3dbl_2 = _Convolution(448 // d, n, 3, padding=1)
        self.branch3x3dbl_3a = _Convolution(n, n, (1, 3), padding=(0, 1))
        self.branch3x3dbl_3b = _Convolution(n, n, (3, 1), padding=(1, 0))
        self.branch_pool = _Convolution(channels, 192 // d, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        one = self.branch3x3_1(x)
        double = self.branch3x3dbl_2(self.branch3x3dbl_1(x))
        around = max_pool2d(x, 3, 1, 1) if self.largest else _average(x, self.border)
        branches = [
            self.branch1x1(x),
            self.branch3x3_2a(one),
            self.branch3x3_2b(one),
            self.branch3x3dbl_3a(double),
            self.branch3x3dbl_3b(double),
            self.branch_pool(around),
        ]
        return torch.cat(branches, 1)


class InceptionV3(nn.Module):
    """The network without its class layer; `variant` is a value of :data:`VARIANTS`.

    All channels are divided by `divisor`; 1 is InceptionV3.
    """

    def __init__(self, variant: str = "tensorflow", divisor: int = 1) -> None:
        super().__init__()
        if variant not in VARIANTS.values():
            raise ValueError(f"expected one of {tuple(VARIANTS.values())}, found {variant!r}")
        self.variant = variant
        d, border = divisor, variant == "torchvision"
        self.Conv2d_1a_3x3 = _Convolution(3, 32 // d, 3, stride=2)
        self.Conv2d_2a_3x3 = _Convolution(32 // d, 32 // d, 3)
        self.Conv2d_2b_3x3 = _Convolution(32 // d, 64 // d, 3, padding=1)
        self.Conv2d_3b_1x1 = _Convolution(64 // d, 80 // d, 1)
        self.Conv2d_4a_3x3 = _Convolution(80 // d, 192 // d, 3)
        self.Mixed_5b = _BlockA(192 // d, 32, d, border)
        self.Mixed_5c = _BlockA(256 // d, 64, d, border)
        self.Mixed_5d = _BlockA(288 // d, 64, d, border)
        self.Mixed_6a = _BlockB(288 // d, d)
        self.Mixed_6b = _BlockC(768 // d, 128, d, border)
        self.Mixed_6c = _BlockC(768 // d, 160, d, border)
        self.Mixed_6d = _BlockC(768 // d, 160, d, border)
        self.Mixed_6e = _BlockC(768 // d, 192, d, border)
        self.Mixed_7a = _BlockD(768 // d, d)
        self.Mixed_7b = _BlockE(1280 // d, d, border)
        self.Mixed_7c = _BlockE(2048 // d, d, border, largest=variant == "tensorflow")

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return features (n, 2048 / divisor) of images (n, 3, h, w), RGB 0..255."""
        x = self.Conv2d_2a_3x3(self.Conv2d_1a_3x3(self._input(rgb)))
        x = max_pool2d(self.Conv2d_2b_3x3(x), 3, stride=2)
        x = max_pool2d(self.Conv2d_4a_3x3(self.Conv2d_3b_1x1(x)), 3, stride=2)
        x = self.Mixed_5d(self.Mixed_5c(self.Mixed_5b(x)))
        x = self.Mixed_6b(self.Mixed_6a(x))
        x = self.Mixed_6e(self.Mixed_6d(self.Mixed_6c(x)))
        x = self.Mixed_7c(self.Mixed_7b(self.Mixed_7a(x)))
        return x.mean(dim=(2, 3))

    def _input(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return images (n, 3, h, w), RGB 0..255, at 299 pixels and scaled to about [-1, 1]."""
        if self.variant == "tensorflow":
            return (_resize_tensorflow(_resize_tensorflow(rgb, 2), 3) - 128.0) / 128.0
        resized = interpolate(rgb, (_SIDE, _SIDE), mode="bilinear", antialias=True)
        return resized / 127.5 - 1.0


def _resize_tensorflow(images: torch.Tensor, axis: int) -> torch.Tensor:
    """Resize `axis` of (n, 3, h, w) to 299: bilinear, sample i at i * size / 299 (TensorFlow 1)."""
    size = images.shape[axis]
    place = torch.arange(_SIDE, dtype=images.dtype, device=images.device) * (size / _SIDE)
    low = place.floor()
    share = (place - low).view(-1, *([1] * (3 - axis)))
    first = low.long()
    second = (first + 1).clamp(max=size - 1)
    below, above = images.index_select(axis, first), images.index_select(axis, second)
    return below + (above - below) * share
