"""InceptionV3 up to its last pooling: the features of FID and KID (Szegedy et al. 2016).

The names of tensors are those of torchvision's ``inception_v3``, which both files in use have:

``tensorflow``   the network that FID was defined with (Heusel et al. 2017), 1008 classes, as
                 ``pt_inception-2015-12-05`` of pytorch-fid, torch-fidelity and torchmetrics. Its
                 average pools leave the border out, its last block takes a maximum instead, and
                 images are resized as TensorFlow 1 did.
``torchvision``  torchvision's weights of 1000 classes. Not the published FID's network.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from plan2scene.errors import InputError
from plan2scene.images import metric_image
from plan2scene.weights import load_model_file

#: Name in column names, and of the network in weight files.
NETWORK = "inception"
#: Variant by the number of classes in a checkpoint.
VARIANTS = {1008: "tensorflow", 1000: "torchvision"}
#: Length of a feature vector.
FEATURE_DIM = 2048
_SIDE = 299
_BATCH = 16
#: A convolution: name, output channels, kernel and stride (1 keeps the size, 2 pads nothing); a
#: pooling by its name; several convolutions of one input side by side.
_Conv = tuple[str, int, int | tuple[int, int], int]
_Step = str | _Conv | tuple[_Conv, ...]


def _block_a(pooled: int) -> tuple[tuple[_Step, ...], ...]:
    return (
        (("branch1x1", 64, 1, 1),),
        (("branch5x5_1", 48, 1, 1), ("branch5x5_2", 64, 5, 1)),
        (
            ("branch3x3dbl_1", 64, 1, 1),
            ("branch3x3dbl_2", 96, 3, 1),
            ("branch3x3dbl_3", 96, 3, 1),
        ),
        ("average", ("branch_pool", pooled, 1, 1)),
    )


def _block_c(width: int) -> tuple[tuple[_Step, ...], ...]:
    return (
        (("branch1x1", 192, 1, 1),),
        (
            ("branch7x7_1", width, 1, 1),
            ("branch7x7_2", width, (1, 7), 1),
            ("branch7x7_3", 192, (7, 1), 1),
        ),
        (
            ("branch7x7dbl_1", width, 1, 1),
            ("branch7x7dbl_2", width, (7, 1), 1),
            ("branch7x7dbl_3", width, (1, 7), 1),
            ("branch7x7dbl_4", width, (7, 1), 1),
            ("branch7x7dbl_5", 192, (1, 7), 1),
        ),
        ("average", ("branch_pool", 192, 1, 1)),
    )


def _block_e(pool: str) -> tuple[tuple[_Step, ...], ...]:
    return (
        (("branch1x1", 320, 1, 1),),
        (
            ("branch3x3_1", 384, 1, 1),
            (("branch3x3_2a", 384, (1, 3), 1), ("branch3x3_2b", 384, (3, 1), 1)),
        ),
        (
            ("branch3x3dbl_1", 448, 1, 1),
            ("branch3x3dbl_2", 384, 3, 1),
            (("branch3x3dbl_3a", 384, (1, 3), 1), ("branch3x3dbl_3b", 384, (3, 1), 1)),
        ),
        (pool, ("branch_pool", 192, 1, 1)),
    )


_BLOCK_B: tuple[tuple[_Step, ...], ...] = (
    (("branch3x3", 384, 3, 2),),
    (("branch3x3dbl_1", 64, 1, 1), ("branch3x3dbl_2", 96, 3, 1), ("branch3x3dbl_3", 96, 3, 2)),
    ("halve",),
)
_BLOCK_D: tuple[tuple[_Step, ...], ...] = (
    (("branch3x3_1", 192, 1, 1), ("branch3x3_2", 320, 3, 2)),
    (
        ("branch7x7x3_1", 192, 1, 1),
        ("branch7x7x3_2", 192, (1, 7), 1),
        ("branch7x7x3_3", 192, (7, 1), 1),
        ("branch7x7x3_4", 192, 3, 2),
    ),
    ("halve",),
)


#: Before the blocks: name, output channels, kernel, stride, whether borders are padded.
_STEM: tuple[tuple[str, int, int, int, bool], ...] = (
    ("1a_3x3", 32, 3, 2, False),
    ("2a_3x3", 32, 3, 1, False),
    ("2b_3x3", 64, 3, 1, True),
    ("halve", 64, 3, 2, False),
    ("3b_1x1", 80, 1, 1, False),
    ("4a_3x3", 192, 3, 1, False),
    ("halve", 192, 3, 2, False),
)


class _Convolution(nn.Module):
    """Convolution without bias, batch normalisation, ReLU."""

    def __init__(
        self, channels: int, out: int, kernel: int | tuple[int, int], stride: int, pad: bool
    ) -> None:
        super().__init__()
        size = (kernel, kernel) if isinstance(kernel, int) else kernel
        padding = (size[0] // 2, size[1] // 2) if pad else (0, 0)
        self.conv = nn.Conv2d(channels, out, size, stride, padding, bias=False)
        self.bn = nn.BatchNorm2d(out, eps=0.001)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return functional.relu(self.bn(self.conv(x)))


class _Block(nn.Module):
    """Branches of one input, their maps side by side."""

    def __init__(
        self,
        channels: int,
        branches: tuple[tuple[_Step, ...], ...],
        divisor: int,
        *,
        border_counts: bool,
    ) -> None:
        super().__init__()
        self._branches = branches
        self._border_counts = border_counts
        self.channels = 0
        for branch in branches:
            width = channels
            for step in branch:
                if isinstance(step, str):
                    continue
                convolutions = _side_by_side(step)
                for name, out, kernel, stride in convolutions:
                    part = _Convolution(width, out // divisor, kernel, stride, stride == 1)
                    self.add_module(name, part)
                width = sum(out // divisor for _, out, _, _ in convolutions)
            self.channels += width

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        results = []
        for branch in self._branches:
            maps = x
            for step in branch:
                maps = self._take(step, maps)
            results.append(maps)
        return torch.cat(results, 1)

    def _take(self, step: _Step, maps: torch.Tensor) -> torch.Tensor:
        if step == "average":
            counts = self._border_counts
            return functional.avg_pool2d(maps, 3, 1, 1, count_include_pad=counts)
        if step == "maximum":
            return functional.max_pool2d(maps, 3, 1, 1)
        if isinstance(step, str):
            return functional.max_pool2d(maps, 3, 2)
        return torch.cat([self.get_submodule(name)(maps) for name, *_ in _side_by_side(step)], 1)


def _side_by_side(step: _Conv | tuple[_Conv, ...]) -> tuple[_Conv, ...]:
    return (step,) if isinstance(step[0], str) else step


class InceptionV3(nn.Module):
    """The network without its classes.

    Parameters
    ----------
    variant : str
        A value of :data:`VARIANTS`.
    divisor : int
        Of all channels; 1 is InceptionV3.
    """

    def __init__(self, variant: str = "tensorflow", divisor: int = 1) -> None:
        super().__init__()
        if variant not in VARIANTS.values():
            raise ValueError(f"expected one of {tuple(VARIANTS.values())}, found {variant!r}")
        self.variant = variant
        channels = 3
        for name, out, kernel, stride, pad in _STEM:
            if name != "halve":
                part = _Convolution(channels, out // divisor, kernel, stride, pad)
                self.add_module(f"Conv2d_{name}", part)
                channels = out // divisor
        last = "maximum" if variant == "tensorflow" else "average"
        blocks = {"5b": _block_a(32), "5c": _block_a(64), "5d": _block_a(64), "6a": _BLOCK_B}
        blocks |= {f"6{c}": _block_c(w) for c, w in zip("bcde", (128, 160, 160, 192), strict=True)}
        blocks |= {"7a": _BLOCK_D, "7b": _block_e("average"), "7c": _block_e(last)}
        self._blocks = [f"Mixed_{name}" for name in blocks]
        for name, branches in zip(self._blocks, blocks.values(), strict=True):
            block = _Block(channels, branches, divisor, border_counts=variant == "torchvision")
            self.add_module(name, block)
            channels = block.channels

    def forward(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return features (n, 2048 / divisor) of images (n, 3, h, w), RGB integers 0..255."""
        x = self._input(rgb)
        for name, *_ in _STEM:
            if name == "halve":
                x = functional.max_pool2d(x, 3, 2)
            else:
                x = self.get_submodule(f"Conv2d_{name}")(x)
        for name in self._blocks:
            x = self.get_submodule(name)(x)
        return x.mean(dim=(2, 3))

    def _input(self, rgb: torch.Tensor) -> torch.Tensor:
        """Return images at 299 pixels, about [-1, 1]."""
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


def load_inception(path: str | Path) -> InceptionV3:
    """Return the network of a converted checkpoint, in evaluation mode."""
    state, architecture = load_model_file(path)
    if architecture.get("network") != NETWORK:
        raise InputError("weights of an InceptionV3", str(sorted(architecture)), file=path)
    with torch.device("meta"):
        model = InceptionV3(architecture["variant"], architecture["divisor"])
    try:
        model.load_state_dict(state, assign=True)
    except RuntimeError as error:
        raise InputError("weights that fit an InceptionV3", str(error), file=path) from None
    return model.eval()


def inception_features(model: InceptionV3, images: Sequence[np.ndarray]) -> np.ndarray:
    """Return (n, d) float32 features of (h, w, 3) uint8 sRGB images, taken at 128 pixels first."""
    parts = []
    with torch.inference_mode():
        for start in range(0, len(images), _BATCH):
            batch = np.stack([metric_image(image) for image in images[start : start + _BATCH]])
            rgb = torch.from_numpy(batch).permute(0, 3, 1, 2).float()
            parts.append(model(rgb).numpy())
    return np.concatenate(parts) if parts else np.zeros((0, FEATURE_DIM), np.float32)
