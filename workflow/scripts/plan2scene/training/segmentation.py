"""Training of the segmentation network: labelled photos in, weights and a model card out."""

from __future__ import annotations

import copy
import logging
import os
import platform
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from plan2scene.errors import InputError
from plan2scene.io import atomic_path
from plan2scene.photos.masks import IGNORE, LABELS
from plan2scene.photos.segmentation import SegmentationNet, Segmenter, load_segmenter, to_tensor
from plan2scene.seeds import derive_seed, generator
from plan2scene.training.segmentation_augment import training_sample
from plan2scene.training.segmentation_data import (
    LabelledPhoto,
    Scores,
    confusion,
    read_labelled_photos,
    scores,
)
from plan2scene.training.segmentation_scenes import random_scenes
from plan2scene.weights import save_model_file

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
    long_side: int = 320  #: in the last third, and at inference
    scenes: int = 1000  #: rooms of boxes that are drawn beside the photos
    scene_share: float = 0.35  #: share of views that come from them once there are photos
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


def evaluate(network: SegmentationNet, photos: Sequence[LabelledPhoto]) -> Scores:
    """Return the scores of a network on whole photos, the way the masks stage runs it."""
    segmenter = Segmenter(copy.deepcopy(network).cpu())
    return scores([confusion(segmenter.labels(p.image), p.labels) for p in photos])


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
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    torch.manual_seed(derive_seed(seed, "segmentation", "weights") % 2**32)
    network = copy.deepcopy(start) if start else SegmentationNet(long_side=settings.long_side)
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    average = Average(network, settings.ema_decay)
    optimiser = torch.optim.AdamW(
        _parameter_groups(network, settings.weight_decay), lr=learning_rate
    )
    warm_up = min(300, steps // 10 + 1)
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser, lambda step: _learning_rate(step, warm_up, steps)
    )
    rng = generator(seed, "segmentation", "views")
    best: tuple[float, dict[str, torch.Tensor], Scores, int] | None = None
    running, started = 0.0, time.monotonic()
    for step in range(1, steps + 1):
        long = sides[0] if step <= steps * 2 / 3 else sides[1]
        images, labels = _batch(photos, scenes, settings, long, rng)
        loss = segmentation_loss(
            network.train()(images.to(device)), labels.to(device), settings.dice
        )
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimiser.step()
        schedule.step()
        average.update(network)
        running += loss.item()
        if step % 100 == 0:
            pace = (time.monotonic() - started) / step
            _log.info("step %d loss %.4f %.2f s/step", step, running / 100, pace)
            running = 0.0
        if step % settings.evaluate_every == 0 or step == steps:
            found = evaluate(average.network, held_out)
            _log.info("step %d held out %s", step, _scores_line(found))
            if best is None or found.mean_iou > best[0]:
                state = {
                    k: v.detach().cpu().clone() for k, v in average.network.state_dict().items()
                }
                best = (found.mean_iou, state, found, step)
    if best is None:
        raise InputError("training steps above 0", str(steps))
    network.cpu().load_state_dict(best[1])
    return network.eval(), best[2], best[3]


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


def _batch(
    photos: Sequence[LabelledPhoto],
    scenes: Sequence[LabelledPhoto],
    settings: Settings,
    long: int,
    rng: np.random.Generator,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return (n, 3, h, w) float32 views and (n, h, w) int64 labels; one shape per batch."""
    short = round(long * 0.75 / 32) * 32
    size = [(short, long), (long, short), (short, short)][rng.choice(3, p=[0.65, 0.2, 0.15])]
    samples = []
    for _ in range(settings.batch):
        pool = scenes if scenes and rng.random() < settings.scene_share else photos
        samples.append(training_sample(pool, int(rng.integers(len(pool))), size, rng))
    images = torch.stack([to_tensor(image) for image, _ in samples])
    labels = torch.from_numpy(np.stack([labels for _, labels in samples]).astype(np.int64))
    return images.contiguous(memory_format=torch.channels_last), labels


def _scores_line(found: Scores) -> str:
    """Return scores as one line of text."""
    parts = [f"{name} {value:.3f}" for name, value in zip(LABELS, found.iou, strict=True)]
    return f"mean IoU {found.mean_iou:.4f} ({', '.join(parts)}), accuracy {found.accuracy:.4f}"


def train_start(
    model_path: str | Path, *, settings: Mapping[str, Any], seed: int, threads: int
) -> Scores:
    """Train on rooms of boxes alone and write the weights that training on photos starts from.

    Needs no data set. The scores are on a tenth of the rooms, which training did not see.
    """
    torch.set_num_threads(threads)
    chosen = Settings.of(settings)
    scenes = random_scenes(chosen.scenes, seed=seed)
    count = max(1, len(scenes) // 10)
    network, found, _ = train(
        scenes[count:],
        scenes[:count],
        chosen,
        seed=seed,
        steps=chosen.scene_steps,
        learning_rate=chosen.learning_rate,
        sides=(chosen.scene_side, chosen.small),
    )
    save_model_file(model_path, network.state_dict(), network.architecture, half=False)
    return found


def train_segmentation(
    data_root: str | Path,
    start_path: str | Path,
    model_path: str | Path,
    card_path: str | Path,
    *,
    settings: Mapping[str, Any],
    seed: int,
    threads: int,
) -> Scores:
    """Train on the train split of a synthetic data set, write weights and card; return scores.

    Starts from the weights of :func:`train_start`. The scores are those of the file as written
    (float16), on the val split.
    """
    torch.set_num_threads(threads)
    started = time.monotonic()
    chosen = Settings.of(settings)
    # Stored a little larger than views, so that zooming in shows more than blur.
    photos = read_labelled_photos(data_root, "train", long_side=round(chosen.long_side * 1.5))
    held_out = read_labelled_photos(data_root, "val", long_side=1024)
    every = max(1, len(held_out) // chosen.evaluate_photos)
    _log.info("%d photos to train on, %d held out", len(photos), len(held_out))
    scenes = random_scenes(chosen.scenes, seed=seed)
    network, _, step = train(
        photos,
        held_out[::every],
        chosen,
        seed=seed,
        steps=chosen.steps,
        learning_rate=chosen.photo_learning_rate,
        sides=(chosen.small, chosen.long_side),
        scenes=scenes,
        start=load_segmenter(start_path).network,
    )
    save_model_file(model_path, network.state_dict(), network.architecture)
    shipped = load_segmenter(model_path).network
    final = evaluate(shipped, held_out)
    counts = {"photos": len(photos), "held_out": len(held_out), "scenes": len(scenes)}
    card = model_card(
        shipped, final, chosen, counts, seed=seed, step=step, seconds=time.monotonic() - started
    )
    with atomic_path(card_path) as temporary:
        temporary.write_text(card, encoding="utf-8")
    return final


def model_card(
    network: SegmentationNet,
    found: Scores,
    settings: Settings,
    counts: Mapping[str, int],
    *,
    seed: int,
    step: int,
    seconds: float,
) -> str:
    """Return the model card as Markdown."""
    rows = "\n".join(f"| {n} | {v:.3f} |" for n, v in zip(LABELS, found.iou, strict=True))
    size = sum(p.numel() for p in network.parameters())
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else platform.machine()
    used = ", ".join(f"{f.name} {getattr(settings, f.name)}" for f in fields(settings))
    return f"""# segmentation

Labels every pixel of a room photo as other, floor, wall or ceiling; doors, windows, furniture,
rugs and pictures are other. `plan2scene.photos.segmentation.SegmentationNet`, {size / 1e6:.2f} M
parameters, float16; photos are scaled to {network.long_side} pixels on their longer side.

- Data: {counts["photos"]} rendered photos of the synthetic train split and {counts["scenes"]}
  drawn rooms of boxes (`training.segmentation_scenes`); no real photo.
- Held out: {counts["held_out"]} rendered photos of the val split (other houses).
- Command: `snakemake train_segmentation`
- Seed {seed}; {used}.
- {settings.scene_steps} steps on rooms of boxes alone (rule `segmentation_start`), then
  {settings.steps} with photos; the best of the validations was step {step} of these, which took
  {seconds / 60:.0f} minutes on {device}, {os.cpu_count()} cores, torch {torch.__version__}.

| label | IoU (held out) |
|---|---|
{rows}
| **mean** | **{found.mean_iou:.3f}** |

Pixel accuracy {found.accuracy:.3f}.
"""
