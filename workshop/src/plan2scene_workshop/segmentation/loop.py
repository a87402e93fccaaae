"""The training loop of the segmentation network."""

from __future__ import annotations

import copy
import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from plan2scene.errors import InputError
from plan2scene.photos.camera.calibration import Camera, estimate_camera
from plan2scene.photos.labels.elevation import elevation_map
from plan2scene.photos.labels.palette import IGNORE, LABELS
from plan2scene.photos.labels.segmentation import SegmentationNet, Segmenter, to_tensor
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.segmentation.augment import training_sample_with_map
from plan2scene_workshop.segmentation.data import (
    LabelledPhoto,
    Scores,
    confusion,
    scores,
)

_log = logging.getLogger("plan2scene")


@dataclass(frozen=True)
class Settings:
    """Settings of a training run (config key ``training.segmentation``)."""

    steps: int = 5500  #: optimiser steps on photos and scenes
    scene_steps: int = 1800  #: optimiser steps on scenes alone, before the photos
    batch: int = 8  #: views per step
    learning_rate: float = 3e-3  #: peak of the warm-up and cosine schedule
    photo_learning_rate: float = 1.5e-3  #: likewise, of the steps with photos
    weight_decay: float = 0.02
    dice: float = 0.5  #: weight of the soft Dice loss beside cross-entropy
    ema_decay: float = 0.998  #: of the averaged weights, which are what is kept
    scene_side: int = 192  #: longer side of views in two thirds of the steps on scenes, pixels
    small: int = 224  #: in the rest of those, and in two thirds of the steps with photos
    long_side: int = 320  #: in the last third, and the smaller of two sizes at inference
    scenes: int = 2500  #: rooms that are drawn beside the photos
    textures: str | None = None  #: folder of real tiles for drawn rooms (train split)
    scene_share: float = 0.35  #: share of views that come from them once there are photos
    gaze_known: float = 0.6  #: share of views whose camera the network is told
    gaze_noise_deg: float = 1.5  #: standard deviation of what it is told, per axis
    bfloat16: bool = False  #: forward pass in bfloat16; faster on processors that have it
    evaluate_every: int = 500  #: steps between validations
    evaluate_photos: int = 200  #: photos of a validation, spread over the split

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Settings:
        """Return settings from a config section; InputError for a key that is none."""
        known = {f.name for f in fields(cls)}
        for key in values:
            if key not in known:
                raise InputError(f"training.segmentation keys of {sorted(known)}", key)
        return cls(**values)


def segmentation_loss(logits: torch.Tensor, labels: torch.Tensor, dice: float) -> torch.Tensor:
    """Return cross-entropy + `dice` x soft Dice over the batch.

    Parameters
    ----------
    logits : (n, 4, h / 2, w / 2) float32
        Brought to the labels' size first, so that borders are learned at full resolution.
    labels : (n, h, w) int64
        255 is left out.
    """
    logits = F.interpolate(logits, size=labels.shape[1:], mode="bilinear")
    loss = F.cross_entropy(logits, labels, ignore_index=IGNORE, label_smoothing=0.02)
    kept = (labels != IGNORE)[:, None]
    target = F.one_hot(labels.where(labels != IGNORE, 0), len(LABELS)).permute(0, 3, 1, 2) * kept
    probability = logits.softmax(dim=1) * kept
    overlap = (probability * target).sum(dim=(0, 2, 3))
    total = (probability + target).sum(dim=(0, 2, 3))
    return loss + dice * (1 - ((2 * overlap + 1) / (total + 1)).mean())


class Average:
    """Exponential moving average of a network's weights; early steps count less history."""

    def __init__(self, network: SegmentationNet, decay: float) -> None:
        self.network = copy.deepcopy(network).eval()
        self.decay = decay
        self.count = 0

    @torch.no_grad()
    def update(self, network: nn.Module) -> None:
        """Move the average towards the network's present weights and statistics."""
        self.count += 1
        decay = min(self.decay, self.count / (self.count + 10))
        state = self.network.state_dict()
        for name, value in network.state_dict().items():
            if value.is_floating_point():
                state[name].lerp_(value, 1 - decay)
            else:
                state[name].copy_(value)


def estimated_cameras(photos: Sequence[LabelledPhoto]) -> list[Camera | None]:
    """Return the camera of each photo as its line segments alone tell it; None when they do not."""
    found = [estimate_camera(photo.image) for photo in photos]
    return [None if camera.fallback else camera for camera in found]


def evaluate(
    network: SegmentationNet,
    photos: Sequence[LabelledPhoto],
    cameras: Sequence[Camera | None],
) -> Scores:
    """Return the scores of a network on whole photos, told their estimated cameras."""
    segmenter = Segmenter(copy.deepcopy(network).cpu())
    return scores(
        [
            confusion(segmenter.labels(photo.image, camera), photo.labels)
            for photo, camera in zip(photos, cameras, strict=True)
        ]
    )


def train(
    photos: Sequence[LabelledPhoto],
    held_out: Sequence[LabelledPhoto],
    settings: Settings,
    *,
    seed: int,
    steps: int,
    learning_rate: float,
    sides: tuple[int, int],
    scenes: Sequence[LabelledPhoto] = (),
    start: SegmentationNet | None = None,
) -> tuple[SegmentationNet, Scores, int]:
    """Return the best averaged network, its scores on `held_out`, and the step it is from.

    Parameters
    ----------
    photos, held_out : labelled photos of disjoint houses
    sides : (int, int)
        Longer side of views in the first two thirds of the steps, and afterwards; pixels.
    scenes : labelled photos
        Further views that are mixed in (``settings.scene_share``).
    start : SegmentationNet, optional
        Weights to start from; random ones (by `seed`) when None.
    """
    torch.manual_seed(derive_seed(seed, "segmentation", "weights") % 2**32)
    network = SegmentationNet(long_side=settings.long_side, elevation=True)
    if start:
        network = with_elevation(start, settings.long_side)
    descent = Descent(network, settings, steps=steps, learning_rate=learning_rate)
    rng = generator(seed, "segmentation", "views")
    cameras = estimated_cameras(held_out)
    best: tuple[Scores, dict[str, torch.Tensor], int] | None = None
    running, started = 0.0, time.monotonic()
    for step in range(1, steps + 1):
        long = sides[0] if step <= steps * 2 / 3 else sides[1]
        running += descent.step(*_batch(photos, scenes, settings, long, rng))
        if step % 100 == 0:
            pace = (time.monotonic() - started) / step
            _log.info("step %d loss %.4f %.2f s/step", step, running / 100, pace)
            running = 0.0
        if step % settings.evaluate_every == 0 or step == steps:
            found = evaluate(descent.average.network, held_out, cameras)
            _log.info("step %d held out %s", step, scores_line(found))
            if best is None or found.mean_iou > best[0].mean_iou:
                state = descent.average.network.state_dict()
                best = (found, {k: v.detach().cpu().clone() for k, v in state.items()}, step)
    if best is None:
        raise InputError("training steps above 0", str(steps))
    network.cpu().load_state_dict(best[1])
    return network.eval(), best[0], best[2]


class Descent:
    """The optimiser of a training run: AdamW, warm-up and cosine schedule, averaged weights."""

    def __init__(
        self, network: SegmentationNet, settings: Settings, *, steps: int, learning_rate: float
    ) -> None:
        self.device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        network.to(self.device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.network, self.settings = network, settings
        self.average = Average(network, settings.ema_decay)
        self.optimiser = torch.optim.AdamW(
            _parameter_groups(network, settings.weight_decay), lr=learning_rate
        )
        warm_up = min(300, steps // 10 + 1)
        self.schedule = torch.optim.lr_scheduler.LambdaLR(
            self.optimiser, lambda step: _learning_rate(step, warm_up, steps)
        )

    def step(self, images: torch.Tensor, sine: torch.Tensor, labels: torch.Tensor) -> float:
        """Take one step on a batch (see :func:`_batch`) and return its loss."""
        device, settings = self.device, self.settings
        with torch.autocast(device.type, torch.bfloat16, enabled=settings.bfloat16):
            logits = self.network.train()(images.to(device), sine.to(device))
        loss = segmentation_loss(logits.float(), labels.to(device), settings.dice)
        self.optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self.optimiser.step()
        self.schedule.step()
        self.average.update(self.network)
        return float(loss.item())


def _parameter_groups(network: nn.Module, decay: float) -> list[dict[str, Any]]:
    """Return optimiser groups: no weight decay on norms and biases."""
    decayed = [p for p in network.parameters() if p.ndim > 1]
    free = [p for p in network.parameters() if p.ndim <= 1]
    return [{"params": decayed, "weight_decay": decay}, {"params": free, "weight_decay": 0.0}]


def _learning_rate(step: int, warm_up: int, steps: int) -> float:
    """Return the factor of the learning rate: linear warm-up, then a cosine to 1 %."""
    if step < warm_up:
        return (step + 1) / warm_up
    share = (step - warm_up) / max(1, steps - warm_up)
    return float(0.01 + 0.99 * (1 + np.cos(np.pi * min(1.0, share))) / 2)


class Elevations(Sequence[np.ndarray]):
    """The elevation maps of photos, each made when it is asked for, with noise.

    A camera is estimated with an error at inference, and sometimes not at all, so the network
    must not trust the map to the degree.
    """

    def __init__(
        self, photos: Sequence[LabelledPhoto], settings: Settings, rng: np.random.Generator
    ) -> None:
        self.photos, self.settings, self.rng = photos, settings, rng

    def __len__(self) -> int:
        return len(self.photos)

    def __getitem__(self, index: int) -> np.ndarray:  # type: ignore[override]
        """Return the map (h, w) float32 of a photo; NaN where it stays unknown this time."""
        photo = self.photos[index]
        size = (photo.labels.shape[0], photo.labels.shape[1])
        if photo.gaze is None or self.rng.random() >= self.settings.gaze_known:
            return np.full(size, np.nan, np.float32)
        wrong = 5.0 if self.rng.random() < 0.1 else 1.0
        noise = self.rng.normal(0, np.deg2rad(self.settings.gaze_noise_deg) * wrong, 3)
        up = np.array(photo.gaze.up) + noise
        focal = photo.gaze.focal * np.exp(self.rng.normal(0, 0.08 * wrong)) * size[1]
        return elevation_map(up / np.linalg.norm(up), float(focal), size, size)


def _batch(
    photos: Sequence[LabelledPhoto],
    scenes: Sequence[LabelledPhoto],
    settings: Settings,
    long: int,
    rng: np.random.Generator,
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return (n, 3, h, w) views, (n, h, w) elevations, both float32, (n, h, w) int64 labels."""
    short = round(long * 0.75 / 32) * 32
    size = [(short, long), (long, short), (short, short)][rng.choice(3, p=[0.65, 0.2, 0.15])]
    samples = []
    for _ in range(settings.batch):
        pool = scenes if scenes and rng.random() < settings.scene_share else photos
        maps = Elevations(pool, settings, rng)
        samples.append(
            training_sample_with_map(pool, maps, int(rng.integers(len(pool))), size, rng)
        )
    images = torch.stack([to_tensor(image) for image, _, _ in samples])
    labels = torch.from_numpy(np.stack([labels for _, labels, _ in samples]).astype(np.int64))
    sine = torch.from_numpy(np.stack([sine for _, _, sine in samples]))
    return images.contiguous(memory_format=torch.channels_last), sine, labels


def with_elevation(start: SegmentationNet, long_side: int) -> SegmentationNet:
    """Return a copy of a network that also takes the elevation map.

    Weights of the new inputs are zero where the network had none, so that it answers as before.
    """
    network = SegmentationNet(**{**start.architecture, "elevation": True, "long_side": long_side})
    state = {name: value.clone() for name, value in start.state_dict().items()}
    weight = state["stem.0.0.weight"]
    missing = network.state_dict()["stem.0.0.weight"].shape[1] - weight.shape[1]
    state["stem.0.0.weight"] = F.pad(weight, (0, 0, 0, 0, 0, missing))
    network.load_state_dict(state)
    return network


def scores_line(found: Scores) -> str:
    """Return scores as one line of text."""
    parts = [f"{name} {value:.3f}" for name, value in zip(LABELS, found.iou, strict=True)]
    return f"mean IoU {found.mean_iou:.4f} ({', '.join(parts)}), accuracy {found.accuracy:.4f}"
