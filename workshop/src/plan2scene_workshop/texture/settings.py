"""Hyperparameters of a texture model's training."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TextureTraining:
    """Hyperparameters of a texture model's training.

    Attributes
    ----------
    warm_up : int
        Crops on whose statistics a statistics encoder is trained alone first.
    steps, finish : int
        Steps that train everything, and further ones that draw whole tiles only: what is coarse
        is not in windows.
    batch, tile_batch : int
        Crops per step with 64-px windows, and with whole tiles.
    tile_share : float
        Share of the steps that draw whole tiles.
    learning_rate : float
        Adam's, held for 60 % of the steps, then falling to a hundredth along a cosine.
    dropout : float
        Share of a statistics encoder's hidden units left out at a time.
    spectrum, colour, histogram, frequency, substance : float
        Weights of these losses beside the Gram error's 1; `frequency` counts for whole tiles.
    scanned_share : float
        Share of crops that come from scanned textures, where there are any.
    low_precision : bool
        Decoder in bfloat16.
    levels : int
        Pyramid levels of the embedded filters.
    statistics : str
        Whose Gram matrices the loss compares: ``embedded`` filters, or ``pretrained`` VGG-19.
    statistics_path : str, optional
        State dict of torchvision's ``vgg19``, for ``pretrained``.
    """

    warm_up: int = 6144
    steps: int = 4000
    finish: int = 600
    batch: int = 6
    tile_batch: int = 2
    tile_share: float = 0.12
    learning_rate: float = 8e-4
    weight_decay: float = 1e-5
    dropout: float = 0.2
    spectrum: float = 0.4
    colour: float = 4.0
    histogram: float = 1.0
    frequency: float = 4.0
    substance: float = 0.3
    scanned_share: float = 0.5
    low_precision: bool = True
    levels: int = 5
    statistics: str = "embedded"
    statistics_path: str | None = None


def schedule(progress: float) -> float:
    """Return the share of the learning rate: held, then a cosine to a hundredth."""
    if progress < 0.6:
        return min(1.0, 0.05 + progress * 50)
    fall = min(1.0, (progress - 0.6) / 0.4)
    return float(0.01 + 0.99 * 0.5 * (1 + np.cos(np.pi * fall)))
