"""Hyperparameters of the segmentation network's training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SegmentationSettings:
    """Hyperparameters of the segmentation network's training."""

    #: Weights file that training starts from, of a network of the same widths; null: random ones.
    start: str | None = None
    #: Whether a network of ImageNet (extra ``rooms``) adds to the maps of an encoder that stays as
    #: it is in network `member` of the ensemble `start`.
    imagenet: bool = False
    member: int = 0
    #: Share of the weights to start from in what is kept: what they know of photos that renderings
    #: do not show is forgotten otherwise (WiSE-FT, doi 10.1109/CVPR52688.2022.00780).
    start_share: float = 0.0
    #: Runs from the same start that differ in their seed; the mean of their weights is kept (model
    #: soups, https://arxiv.org/abs/2203.05482).
    runs: int = 1
    #: Batches that the statistics of batch norm are taken anew from in the end: averaged weights
    #: answer otherwise than each of their parts (https://arxiv.org/abs/1803.05407, section 3.2).
    statistics: int = 0
    #: Weights files, joined by ``:``, of networks whose logits are averaged with those of the
    #: trained one wherever it labels photos (deep ensembles, arXiv 1612.01474); null: none.
    beside: str | None = None
    #: Weights files, joined by ``:``, of networks whose averaged logits are learned on the same
    #: views (distillation, https://arxiv.org/abs/1503.02531); null: none.
    teachers: str | None = None
    #: Share of the loss that is the teachers' rather than the labels', where there are teachers.
    distillation: float = 0.8
    #: Roots of further data sets whose train and val splits count too, joined by ``:``; of what
    #: teachers do not know: from these the labels alone are learned.
    further: str | None = None
    attention: int = 2  #: blocks of attention at each of two resolutions

    # Views.
    batch: int = 8  #: views in a step
    elevation_known: float = 0.6  #: of the views, those told where the horizon is: not all will be
    elevation_noise_deg: float = 1.5  #: deviation of what they are told, per axis
    # Longer side in pixels: small views are quick, large ones tell where things end.
    small: int = 224  #: in two thirds of the steps
    long_side: int = 320  #: in the last third; what sizes at inference are relative to

    # Optimiser: AdamW; a linear rise, then a cosine to a hundredth.
    steps: int = 7300
    stop: int = (
        0  #: step after which a run ends though the rate has not fallen all the way; 0: none
    )
    learning_rate: float = 3e-3  #: at the peak
    #: The same of what starts from nothing, where there are weights to start from; null: no other.
    fresh_learning_rate: float | None = None
    weight_decay: float = 0.02  #: of all but norms and biases
    clip_norm: float = 5.0  #: of the gradient
    ema_decay: float = 0.998  #: of the averaged weights, which are what is kept
    dice: float = 0.5  #: weight of the soft Dice loss beside cross-entropy: labels are not balanced
    #: Chance that the statistics of early features are mixed between views (:mod:`.mixing`).
    mixing: float = 0.0
    geometry: float = 0.3  #: weight of normals and depth, where photos have them
    label_smoothing: float = 0.02  #: borders of drawn labels are not exact to the pixel
    bfloat16: bool = False  #: forward pass in bfloat16; faster on processors that have it

    # The best of the validations is kept.
    evaluate_every: int = 500  #: steps
    evaluate_photos: int = 200  #: of a validation, spread over the split

    # Calibration, where photos that are like the users' tell it better than hard renderings do.
    #: What logits are divided by; null: chosen on the held-out photos.
    temperature: float | None = None
    # Added to the logit of a label of which photos hold more than renderings.
    floor_adjustment: float = 0.0
    wall_adjustment: float = 0.0
    ceiling_adjustment: float = 0.0
    door_adjustment: float = 0.0
    window_adjustment: float = 0.0

    @property
    def logit_adjustment(self) -> list[float]:
        """What is added to the logits of the six labels."""
        surfaces = [self.floor_adjustment, self.wall_adjustment, self.ceiling_adjustment]
        return [0, *surfaces, self.door_adjustment, self.window_adjustment]
