"""The temperature that calibrates a network's probabilities."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from plan2scene.photos.labels.palette import IGNORE, without_openings
from plan2scene.photos.labels.segmentation import surface_logits

#: Temperatures that are tried.
TEMPERATURES = np.exp(np.linspace(np.log(0.5), np.log(3.0), 37))


def best_temperature(logits: Sequence[np.ndarray], labels: Sequence[np.ndarray]) -> float:
    """Return the temperature with the lowest cross-entropy of other, floor, wall and ceiling.

    Parameters
    ----------
    logits : n of (4 or 6, h', w') float32
        Of photos that the network was not trained on.
    labels : n of (h, w) uint8
        True labels of these photos; 255 is left out.
    """
    found, true = [], []
    for values, photo in zip(logits, labels, strict=True):
        size = (values.shape[2], values.shape[1])
        small = cv2.resize(without_openings(photo), size, interpolation=cv2.INTER_NEAREST)
        kept = small != IGNORE
        found.append(values[:, kept][:, ::7])  # neighbours add little
        true.append(small[kept][::7])
    every, right = np.concatenate(found, axis=1), np.concatenate(true)
    losses = [_cross_entropy(every / temperature, right) for temperature in TEMPERATURES]
    return float(TEMPERATURES[int(np.argmin(losses))])


def _cross_entropy(logits: np.ndarray, labels: np.ndarray) -> float:
    """Return the mean cross-entropy of logits (4 or 6, n) against labels (n,)."""
    four = surface_logits(logits[:, :, None])[:, :, 0]
    return float((np.logaddexp.reduce(four, axis=0) - four[labels, np.arange(len(labels))]).mean())
