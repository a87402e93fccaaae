"""InceptionV3 up to its last pooling: the features of FID and KID (Szegedy et al. 2016).

The names of tensors are those of torchvision's ``inception_v3``, which both files in use have:

``tensorflow``   the network that FID was defined with (Heusel et al. 2017), 1008 classes, as
                 ``pt_inception-2015-12-05`` of pytorch-fid, torch-fidelity and torchmetrics. Its
                 average pools leave the border out, its last block takes a maximum instead, and
                 images are resized as TensorFlow 1 did.
``torchvision``  torchvision's weights of 1000 classes. Not the published FID's network.

Written here since torchvision's wheel (and torch-fidelity, which imports it) does not load beside
another build of torch than its own (``operator torchvision::nms does not exist``).
"""

from __future__ import annotations

from collections import OrderedDict

import torch
from torch import nn
from torch.nn import functional

#: Variant by the number of classes in a checkpoint.
VARIANTS = {1008: "tensorflow", 1000: "torchvision"}
_SIDE = 299
# A block is a line per branch, a branch its steps in order. A convolution is its name, its output
# channels and its kernel, which keeps the size unless its stride is written; "+" sets convolutions
# of one input side by side. "max/2" and the averages and maxima of a block are 3x3 pools.
_STEM = """
Conv2d_1a_3x3 32 3x3/2, Conv2d_2a_3x3 32 3x3/1, Conv2d_2b_3x3 64 3x3, max/2, \
Conv2d_3b_1x1 80 1x1, Conv2d_4a_3x3 192 3x3/1, max/2
"""
_A = """
branch1x1 64 1x1
branch5x5_1 48 1x1, branch5x5_2 64 5x5
branch3x3dbl_1 64 1x1, branch3x3dbl_2 96 3x3, branch3x3dbl_3 96 3x3
average, branch_pool {} 1x1
"""
_B = """
branch3x3 384 3x3/2
branch3x3dbl_1 64 1x1, branch3x3dbl_2 96 3x3, branch3x3dbl_3 96 3x3/2
max/2
"""
_C = """
branch1x1 192 1x1
branch7x7_1 {0} 1x1, branch7x7_2 {0} 1x7, branch7x7_3 192 7x1
branch7x7dbl_1 {0} 1x1, branch7x7dbl_2 {0} 7x1, branch7x7dbl_3 {0} 1x7, \
branch7x7dbl_4 {0} 7x1, branch7x7dbl_5 192 1x7
average, branch_pool 192 1x1
"""
_D = """
branch3x3_1 192 1x1, branch3x3_2 320 3x3/2
branch7x7x3_1 192 1x1, branch7x7x3_2 192 1x7, branch7x7x3_3 192 7x1, branch7x7x3_4 192 3x3/2
max/2
"""
_E = """
branch1x1 320 1x1
branch3x3_1 384 1x1, branch3x3_2a 384 1x3 + branch3x3_2b 384 3x1
branch3x3dbl_1 448 1x1, branch3x3dbl_2 384 3x3, branch3x3dbl_3a 384 1x3 + branch3x3dbl_3b 384 3x1
{}, branch_pool 192 1x1
"""
_BLOCKS = {
    **{"5b": _A.format(32), "5c": _A.format(64), "5d": _A.format(64), "6a": _B},
    **{"6b": _C.format(128), "6c": _C.format(160), "6d": _C.format(160), "6e": _C.format(192)},
    **{"7a": _D, "7b": _E.format("average"), "7c": _E},
}


def _convolution(channels: int, out: int, kernel: str) -> nn.Sequential:
    """Return a convolution without bias, batch normalisation and ReLU; kernel as ``3x3/2``."""
    shape, _, stride = kernel.partition("/")
    size = tuple(int(side) for side in shape.split("x"))
    padding = 0 if stride else tuple(side // 2 for side in size)
    conv = nn.Conv2d(channels, out, size, int(stride or 1), padding, bias=False)  # type: ignore[arg-type]
    parts = OrderedDict(conv=conv, bn=nn.BatchNorm2d(out, eps=0.001), relu=nn.ReLU())
    return nn.Sequential(parts)


class _Block(nn.Module):
    """Branches of one input, their maps side by side."""

    def __init__(self, channels: int, text: str, divisor: int, *, border_counts: bool) -> None:
        super().__init__()
        self._border_counts = border_counts
        self._branches: list[list[list[str]]] = []  # branches, steps, convolutions side by side
        self.channels = 0
        for line in text.strip().splitlines():
            width, steps = channels, []
            for step in line.split(", "):
                convolutions = [part.split() for part in step.split(" + ")]
                if len(convolutions[0]) == 3:
                    for name, out, kernel in convolutions:
                        self.add_module(name, _convolution(width, int(out) // divisor, kernel))
                    width = sum(int(out) // divisor for _, out, _ in convolutions)
                steps.append([name for name, *_ in convolutions])
            self._branches.append(steps)
            self.channels += width

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        results = []
        for branch in self._branches:
            maps = x
            for step in branch:
                maps = torch.cat([self._take(name, maps) for name in step], 1)
            results.append(maps)
        return torch.cat(results, 1)

    def _take(self, name: str, maps: torch.Tensor) -> torch.Tensor:
        if name == "average":
            counts = self._border_counts
            return functional.avg_pool2d(maps, 3, 1, 1, count_include_pad=counts)
        if name == "maximum":
            return functional.max_pool2d(maps, 3, 1, 1)
        return functional.max_pool2d(maps, 3, 2) if name == "max/2" else getattr(self, name)(maps)


class InceptionV3(_Block):
    """The network without its classes; `variant` is a value of :data:`VARIANTS`.

    All channels are divided by `divisor`; 1 is InceptionV3.
    """

    def __init__(self, variant: str = "tensorflow", divisor: int = 1) -> None:
        if variant not in VARIANTS.values():
            raise ValueError(f"expected one of {tuple(VARIANTS.values())}, found {variant!r}")
        borders = variant == "torchvision"
        super().__init__(3, _STEM, divisor, border_counts=borders)
        self.variant = variant
        last = "maximum" if variant == "tensorflow" else "average"
        for name, text in _BLOCKS.items():
            block = _Block(self.channels, text.format(last), divisor, border_counts=borders)
            self.add_module(f"Mixed_{name}", block)
            self.channels = block.channels

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return features (n, 2048 / divisor) of images (n, 3, h, w), RGB 0..255."""
        x = super().forward(self._input(rgb))
        for name in _BLOCKS:
            x = self.get_submodule(f"Mixed_{name}")(x)
        return x.mean(dim=(2, 3))

    def _input(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return images at 299 pixels, about [-1, 1], of images (n, 3, h, w), RGB 0..255."""
        if self.variant == "tensorflow":
            return (_resize_tensorflow(_resize_tensorflow(rgb, 2), 3) - 128.0) / 128.0
        size = (_SIDE, _SIDE)
        resized = functional.interpolate(rgb, size, mode="bilinear", antialias=True)
        return resized / 127.5 - 1.0


def _resize_tensorflow(images: torch.Tensor, axis: int) -> torch.Tensor:
    """Return (n, 3, h, w) with `axis` at 299, bilinear with corners at pixels' corners (TF 1)."""
    size = images.shape[axis]
    place = torch.arange(_SIDE, dtype=images.dtype, device=images.device) * (size / _SIDE)
    low = place.floor()
    share = (place - low).view(-1, *([1] * (3 - axis)))
    first = low.long()
    second = (first + 1).clamp(max=size - 1)
    below, above = images.index_select(axis, first), images.index_select(axis, second)
    return below + (above - below) * share
