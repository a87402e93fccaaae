"""Hyperparameters of the features network's training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FeaturesSettings:
    """Hyperparameters of the features network's training."""

    # What is drawn.
    batch: int = 32  #: crops in a step
    scanned_share: float = 0.4  #: of the crops, those of real textures, where there are any
    photographed_share: float = 0.75  #: of the crops, those spoiled as in a photo of a room

    # Optimiser: AdamW; a linear rise over 5 % of the steps, then a cosine to 0.
    steps: int = 4000
    learning_rate: float = 3e-3  #: at the peak
    weight_decay: float = 1e-2
    label_smoothing: float = 0.05  #: a window may show no joint of its planks or tiles

    held_out_crops: int = 1000  #: of each held-out set, for the card; features' scale has as many
