"""Hyperparameters of the plan network's training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PlanSettings:
    """Hyperparameters of the plan network's training."""

    #: Weights file that training starts from, of a network of the same widths; null: random ones.
    start: str | None = None

    # Drawings.
    drawings: int = 3000  #: different homes, each in one style; a view is a new copy of one
    blank_share: float = 0.04  #: of the views: a sheet without any plan
    ppm_low: float = 18.0  #: pixels a metre
    ppm_high: float = 46.0

    # Views.
    batch: int = 4  #: views in a step
    side: int = 352  #: pixels

    # Optimiser: AdamW; a linear rise, then a cosine to a hundredth.
    steps: int = 6000
    learning_rate: float = 3e-3  #: at the peak
    weight_decay: float = 0.02  #: of all but norms and biases
    clip_norm: float = 5.0  #: of the gradient
    ema_decay: float = 0.998  #: of the averaged weights, which are what is kept
    thin: float = 2.0  #: weight in the loss of walls and openings, which are few pixels
    label_smoothing: float = 0.01
    bfloat16: bool = True  #: forward pass in bfloat16; faster on processors that have it

    # At inference.
    long_side: int = 640  #: pixels of the longer side of a plan's picture

    # The best of the validations is kept.
    evaluate_every: int = 1000  #: steps
    held_out: int = 16  #: drawings of other homes that a validation sees
    figures: int = 40  #: drawings in styles held out that the card's figures are of
