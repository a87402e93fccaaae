"""Hyperparameters of the segmentation network's training."""

from __future__ import annotations

from dataclasses import dataclass

from plan2scene_workshop.training.loop import cosine


@dataclass(frozen=True)
class SegmentationSettings:
    """Hyperparameters of the segmentation network's training."""

    # What is drawn.
    batch: int = 8  #: views in a step
    scenes: int = 2500  #: rooms that are drawn beside the photos
    scene_share: float = 0.35  #: of the views, those of drawn rooms once there are photos
    textures: str | None = None  #: folder of real tiles for drawn rooms (train split)
    elevation_known: float = 0.6  #: of the views, those told where the horizon is: not all will be
    elevation_noise_deg: float = 1.5  #: deviation of what they are told, per axis

    # Steps: drawn rooms alone teach floors, walls and ceilings before there are photos. Small views
    # are quick, large ones tell where things end. Sizes are the longer side in pixels.
    scene_steps: int = 1800  #: on drawn rooms alone
    steps: int = 5500  #: on photos and drawn rooms
    scene_side: int = 192  #: in two thirds of the steps on drawn rooms
    small: int = 224  #: in the rest of those, and in two thirds of the steps with photos
    long_side: int = 320  #: in the last third, and the smaller of two sizes at inference

    # Optimiser: AdamW; in either part a linear rise, then a cosine to a hundredth.
    learning_rate: float = 3e-3  #: at the peak of the steps on drawn rooms
    photo_learning_rate: float = 1.5e-3  #: at the peak of those with photos
    weight_decay: float = 0.02  #: of all but norms and biases
    clip_norm: float = 5.0  #: of the gradient
    ema_decay: float = 0.998  #: of the averaged weights, which are what is kept
    dice: float = 0.5  #: weight of the soft Dice loss beside cross-entropy: labels are not balanced
    label_smoothing: float = 0.02  #: borders of drawn labels are not exact to the pixel
    bfloat16: bool = False  #: forward pass in bfloat16; faster on processors that have it

    # The best of the validations is kept.
    evaluate_every: int = 500  #: steps
    evaluate_photos: int = 200  #: of a validation, spread over the split

    def rate(self, step: int) -> float:
        """Return the share of the learning rate at a step."""
        if step < self.scene_steps:
            return cosine(step, self.scene_steps, rise=min(300, self.scene_steps // 10 + 1))
        share, rise = self.photo_learning_rate / self.learning_rate, min(300, self.steps // 10 + 1)
        return share * cosine(step - self.scene_steps, self.steps, rise=rise)

    def side(self, step: int) -> int:
        """Return the longer side of the views of a step in pixels."""
        if step < self.scene_steps:
            return self.scene_side if 3 * step < 2 * self.scene_steps else self.small
        return self.small if 3 * (step - self.scene_steps) < 2 * self.steps else self.long_side
