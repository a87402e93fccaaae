"""The use of a photographed room, by a linear classifier on the segmentation network's maps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import nn

from plan2scene.photos.labels.palette import KINDS
from plan2scene.photos.labels.segmentation import (
    Segmenter,
    brightened,
    network_input,
    network_size,
)
from plan2scene.weights import filled, load_model_file

#: Longer side in pixels of the photo that the network sees.
SIDE = 320
#: Indices of the encoder's maps that are used: those at strides 8, 16 and 32.
MAPS = (2, 3, 4)


@torch.inference_mode()
def kind_features(segmenter: Segmenter, image: np.ndarray) -> np.ndarray:
    """Return features (f,) float32: mean, maximum and deviation of each encoder channel of a photo.

    `image` is (h, w, 3) uint8 sRGB of any size.
    """
    size = network_size((image.shape[0], image.shape[1]), SIDE)
    photo = network_input(brightened(image), size)
    parts = []
    for member in segmenter.members:
        encoded = member.encoded(photo)
        for y in (encoded[k].flatten(2)[0] for k in MAPS):
            parts += [y.mean(1), y.amax(1), y.std(1)]
    return torch.cat(parts).numpy()


class RoomKinds(nn.Module):
    """Features -> logits of :data:`KINDS`; `inputs` is the number of features.

    Shapes: (n, inputs) -> (n, kinds).
    """

    mean: torch.Tensor
    scale: torch.Tensor

    def __init__(self, *, inputs: int) -> None:
        super().__init__()
        self.architecture = {"inputs": inputs}
        self.register_buffer("mean", torch.zeros(inputs))
        self.register_buffer("scale", torch.ones(inputs))
        self.linear = nn.Linear(inputs, len(KINDS))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return logits; see the class for shapes."""
        y: torch.Tensor = self.linear((x - self.mean) * self.scale)
        return y


def load_kinds(path: str | Path, segmenter: Segmenter) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function from a (h, w, 3) photo to probabilities of :data:`KINDS`, (k,) float32.

    `path` is the weights file of the classifier, `segmenter` the one that it was trained on. Raises
    InputError if the file belongs to another network.
    """
    state, architecture = load_model_file(path)
    network = filled(lambda: RoomKinds(**architecture), state, "the classifier of rooms", path)

    @torch.inference_mode()
    def probabilities(image: np.ndarray) -> np.ndarray:
        features = torch.from_numpy(kind_features(segmenter, image))
        return torch.softmax(network(features[None])[0], dim=0).numpy()

    return probabilities
