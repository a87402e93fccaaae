"""Training of the segmentation network: its loss, its batches and its evaluation."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from plan2scene.photos.camera.calibration import Camera, estimate_camera
from plan2scene.photos.labels.elevation import elevation_map
from plan2scene.photos.labels.palette import IGNORE, LABELS
from plan2scene.photos.labels.segmentation import SegmentationNet, Segmenter
from plan2scene_workshop.segmentation.augment import training_batch
from plan2scene_workshop.segmentation.data import LabelledPhoto, Scores, confusion, digest, scores
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, best_device, cosine


def segmentation_loss(
    logits: torch.Tensor, labels: torch.Tensor, dice: float, smoothing: float = 0.0
) -> torch.Tensor:
    """Return cross-entropy + `dice` x soft Dice over the batch.

    Parameters
    ----------
    logits : (n, 4, h / 2, w / 2) float32
        Brought to the labels' size first, so that borders are learned at full resolution.
    labels : (n, h, w) int64
        255 is left out.
    """
    logits = F.interpolate(logits, size=labels.shape[1:], mode="bilinear")
    loss = F.cross_entropy(logits, labels, ignore_index=IGNORE, label_smoothing=smoothing)
    kept = (labels != IGNORE)[:, None]
    target = F.one_hot(labels.where(labels != IGNORE, 0), len(LABELS)).permute(0, 3, 1, 2) * kept
    probability = logits.softmax(dim=1) * kept
    overlap = (probability * target).sum(dim=(0, 2, 3))
    total = (probability + target).sum(dim=(0, 2, 3))
    return loss + dice * (1 - ((2 * overlap + 1) / (total + 1)).mean())


def estimated_cameras(photos: Sequence[LabelledPhoto]) -> list[Camera | None]:
    """Return the camera of each photo as its line segments alone tell it; None when they do not."""
    found = [estimate_camera(photo.image) for photo in photos]
    return [None if camera.fallback else camera for camera in found]


def evaluate(
    network: SegmentationNet, photos: Sequence[LabelledPhoto], cameras: Sequence[Camera | None]
) -> Scores:
    """Return the scores of a network on whole photos, told their estimated cameras."""
    segmenter = Segmenter(copy.deepcopy(network).cpu())
    return scores(
        [
            confusion(segmenter.labels(photo.image, camera), photo.labels)
            for photo, camera in zip(photos, cameras, strict=True)
        ]
    )


def train_network(
    network: SegmentationNet,
    photos: Sequence[LabelledPhoto],
    held_out: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    *,
    seed: int,
    checkpoint: Path | None = None,
) -> Trained[SegmentationNet]:
    """Return the averaged network that did best on `held_out` (mean IoU).

    It starts from the weights of `network`, or goes on from a checkpoint of this run.
    """
    device = best_device()
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def loss(step: int, rng: np.random.Generator) -> dict[str, torch.Tensor]:
        long = settings.small if step < settings.steps * 2 / 3 else settings.long_side
        images, elevations, labels = draw_batch(photos, settings, long, rng, device)
        logits = network(images, elevations).float()
        smoothing = settings.label_smoothing
        return {"labels": segmentation_loss(logits, labels, settings.dice, smoothing)}

    options = TrainerOptions(
        "segmentation",
        seed,
        settings.steps,
        lambda step: cosine(step, settings.steps, rise=min(300, settings.steps // 10 + 1)),
        clip_norm=settings.clip_norm,
        average_decay=settings.ema_decay,
        evaluate_every=settings.evaluate_every,
        bfloat16=settings.bfloat16,
    )
    optimiser = torch.optim.AdamW(
        _parameter_groups(network, settings.weight_decay), lr=settings.learning_rate
    )
    cameras = estimated_cameras(held_out)
    trainer = Trainer(
        network,
        loss,
        optimiser,
        options,
        evaluate=lambda network: evaluate(network, held_out, cameras).mean_iou,
        run=(settings, digest(photos)),
    )
    trainer.resume(checkpoint)
    return trainer.fit(checkpoint)


def _parameter_groups(network: nn.Module, decay: float) -> list[dict[str, Any]]:
    """Return optimiser groups: no weight decay on norms and biases."""
    decayed = [p for p in network.parameters() if p.ndim > 1]
    free = [p for p in network.parameters() if p.ndim <= 1]
    return [{"params": decayed, "weight_decay": decay}, {"params": free, "weight_decay": 0.0}]


def draw_batch(
    photos: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    long: int,
    rng: np.random.Generator,
    device: str = "cpu",
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return (n, 3, h, w) views, (n, h, w) elevations, both float32, (n, h, w) int64 labels.

    Views are `long` pixels on their longer side and lie, stand or are square.
    """
    short = round(long * 0.75 / 32) * 32
    size = [(short, long), (long, short), (short, short)][rng.choice(3, p=[0.65, 0.2, 0.15])]
    chosen = [photos[index] for index in rng.integers(len(photos), size=settings.batch)]
    told = [told_elevation(photo, settings, rng) for photo in chosen]
    images, elevations, labels = training_batch(chosen, told, size, rng, device)
    return images.contiguous(memory_format=torch.channels_last), elevations, labels


def told_elevation(
    photo: LabelledPhoto, settings: SegmentationSettings, rng: np.random.Generator
) -> np.ndarray:
    """Return the elevation map (h, w) float32 that the network is told of a photo.

    NaN where it stays unknown this time: a camera is estimated with an error at inference, and
    sometimes not at all, so the network must not trust the map to the degree.
    """
    size = (photo.labels.shape[0], photo.labels.shape[1])
    if photo.horizon is None or rng.random() >= settings.elevation_known:
        return np.full(size, np.nan, np.float32)
    wrong = 5.0 if rng.random() < 0.1 else 1.0
    noise = rng.normal(0, np.deg2rad(settings.elevation_noise_deg) * wrong, 3)
    up = np.array(photo.horizon.up) + noise
    focal = photo.horizon.focal * np.exp(rng.normal(0, 0.08 * wrong)) * size[1]
    return elevation_map(up / np.linalg.norm(up), float(focal), size, size)
