"""Training of the plan network: views of drawings, the loss, the evaluation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional as F

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.seeds import generator
from plan2scene_app.tracing.settings import PLAN_LABELS, ROOM, WALL
from plan2scene_workshop.plans.paper import worn
from plan2scene_workshop.plans.settings import LabelTraining, PlanSettings
from plan2scene_workshop.plans.views import Drawings, draw_batch, other_drawing
from plan2scene_workshop.segmentation.training import Ahead, parameter_groups
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, best_device, cosine

#: Labels that are scored: outside, wall, door, window, passage, room of any kind.
STRUCTURE = PLAN_LABELS[: ROOM + 1]
_OTHER_PPM = 32.0


def other_views(count: int, seed: int, *, held_out: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return pictures and labels of :func:`.views.other_drawing`; a quarter are photographed."""
    found = []
    for number in range(count):
        drawn = other_drawing(number, seed, _OTHER_PPM, held_out=held_out)
        rng = generator(seed, "held out wear", number)
        image = worn(drawn.image, rng, photographed=number % 4 == 0)
        h, w = (v // 32 * 32 for v in drawn.labels.shape)
        found.append((image[:h, :w], drawn.labels[:h, :w]))
    return found


def structure_confusion(
    network: SegmentationNet, views: list[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, float]:
    """Return the confusion matrix (6, 6) of `STRUCTURE`, and the accuracy of the kinds of rooms.

    The accuracy is a share of the pixels of rooms of a known kind that are found as rooms.
    """
    count = len(STRUCTURE)
    matrix = np.zeros((count, count), np.int64)
    right = told = 0
    device = next(network.parameters()).device
    for image, labels in views:
        x = torch.from_numpy(image.copy()).permute(2, 0, 1)[None].float().to(device) / 255
        logits = F.interpolate(network(x).float(), scale_factor=2, mode="bilinear")
        found = logits[0].argmax(0).cpu().numpy()
        matrix += np.bincount(
            (np.minimum(labels, ROOM).astype(int) * count + np.minimum(found, ROOM)).ravel(),
            minlength=count * count,
        ).reshape(count, count)
        rooms = (labels > ROOM) & (found >= ROOM)
        right += int((labels == found)[rooms].sum())
        told += int(rooms.sum())
    return matrix, right / max(told, 1)


def ious(matrix: np.ndarray) -> np.ndarray:
    """Return intersection over union of each label of a confusion matrix."""
    hit = np.diag(matrix)
    return np.asarray(hit / np.maximum(1, matrix.sum(0) + matrix.sum(1) - hit))


def train_network(
    network: SegmentationNet,
    settings: PlanSettings,
    *,
    seed: int,
    checkpoint: Path | None = None,
) -> Trained[SegmentationNet]:
    """Train; return the averaged network with the best mean IoU on drawings of other homes."""
    drawings = Drawings(settings, seed)
    weights = torch.ones(len(PLAN_LABELS))
    weights[WALL:ROOM] = settings.thin
    views = other_views(settings.held_out, seed, held_out=False)
    return fit_labels(
        "plans",
        network,
        settings,
        lambda step: draw_batch(drawings, generator(seed, "plan batch", step)),
        weights,
        lambda net: float(ious(structure_confusion(net, views)[0]).mean()),
        seed=seed,
        checkpoint=checkpoint,
    )


def fit_labels(
    name: str,
    network: SegmentationNet,
    settings: LabelTraining,
    draw: Callable[[int], tuple[torch.Tensor, torch.Tensor]],
    weights: torch.Tensor,
    evaluate: Callable[[SegmentationNet], float],
    *,
    seed: int,
    checkpoint: Path | None,
) -> Trained[SegmentationNet]:
    """Train a network to label drawings; return the averaged one with the best evaluation.

    `draw` returns the images (n, 3, h, w) and labels (n, h, w) of a step, `weights` (labels,) are
    those of the labels in the loss.
    """
    device = best_device()
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    weights = weights.to(device)
    ahead = Ahead(draw, settings.steps, workers=8 if device == "cuda" else 1)

    def loss(step: int, _: np.random.Generator) -> dict[str, torch.Tensor]:
        images, labels = (part.to(device) for part in ahead.batch(step))
        logits = network(images.to(memory_format=torch.channels_last))
        # The loss is computed at the labels' resolution, because walls may be 3 pixels thin.
        logits = F.interpolate(logits.float(), size=labels.shape[1:], mode="bilinear")
        found = F.cross_entropy(logits, labels, weights, label_smoothing=settings.label_smoothing)
        return {"labels": found}

    options = TrainerOptions(
        name,
        seed,
        settings.steps,
        lambda step: cosine(step, settings.steps, rise=min(150, settings.steps // 10 + 1)),
        clip_norm=settings.clip_norm,
        average_decay=settings.ema_decay,
        evaluate_every=settings.evaluate_every,
        log_every=50,
        bfloat16=settings.bfloat16,
    )
    optimiser = torch.optim.AdamW(
        parameter_groups(network, settings.weight_decay), lr=settings.learning_rate
    )
    trainer = Trainer(network, loss, optimiser, options, evaluate=evaluate, run=settings)
    trainer.resume(checkpoint)
    return trainer.fit(checkpoint)
