"""Hyperparameters of a texture model's training."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from plan2scene_workshop.training.loop import cosine


@dataclass(frozen=True)
class TextureSettings:
    """Hyperparameters of a texture model's training (Synth's or NaiveSynth's)."""

    # What is drawn. Windows of 64 px cost a quarter of a whole tile of 128 px, but what is coarse
    # is not in them.
    batch: int = 6  #: windows in a step
    tile_batch: int = 2  #: whole tiles in a step
    tile_share: float = 0.12  #: of the steps, those that draw whole tiles
    scanned_share: float = 0.5  #: of the crops, those of real textures, where there are any

    # A statistics encoder first learns alone to keep a crop's statistics and substance in its
    # code: decoding is what costs.
    warm_up: int = 6144  #: crops
    warm_up_steps: int = 2304  #: of 64 of these crops each
    warm_up_learning_rate: float = 2e-3  #: AdamW, constant
    warm_up_weight_decay: float = 0.01

    # Optimiser: Adam.
    steps: int = 4000  #: that train everything
    finish: int = 600  #: further ones on whole tiles alone, at a quarter of the rate
    learning_rate: float = 8e-4  #: full until 60 % of the steps, then a cosine to a hundredth
    weight_decay: float = 1e-5
    clip_norm: float = 2.0  #: of the gradient: Gram errors of odd textures are large
    dropout: float = 0.2  #: of a statistics encoder's hidden units: textures are few

    # Loss: weights beside the Gram error's 1.
    spectrum: float = 0.4  #: log power by sector
    colour: float = 4.0  #: sliced distance of the colours
    histogram: float = 1.0  #: COLOR with gradients
    frequency: float = 4.0  #: FREQ with gradients, of whole tiles
    substance: float = 0.3  #: cross-entropy, where there is a head
    statistics: Literal["embedded", "pretrained"] = "embedded"  #: whose Gram matrices: or VGG-19's
    statistics_path: str | None = None  #: state dict of torchvision's vgg19, for ``pretrained``
    levels: int = 5  #: pyramid levels of the embedded filters

    low_precision: bool = True  #: decoder in bfloat16, where the processor is fast at it

    def rate(self, step: int) -> float:
        """Return the share of the learning rate at a step."""
        if step < self.steps:
            rise, hold = round(0.02 * self.steps), round(0.6 * self.steps)
            return cosine(step, self.steps, rise=rise, hold=hold)
        return 0.25 * cosine(step - self.steps, self.finish)
