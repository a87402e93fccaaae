"""Hyperparameters of a texture model's training."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from plan2scene_workshop.training.loop import cosine


@dataclass(frozen=True)
class TextureSettings:
    """Hyperparameters of a texture model's training (Synth's or NaiveSynth's)."""

    # Sampling. Windows of 64 px cost a quarter of a whole tile of 128 px, but they do not show
    # coarse structure.
    batch: int = 6  #: number of windows in a step
    tile_batch: int = 2  #: number of tiles in a step that draws whole tiles
    tile_share: float = 0.12  #: share of the steps that draw whole tiles
    scanned_share: float = 0.5  #: share of crops from real textures, if there are any

    # A statistics encoder is first trained alone, to keep a crop's statistics and substance in its
    # code. That is cheap, because the costly decoder does not run.
    warm_up: int = 6144  #: number of crops
    warm_up_steps: int = 2304  #: number of steps, each with 64 of these crops
    warm_up_learning_rate: float = 2e-3  #: AdamW, constant
    warm_up_weight_decay: float = 0.01

    # Optimiser: Adam.
    steps: int = 4000  #: number of main steps
    finish: int = 600  #: number of further steps on whole tiles only, at a quarter of the rate
    learning_rate: float = 8e-4  #: full until 60 % of the steps, then a cosine to a hundredth
    weight_decay: float = 1e-5
    clip_norm: float = 2.0  #: largest norm of the gradient; unusual textures have large Gram errors
    dropout: float = 0.2  #: of a statistics encoder's hidden units, because textures are few

    # Loss: weights of its parts; the Gram error has weight 1.
    spectrum: float = 0.4  #: log power by sector
    colour: float = 4.0  #: sliced Wasserstein distance of the colours
    histogram: float = 1.0  #: differentiable COLOR metric
    frequency: float = 4.0  #: differentiable FREQ metric, of whole tiles only
    substance: float = 0.3  #: cross-entropy, if the model has a substance head
    statistics: Literal["embedded", "pretrained"] = "embedded"  #: fixed filters' Grams, or VGG-19's
    statistics_path: str | None = None  #: state dict of torchvision's vgg19, for ``pretrained``
    levels: int = 5  #: pyramid levels of the embedded filters

    low_precision: bool = True  #: decoder in bfloat16, on a GPU or a processor that is fast at it

    def rate(self, step: int) -> float:
        """Return the factor on the learning rate at a step."""
        if step < self.steps:
            rise, hold = round(0.02 * self.steps), round(0.6 * self.steps)
            return cosine(step, self.steps, rise=rise, hold=hold)
        return 0.25 * cosine(step - self.steps, self.finish)
