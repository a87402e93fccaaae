"""Hyperparameters of the plan network's training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LabelTraining:
    """Hyperparameters of training a network to label drawings.

    Optimiser: AdamW; the learning rate rises linearly, then falls by a cosine to a hundredth. The
    network of the best validation is kept.
    """

    #: Weights file that training starts from (a network of the same widths); null: random weights.
    start: str | None = None
    batch: int = 4  #: number of views in a step
    steps: int = 6000
    learning_rate: float = 3e-3  #: at the peak
    weight_decay: float = 0.02  #: of all parameters except norms and biases
    clip_norm: float = 5.0  #: largest norm of the gradient
    ema_decay: float = 0.998  #: of the moving average of the weights; the average is kept
    label_smoothing: float = 0.01
    bfloat16: bool = True  #: forward pass in bfloat16; faster on processors that have it
    evaluate_every: int = 1000  #: steps between validations


@dataclass(frozen=True)
class PlanSettings(LabelTraining):
    """Hyperparameters of the plan network's training."""

    # Drawings.
    drawings: int = 3000  #: number of homes, each drawn in one style; a view is a copy of a drawing
    blank_share: float = 0.04  #: share of views that show a sheet without a plan
    ppm_low: float = 18.0  #: smallest scale of a drawing, pixels per metre
    ppm_high: float = 46.0  #: largest scale of a drawing, pixels per metre

    # Views.
    side: int = 352  #: side of a view in pixels

    thin: float = 2.0  #: weight of walls and openings in the loss, because they have few pixels

    # At inference.
    long_side: int = 640  #: pixels of the longer side of a plan's picture

    held_out: int = 16  #: number of drawings of other homes in a validation
    figures: int = 40  #: number of drawings in held-out styles for the card's figures
