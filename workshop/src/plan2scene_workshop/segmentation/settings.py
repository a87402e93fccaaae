"""Hyperparameters of the segmentation network's training."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SegmentationSettings:
    """Hyperparameters of the segmentation network's training."""

    #: Weights file that training starts from (a network of the same widths); null: random weights.
    start: str | None = None
    #: Whether an ImageNet network (extra ``rooms``) adds its maps to those of the encoder. The
    #: encoder is that of network `member` of the ensemble `start`, and is not trained further.
    imagenet: bool = False
    member: int = 0
    #: Share of the starting weights in the weighted mean that is kept. Without it, training on
    #: renderings forgets what they know of photos (WiSE-FT, doi 10.1109/CVPR52688.2022.00780).
    start_share: float = 0.0
    #: Number of runs from the same start with different seeds; the mean of their weights is kept
    #: (model soups, https://arxiv.org/abs/2203.05482).
    runs: int = 1
    #: Number of batches from which the batch-norm statistics are computed anew at the end, because
    #: averaged weights need their own (https://arxiv.org/abs/1803.05407, section 3.2); 0: not done.
    statistics: int = 0
    #: Weights files, joined by ``:``. Their networks form an ensemble with the trained one: the
    #: logits of all are averaged (deep ensembles, arXiv 1612.01474); null: none.
    beside: str | None = None
    #: Weights files, joined by ``:``, of teachers: the network also learns to reproduce their
    #: averaged logits on the same views (https://arxiv.org/abs/1503.02531); null: none.
    teachers: str | None = None
    #: Weight of the teachers' loss, in [0, 1], if there are teachers; the labels get the rest.
    distillation: float = 0.8
    #: Root folders of further data sets, joined by ``:``, whose train and val splits are used too.
    #: Teachers are not used on their photos (unknown to them); only the labels are learned there.
    further: str | None = None
    #: Whether the labels to learn are those of what would be seen without furniture (amodal
    #: segmentation, doi 10.1109/CVPR.2017.323), of a data set with ``snapshots.amodal``.
    amodal: bool = False
    attention: int = 2  #: number of attention blocks at each of two resolutions

    # Views.
    batch: int = 8  #: number of views in a step
    elevation_known: float = 0.6  #: share of views with a known horizon; at inference not all have
    elevation_noise_deg: float = 1.5  #: standard deviation of the error of that horizon, per axis
    # Longer side of the views in pixels: small views are quick, large ones show exact borders.
    small: int = 224  #: in the first two thirds of the steps
    long_side: int = 320  #: in the last third; sizes at inference are multiples of it

    # Optimiser: AdamW; the learning rate rises linearly, then falls by a cosine to a hundredth.
    steps: int = 7300
    stop: int = (
        0  #: step after which a run ends early, before the learning rate has fallen fully; 0: none
    )
    learning_rate: float = 3e-3  #: at the peak
    #: Peak learning rate of the parameters that no starting weights hold; null: the same rate.
    fresh_learning_rate: float | None = None
    weight_decay: float = 0.02  #: of all parameters except norms and biases
    clip_norm: float = 5.0  #: largest norm of the gradient
    ema_decay: float = 0.998  #: of the moving average of the weights; the average is kept
    dice: float = 0.5  #: weight of the soft Dice loss beside cross-entropy: labels are not balanced
    #: Probability that the statistics of early features are mixed between views (:mod:`.mixing`).
    mixing: float = 0.0
    geometry: float = 0.3  #: weight of the loss of normals and depth, if photos have them
    label_smoothing: float = 0.02  #: borders of drawn labels are not exact to the pixel
    bfloat16: bool = False  #: forward pass in bfloat16; faster on processors that have it

    # The network of the best validation is kept.
    evaluate_every: int = 500  #: steps between validations
    evaluate_photos: int = 200  #: number of photos of a validation, spread over the split

    # Calibration. Photos like the users' measure it better than the hard held-out renderings.
    #: Divisor of the logits; null: chosen on the held-out photos.
    temperature: float | None = None
    # Added to the logit of a label that is more frequent in photos than in renderings.
    floor_adjustment: float = 0.0
    wall_adjustment: float = 0.0
    ceiling_adjustment: float = 0.0
    door_adjustment: float = 0.0
    window_adjustment: float = 0.0

    @property
    def logit_adjustment(self) -> list[float]:
        """The constants that are added to the logits of the six labels."""
        surfaces = [self.floor_adjustment, self.wall_adjustment, self.ceiling_adjustment]
        return [0, *surfaces, self.door_adjustment, self.window_adjustment]
