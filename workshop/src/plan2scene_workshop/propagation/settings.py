"""Hyperparameters of the propagation network's training."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class PropagationSettings:
    """Hyperparameters of the propagation network's training."""

    network: Literal["pointer", "gated"] = "pointer"  #: the embedded one, or the paper's
    doors: bool = True  #: false: no edges between rooms, so that they have no neighbours

    # Sampling.
    batch: int = 32  #: number of houses in a step (paper: 32)
    room_drop_share: float = 0.6  #: share of samples that hide whole rooms

    photo_light_share: float = 0.6  #: share of samples in photos' own light; others: corrected

    # Optimiser: AdamW; the rate falls by a cosine to 0.
    steps: int = 3000
    learning_rate: float = 2e-3
    weight_decay: float = 1e-4

    held_out_share: float = 0.15  #: share of houses for choosing the best step and for the card
