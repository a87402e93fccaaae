"""Run a network on a picture of a plan: probabilities of its labels out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.nn import functional as F

from plan2scene.photos.labels.network import SegmentationNet, folded
from plan2scene.photos.labels.segmentation import STRIDE, to_tensor
from plan2scene.weights import filled, fitting, load_model_file
from plan2scene_app.tracing.settings import PLAN_LABELS


class PlanSegmenter:
    """Labels pictures of plans with a :class:`SegmentationNet`."""

    def __init__(self, network: SegmentationNet) -> None:
        self.network = folded(network)
        self.long_side = network.long_side
        self.labels: int = network.architecture["labels"]

    @torch.no_grad()
    def probabilities(self, image: np.ndarray, *, views: int = 1) -> np.ndarray:
        """Return probabilities (labels, h, w) float32 of a picture (h, w, 3) uint8 at its own size.

        A plan has no up: the mean of up to 8 `views`, turned by quarters and mirrored, is taken.
        """
        total = np.zeros((self.labels, *image.shape[:2]), np.float32)
        for view in range(views):
            # View 1 is turned by half and mirrored, so that two views already differ much.
            turns, mirrored = (0, 2, 1, 3, 2, 0, 3, 1)[view], view % 2 == 1
            view_image = np.rot90(image, turns)
            view_image = view_image[:, ::-1] if mirrored else view_image
            values = self._seen(np.ascontiguousarray(view_image))
            values = values[:, :, ::-1] if mirrored else values
            total += np.rot90(values, -turns, axes=(1, 2))
        return total / views

    def _seen(self, image: np.ndarray) -> np.ndarray:
        """Return the probabilities of one view, padded to the network's stride by its border."""
        h, w = image.shape[:2]
        right, below = -w % STRIDE, -h % STRIDE
        padded = cv2.copyMakeBorder(image, 0, below, 0, right, cv2.BORDER_REPLICATE)
        logits = self.network(to_tensor(padded)[None])
        logits = F.interpolate(logits, size=padded.shape[:2], mode="bilinear")
        return np.asarray(logits[0, :, :h, :w].softmax(dim=0).numpy())


def load_plan_segmenter(path: str | Path, labels: Sequence[str] = PLAN_LABELS) -> PlanSegmenter:
    """Return the segmenter of a weights file; InputError if it holds a network of other labels."""
    state, architecture = load_model_file(path)
    name = "the plan network" if labels == PLAN_LABELS else "the fixture network"
    with fitting(name, path):
        if architecture.get("labels") != len(labels):
            raise ValueError(f"{architecture.get('labels')} labels, not {len(labels)}")
    return PlanSegmenter(filled(lambda: SegmentationNet(**architecture), state, name, path))
