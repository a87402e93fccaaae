"""Segmentation of a room photo into floor, wall, ceiling and other by the embedded network.

The paper takes the surfaces of a photo from a network trained on ADE20K (section 4). This one
(:mod:`.network`) is small enough to ship. Where it tells doors and windows, they are other unless
asked for.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

import cv2
import numpy as np
import torch

from plan2scene.photos.camera.calibration import Camera
from plan2scene.photos.labels.elevation import elevation_map
from plan2scene.photos.labels.ensemble import Ensemble
from plan2scene.photos.labels.folding import folded
from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import DOOR, LABELS, OTHER, WINDOW
from plan2scene.weights import filled, load_model_file

#: What labels photos: one network, or several whose logits are averaged.
Network = SegmentationNet | Ensemble

#: Input height and width are multiples of this (the encoder's coarsest stride).
STRIDE = 32
#: Sizes that a photo is seen at, relative to the network's.
SCALES = (0.8, 1.5)
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

    Each photo is seen at two sizes, at each of them also mirrored, and the answers are averaged:
    the smaller tells what is what, the larger where it ends.
    """

    def __init__(self, network: Network) -> None:
        self.network = network.eval()
        self._quick: Network = folded(self.network)
        first = self._quick.members[0] if isinstance(self._quick, Ensemble) else self._quick
        self._first = cast("SegmentationNet", first)

    def draft(self, image: np.ndarray) -> np.ndarray:
        """Return (h, w) uint8 labels 0 to 3 as the first network alone gives them.

        Enough to find a photo's camera by; arguments as of :meth:`labels`.
        """
        logits = self._seen(self._first, image, None)
        return labels_of(logits, (image.shape[0], image.shape[1]))

    def logits(self, image: np.ndarray, camera: Camera | None) -> np.ndarray:
        """Return (labels, h', w') float32 logits of a photo at half the larger network size.

        With the network's adjustment, divided by its temperature. Arguments as of :meth:`labels`.
        """
        return self._seen(self._quick, image, camera)

    def _seen(self, network: Network, image: np.ndarray, camera: Camera | None) -> np.ndarray:
        """Return the logits of a photo by one of the networks."""
        photo_size, image = (image.shape[0], image.shape[1]), brightened(image)
        sides = sorted(round(self.network.long_side * scale) for scale in SCALES)
        sizes = [network_size(photo_size, side) for side in sides]
        columns, rows = sizes[-1][1] // 2, sizes[-1][0] // 2
        found = [
            [
                cv2.resize(plane, (columns, rows), interpolation=cv2.INTER_LINEAR)
                for plane in _logits_at(network, image, camera, size)
            ]
            for size in sizes
        ]
        constants = self.network.architecture
        adjustment = np.array(constants["logit_adjustment"], np.float32)[:, None, None]
        return np.asarray((np.mean(found, axis=0) + adjustment) / constants["temperature"])

    def labels(
        self, image: np.ndarray, camera: Camera | None = None, *, openings: bool = False
    ) -> np.ndarray:
        """Return (h, w) uint8 labels (0 other, 1 floor, 2 wall, 3 ceiling) of a photo.

        Parameters
        ----------
        image : (h, w, 3) uint8 sRGB
            Any size; masks come back at that size.
        camera : Camera, optional
            The photo's, where one is known well: the network then knows where the horizon is.
        openings : bool
            Of what is other, doors are 4 and windows 5, where the network tells them.
        """
        size = (image.shape[0], image.shape[1])
        return labels_of(self.logits(image, camera), size, openings=openings)


@torch.inference_mode()
def _logits_at(
    network: Network, image: np.ndarray, camera: Camera | None, size: tuple[int, int]
) -> np.ndarray:
    """Return (labels, h / 2, w / 2) float32 logits of a photo seen at `size` (h, w)."""
    shrinks = image.shape[1] > size[1]
    way = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    small = cv2.resize(image, size[::-1], interpolation=way)
    photo = to_tensor(small)
    elevation = None
    if camera is not None:
        photo_size = (camera.height, camera.width)
        rise = elevation_map(camera.matrix[:, 1], camera.focal_px, photo_size, size)
        elevation = _and_mirrored(torch.from_numpy(rise))
    logits, mirrored = network(_and_mirrored(photo), elevation)
    return np.ascontiguousarray(((logits + mirrored.flip(2)) / 2).numpy())


def _and_mirrored(values: torch.Tensor) -> torch.Tensor:
    """Return (..., h, w) values and the same from right to left, (2, ..., h, w)."""
    return torch.stack([values, values.flip(-1)])


def labels_of(logits: np.ndarray, size: tuple[int, int], *, openings: bool = False) -> np.ndarray:
    """Return labels (h, w) uint8 at `size` of :meth:`Segmenter.logits`."""
    labels = upsampled_argmax(surface_logits(logits), size)
    if openings and len(logits) > WINDOW:
        kinds = upsampled_argmax(logits[[OTHER, DOOR, WINDOW]], size)
        other = labels == OTHER
        labels[other] = np.array([OTHER, DOOR, WINDOW])[kinds[other]]
    return labels


def confidence_of(logits: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return (h, w) float32 at `size`: how likely each pixel has its label of :func:`labels_of`."""
    four = surface_logits(logits)
    powers = np.exp(four - four.max(axis=0))
    best = powers.max(axis=0) / powers.sum(axis=0)
    return cv2.resize(best, size[::-1], interpolation=cv2.INTER_LINEAR)


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
    return Segmenter(filled(lambda: kind(**architecture), state, "the segmentation network", path))
