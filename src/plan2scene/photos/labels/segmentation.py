"""Segmentation of a room photo into floor, wall, ceiling and other by the embedded network.

The paper takes the surfaces of a photo from a network trained on ADE20K (section 4). This one
(:mod:`.network`) is small enough to ship. Doors and windows, where it tells them, count as other
unless asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import torch

from plan2scene.camera import Camera
from plan2scene.photos.labels.network import (
    Ensemble,
    ImagenetSegmentationNet,
    SegmentationNet,
    folded,
)
from plan2scene.photos.labels.palette import DOOR, LABELS, OTHER, WINDOW
from plan2scene.weights import filled, load_model_file


def elevation_map(
    up: Sequence[float] | np.ndarray,
    focal_px: float,
    photo_size: tuple[int, int],
    size: tuple[int, int],
) -> np.ndarray:
    """Return the sine of each pixel's elevation above the horizon, (h, w) float32 in [-1, 1].

    `up` (3,) is the world's up direction in camera axes (x right, y down, z forward), a unit
    vector: the second column of the rotation of ``docs/conventions.md``. The focal length is in
    pixels of the photo, whose principal point is the middle; the map of `size` (height, width)
    covers the same view.
    """
    axes = [
        (np.arange(n) + 0.5) / n * full - full / 2 for n, full in zip(size, photo_size, strict=True)
    ]
    y, x = np.meshgrid(*(axis / focal_px for axis in axes), indexing="ij")
    rise = x * up[0] + y * up[1] + up[2]
    return np.asarray(rise / np.sqrt(x * x + y * y + 1), dtype=np.float32)


#: What labels photos: one network, or several whose logits are averaged.
Network = SegmentationNet | Ensemble
STRIDE = 32  #: Input height and width are multiples of this (the encoder's coarsest stride)
SCALES = (0.8, 1.5, 2.8)  #: Sizes that a photo is seen at, relative to the network's
DRAFT_SCALE = 1.5  #: The one that a draft is made at
#: Median grey value in [0, 1] that dimmer photos are brought to before they are labelled.
MEDIAN = 0.45


def brightened(image: np.ndarray) -> np.ndarray:
    """Return a photo (h, w, 3) uint8 sRGB that is no dimmer than `MEDIAN`, by a gamma.

    Renderings are lit like listings; a room by its lamp alone is not. A black photo stays.
    """
    median = float(np.median(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))) / 255
    if not 0.02 < median < MEDIAN:
        return image
    curve = 255 * np.linspace(0, 1, 256) ** (np.log(MEDIAN) / np.log(median))
    return np.asarray(cv2.LUT(image, np.round(curve).astype(np.uint8)))


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
    """Labels photos by a :class:`SegmentationNet`, or by an :class:`Ensemble` of them.

    Each photo is seen at several sizes, and the answers are averaged: the smallest tells what is
    what, the largest where it ends. A network sees it mirrored at every other size, the next
    network at those between: as good as both at each, in half the time
    (docs/measurements/segmentation.md).
    """

    def __init__(self, network: Network, *further: SegmentationNet) -> None:
        """Take a network or an ensemble, whose constants count, and networks beside it."""
        self.network = network.eval()
        quick = folded(self.network)
        members = list(quick.members) if isinstance(quick, Ensemble) else [quick]
        members += [folded(member) for member in further]
        #: The networks, ready for inference.
        self.members = cast("list[SegmentationNet]", members)

    def draft(self, image: np.ndarray) -> np.ndarray:
        """Return (h, w) uint8 labels 0 to 3 as the first network gives them at one size.

        Enough to find a photo's camera by; arguments as of :meth:`labels`.
        """
        logits = self._seen(self.members[:1], image, None, (DRAFT_SCALE,))
        return labels_of(logits, (image.shape[0], image.shape[1]))

    def logits(self, image: np.ndarray, camera: Camera | None) -> np.ndarray:
        """Return (labels, h', w') float32 logits of a photo at half the largest size it is seen at.

        With the network's adjustment of surfaces, divided by its temperature. Arguments as of
        :meth:`labels`.
        """
        return self._seen(self.members, image, camera, SCALES)

    def opened(self, logits: np.ndarray) -> np.ndarray:
        """Return :meth:`logits` with the adjustment of doors and windows, for who asks for them.

        Photos show more of them than the network says; what is a wall to all others stays one.
        """
        constants = self.network.architecture
        more = np.array(constants["logit_adjustment"], np.float32) / constants["temperature"]
        more[: len(LABELS)] = 0
        return np.asarray(logits + more[:, None, None])

    def _seen(
        self,
        members: Sequence[SegmentationNet],
        image: np.ndarray,
        camera: Camera | None,
        scales: Sequence[float],
    ) -> np.ndarray:
        """Return the logits of a photo by some of the networks at some sizes, small to large."""
        photo_size, image = (image.shape[0], image.shape[1]), brightened(image)
        sides = [round(self.network.long_side * scale) for scale in scales]
        sizes = [network_size(photo_size, side) for side in sides]
        columns, rows = sizes[-1][1] // 2, sizes[-1][0] // 2
        total = np.zeros((int(self.network.architecture["labels"]), rows, columns), np.float32)
        for k, size in enumerate(sizes):
            answers = _logits_at(members, image, camera, size, mirror_first=k % 2 == 1)
            for plane, sum_ in zip(answers, total, strict=True):
                sum_ += cv2.resize(plane, (columns, rows), interpolation=cv2.INTER_LINEAR)
        constants = self.network.architecture
        adjustment = np.array(constants["logit_adjustment"], np.float32)
        adjustment[len(LABELS) :] = 0
        mean = total / len(sizes) + adjustment[:, None, None]
        return np.asarray(mean / constants["temperature"], dtype=np.float32)

    def labels(
        self, image: np.ndarray, camera: Camera | None = None, *, openings: bool = False
    ) -> np.ndarray:
        """Return (h, w) uint8 labels (0 other, 1 floor, 2 wall, 3 ceiling) of a photo of any size.

        With its `camera`, where one is known well, the network knows where the horizon is. With
        `openings` doors are 4 and windows 5, of what is other, where the network tells them.
        """
        size, logits = (image.shape[0], image.shape[1]), self.logits(image, camera)
        return labels_of(self.opened(logits) if openings else logits, size, openings=openings)


@torch.inference_mode()
def _logits_at(
    members: Sequence[SegmentationNet],
    image: np.ndarray,
    camera: Camera | None,
    size: tuple[int, int],
    *,
    mirror_first: bool,
) -> np.ndarray:
    """Return networks' mean logits (labels, h / 2, w / 2) float32 of a photo seen at `size` (h, w).

    Every other network sees it mirrored, the first one if `mirror_first`.
    """
    shrinks = image.shape[1] > size[1]
    way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    photo = to_tensor(cv2.resize(image, size[::-1], interpolation=way))[None]
    elevation = None
    if camera is not None:
        photo_size = (camera.height, camera.width)
        rise = elevation_map(camera.matrix[:, 1], camera.focal_px, photo_size, size)
        elevation = torch.from_numpy(rise)[None]
    answers = []
    for k, member in enumerate(members):
        if (k % 2 == 1) != mirror_first:
            rises = None if elevation is None else elevation.flip(2)
            answers.append(member(photo.flip(3), rises).flip(3))
        else:
            answers.append(member(photo, elevation))
    return np.ascontiguousarray(torch.cat(answers).mean(dim=0).numpy())


def labels_of(logits: np.ndarray, size: tuple[int, int], *, openings: bool = False) -> np.ndarray:
    """Return labels (h, w) uint8 at `size` of :meth:`Segmenter.logits`."""
    labels = upsampled_argmax(surface_logits(logits), size)
    if openings and len(logits) > WINDOW:
        kinds = upsampled_argmax(logits[[OTHER, DOOR, WINDOW]], size)
        other = labels == OTHER
        labels[other] = np.array([OTHER, DOOR, WINDOW])[kinds[other]]
    return labels


def probabilities_of(logits: np.ndarray) -> np.ndarray:
    """Return (labels, h', w') float32 in [0, 1]: how likely each label is, of logits."""
    powers = np.exp(logits - logits.max(axis=0))
    return np.asarray(powers / powers.sum(axis=0), dtype=np.float32)


def surface_logits(logits: np.ndarray) -> np.ndarray:
    """Return logits (4, h, w) of other, floor, wall, ceiling: doors and windows are other.

    A pixel may be a door, a window or a thing: what counts is how likely it is any of them.
    """
    if len(logits) == len(LABELS):
        return logits
    other = np.logaddexp.reduce(logits[[OTHER, DOOR, WINDOW]], axis=0, keepdims=True)
    return np.concatenate([other, logits[1 : len(LABELS)]]).astype(np.float32)


def load_segmenter(path: str | Path) -> Segmenter:
    """Return the segmenter of a weights file; InputError when it is none of this network."""
    state, architecture = load_model_file(path)
    kind: type[Network] = Ensemble if "members" in architecture else SegmentationNet
    if architecture.pop("imagenet", False):
        kind = ImagenetSegmentationNet
    return Segmenter(filled(lambda: kind(**architecture), state, "the segmentation network", path))
