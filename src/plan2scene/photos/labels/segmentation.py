"""Segmentation of a room photo into floor, wall, ceiling and other by the embedded network.

The paper takes the surfaces of a photo from a network trained on ADE20K (section 4). The network
here (:mod:`.network`) is small enough to ship. If it labels doors and windows, they count as other
unless the caller asks for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import cv2
import numpy as np
import torch
from scipy.special import softmax

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
    pixels of the photo, whose principal point is its middle. The map has `size` (height, width) and
    covers the same view.
    """
    axes = [
        (np.arange(n) + 0.5) / n * full - full / 2 for n, full in zip(size, photo_size, strict=True)
    ]
    y, x = np.meshgrid(*(axis / focal_px for axis in axes), indexing="ij")
    rise = x * up[0] + y * up[1] + up[2]
    return np.asarray(rise / np.sqrt(x * x + y * y + 1), dtype=np.float32)


#: One network, or several whose logits are averaged.
Network = SegmentationNet | Ensemble
STRIDE = 32  #: Input height and width are multiples of this (the encoder's coarsest stride)
SCALES = (0.8, 1.5, 2.8)  #: Input sizes of a photo, relative to the network's `long_side`
DRAFT_SCALE = 1.5  #: Input size for a draft
AMODAL_SCALES = (0.8, 1.5)  #: Input sizes for amodal labels, whose borders need not be exact
#: Median grey value in [0, 1] to which dimmer photos are brightened before they are labelled.
MEDIAN = 0.45


def brightened(image: np.ndarray) -> np.ndarray:
    """Return a photo (h, w, 3) uint8 sRGB, brightened by a gamma to the median grey `MEDIAN`.

    The network was trained on renderings lit like listing photos; a room lit by a lamp alone is
    dimmer. Photos that are brighter, or (nearly) black, stay as they are.
    """
    median = float(np.median(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))) / 255
    if not 0.02 < median < MEDIAN:
        return image
    curve = 255 * np.linspace(0, 1, 256) ** (np.log(MEDIAN) / np.log(median))
    return np.asarray(cv2.LUT(image, np.round(curve).astype(np.uint8)))


def network_size(size: tuple[int, int], long_side: int) -> tuple[int, int]:
    """Return the (height, width) that a photo of `size` is scaled to.

    Both are multiples of 32, the longer near `long_side`; the aspect changes by a few percent.
    """
    scale = long_side / max(size)
    height, width = (max(STRIDE, round(side * scale / STRIDE) * STRIDE) for side in size)
    return height, width


def to_tensor(image: np.ndarray) -> torch.Tensor:
    """Return a (h, w, 3) uint8 sRGB image as (3, h, w) float32 in [0, 1]."""
    return torch.from_numpy(np.ascontiguousarray(image.transpose(2, 0, 1))).float() / 255.0


def network_input(image: np.ndarray, size: tuple[int, int]) -> torch.Tensor:
    """Return a (h, w, 3) uint8 sRGB image scaled to `size` (h', w'), (1, 3, h', w') float32."""
    way = cv2.INTER_AREA if image.shape[1] > size[1] else cv2.INTER_LINEAR
    return to_tensor(cv2.resize(image, size[::-1], interpolation=way))[None]


def upsampled_argmax(logits: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return the best class per pixel at `size` (h, w) of (c, h', w') float32 logits.

    Classes are upsampled one at a time, to save memory for large photos.
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

    Each photo is labelled at several sizes, and the logits are averaged: small sizes help to
    recognise surfaces, large ones to find their borders. A network sees the photo mirrored at every
    second size, the next network at the other sizes. This is as good as both views at each size, in
    half the time (docs/measurements/segmentation.md).
    """

    def __init__(self, network: Network, *further: SegmentationNet) -> None:
        """Take a network or an ensemble, whose constants are used, and `further` networks."""
        self.network = network.eval()
        quick = folded(self.network)
        members = list(quick.members) if isinstance(quick, Ensemble) else [quick]
        members += [folded(member) for member in further]
        #: The networks, ready for inference.
        self.members = cast("list[SegmentationNet]", members)

    def draft(self, image: np.ndarray) -> np.ndarray:
        """Return (h, w) uint8 labels 0 to 3 by the first network alone, at one size.

        They are good enough to estimate a photo's camera. `image` as in :meth:`labels`.
        """
        logits = self._seen(self.members[:1], image, None, (DRAFT_SCALE,))
        return labels_of(logits, (image.shape[0], image.shape[1]))

    def logits(
        self, image: np.ndarray, camera: Camera | None, scales: Sequence[float] = SCALES
    ) -> np.ndarray:
        """Return (labels, h', w') float32 logits of a photo at half of its largest input size.

        `scales` are the input sizes, small to large. The network's logit adjustment of surfaces is
        added, and the sum is divided by its temperature. Arguments as in :meth:`labels`.
        """
        return self._seen(self.members, image, camera, scales)

    def opened(self, logits: np.ndarray) -> np.ndarray:
        """Return the `logits` of :meth:`logits` with the logit adjustment of doors and windows.

        The network underestimates how many of them photos show. The adjustment is made only when
        openings are asked for, so that all other labels stay as they are without them.
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
        """Return the mean logits of a photo by the `members` at the `scales`, small to large."""
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

        `camera`, if it is well known, gives the horizon to the network. With `openings` pixels of
        label other become 4 (door) or 5 (window) where the network labels these.
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
    """Return the mean logits (labels, h / 2, w / 2) float32 of `members` at input `size` (h, w).

    Every second network sees the photo mirrored, beginning with the first if `mirror_first`.
    """
    photo, elevation = network_input(image, size), None
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
    """Return labels (h, w) uint8 at `size` from the logits of :meth:`Segmenter.logits`."""
    labels = upsampled_argmax(surface_logits(logits), size)
    if openings and len(logits) > WINDOW:
        kinds = upsampled_argmax(logits[[OTHER, DOOR, WINDOW]], size)
        other = labels == OTHER
        labels[other] = np.array([OTHER, DOOR, WINDOW])[kinds[other]]
    return labels


def probabilities_of(logits: np.ndarray) -> np.ndarray:
    """Return the probabilities (labels, h', w') float32 of labels: the softmax of logits."""
    return np.asarray(softmax(logits, axis=0), dtype=np.float32)


def surface_logits(logits: np.ndarray) -> np.ndarray:
    """Return logits (4, h, w) of other, floor, wall, ceiling: doors and windows are other.

    The probability of other is the sum of those of door, window and other.
    """
    if len(logits) == len(LABELS):
        return logits
    other = np.logaddexp.reduce(logits[[OTHER, DOOR, WINDOW]], axis=0, keepdims=True)
    return np.concatenate([other, logits[1 : len(LABELS)]]).astype(np.float32)


def load_segmenter(path: str | Path) -> Segmenter:
    """Return the segmenter of a weights file; InputError if the file is of another network."""
    state, architecture = load_model_file(path)
    kind: type[Network] = Ensemble if "members" in architecture else SegmentationNet
    if architecture.pop("imagenet", False):
        kind = ImagenetSegmentationNet
    return Segmenter(filled(lambda: kind(**architecture), state, "the segmentation network", path))
