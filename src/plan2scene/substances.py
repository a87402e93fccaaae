"""What floors, walls and ceilings are of, by their looks and by which of the three they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: How often surfaces of homes are of each substance, in the order of ``house.SUBSTANCES``: no
#: ceiling is carpet, however woolly the photo.
SUBSTANCES_OF = {
    "floor": (0.45, 0.03, 0.26, 0.26),
    "wall": (0.02, 0.92, 0.002, 0.058),
    "ceiling": (0.025, 0.965, 0.001, 0.009),
}
#: The head is surer than it is right on real photos: its logits count this many times less.
TEMPERATURE = 3.0


def on_surfaces(probabilities: np.ndarray, surfaces: Sequence[str]) -> np.ndarray:
    """Return substances' probabilities (..., n, 4), knowing which kind of surface each of n is.

    Bayes' rule: those of the texture model's head (..., n, 4), softened, times how often such
    surfaces are of each substance.
    """
    if not probabilities.size:
        return probabilities
    prior = np.array([SUBSTANCES_OF[surface] for surface in surfaces])
    weighed = np.maximum(probabilities, 1e-12) ** (1.0 / TEMPERATURE) * prior
    return np.asarray(weighed / weighed.sum(axis=-1, keepdims=True), dtype=np.float32)
