"""Training of the segmentation network: its batches and its evaluation."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import nn

from plan2scene.camera import Camera
from plan2scene.photos.camera.calibration import estimate_camera
from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import IGNORE
from plan2scene.photos.labels.segmentation import (
    Network,
    Segmenter,
    elevation_map,
    labels_of,
    load_segmenter,
)
from plan2scene.seeds import generator
from plan2scene_workshop.segmentation.augment import Batch, training_batch
from plan2scene_workshop.segmentation.data import LabelledPhoto, Scores, confusion, digest, scores
from plan2scene_workshop.segmentation.losses import (
    GeometryHead,
    distillation_loss,
    geometry_loss,
    segmentation_loss,
)
from plan2scene_workshop.segmentation.mixing import mix_statistics
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, best_device, cosine

_Drawn = TypeVar("_Drawn")
#: Names of parameters that are not in the weights that training starts from.
_FRESH = re.compile("adapters|geometry")


def estimated_cameras(photos: Sequence[LabelledPhoto]) -> list[Camera | None]:
    """Return each photo's camera, estimated from its line segments; None if that fails."""
    found = [estimate_camera(photo.image) for photo in photos]
    return [None if camera.fallback else camera for camera in found]


def evaluate(
    network: SegmentationNet, photos: Sequence[LabelledPhoto], cameras: Sequence[Camera | None]
) -> Scores:
    """Return the scores of a network on whole photos with their estimated cameras."""
    return scores([matrix for matrix, _ in answers(network, photos, cameras)])


def answers(
    network: Network, photos: Sequence[LabelledPhoto], cameras: Sequence[Camera | None]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield each photo's confusion matrix and its logits of :meth:`Segmenter.logits`."""
    segmenter = Segmenter(copy.deepcopy(network).cpu())
    for photo, camera in zip(photos, cameras, strict=True):
        size = (photo.labels.shape[0], photo.labels.shape[1])
        logits = segmenter.logits(photo.image, camera)
        yield confusion(labels_of(logits, size, openings=True), photo.learned), logits


def train_network(
    network: SegmentationNet,
    photos: Sequence[LabelledPhoto],
    held_out: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    *,
    seed: int,
    checkpoint: Path | None = None,
) -> Trained[SegmentationNet]:
    """Train; return the averaged network with the best mean IoU on `held_out`.

    Training starts from the weights of `network`, or continues from a checkpoint of this run.
    """
    device = best_device()
    told = settings.geometry > 0 and any(photo.geometry is not None for photo in photos)
    whole = GeometryHead(network)
    whole.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    teachers = _teachers(settings, device)
    steps = min(settings.steps, settings.stop or settings.steps)

    def draw(step: int) -> Batch:
        long = settings.small if step < settings.steps * 2 / 3 else settings.long_side
        return draw_batch(photos, settings, long, generator(seed, "segmentation batch", step))

    ahead = Ahead(draw, steps, workers=8 if device == "cuda" else 1)

    def loss(step: int, _: np.random.Generator) -> dict[str, torch.Tensor]:
        return _losses(whole, ahead.batch(step).to(device), settings, teachers, told=told)

    options = TrainerOptions(
        "segmentation",
        seed,
        steps,
        lambda step: cosine(step, settings.steps, rise=min(300, settings.steps // 10 + 1)),
        clip_norm=settings.clip_norm,
        average_decay=settings.ema_decay,
        evaluate_every=settings.evaluate_every,
        bfloat16=settings.bfloat16,
    )
    optimiser = torch.optim.AdamW(
        parameter_groups(
            whole if told else network, settings.weight_decay, settings.fresh_learning_rate
        ),
        lr=settings.learning_rate,
    )
    cameras = estimated_cameras(held_out)
    trainer = Trainer(
        whole,
        loss,
        optimiser,
        options,
        evaluate=lambda whole: evaluate(whole.network, held_out, cameras).mean_iou,
        run=(settings, digest(photos)),
    )
    trainer.resume(checkpoint)
    mixing = mix_statistics(network, settings.mixing)
    trained = trainer.fit(checkpoint)
    for handle in mixing:
        handle.remove()
    return Trained(trained.network.network, trained.step, trained.score, trained.seconds)


def _teachers(settings: SegmentationSettings, device: str) -> list[Network]:
    """Return the teachers: networks that a run learns from in addition to the labels."""
    files = settings.teachers.split(":") if settings.teachers else []
    networks = [load_segmenter(file).network.to(device).requires_grad_(False) for file in files]
    return [network.to(memory_format=torch.channels_last) for network in networks]  # type: ignore[call-overload]


def _losses(
    whole: GeometryHead,
    batch: Batch,
    settings: SegmentationSettings,
    teachers: Sequence[Network],
    *,
    told: bool,
) -> dict[str, torch.Tensor]:
    """Return the parts of a batch's loss: labels, and teachers and geometry if there are any."""
    logits, geometry = whole(batch.images, batch.elevations)
    taught = batch.taught & bool(teachers)
    share = settings.distillation * taught.float().mean()
    parts = {"labels": _labels_loss(logits, batch, settings, ~taught) * (~taught).float().mean()}
    if teachers:
        own = _labels_loss(logits, batch, settings, taught)
        parts["labels"] += own * (taught.float().mean() - share)
        with torch.no_grad():
            answers = [teacher(batch.images, batch.elevations).float() for teacher in teachers]
        asked = batch.labels.where(taught.view(-1, 1, 1), IGNORE)
        mean = torch.stack(answers).mean(dim=0)
        parts["teachers"] = share * distillation_loss(logits.float(), mean, asked)
    if told:
        true, found = batch.geometry, logits.new_zeros(())
        if true is not None:
            found = settings.geometry * geometry_loss(geometry.float(), true[:, :3], true[:, 3])
        parts["geometry"] = found
    return parts


def _labels_loss(
    logits: torch.Tensor, batch: Batch, settings: SegmentationSettings, views: torch.Tensor
) -> torch.Tensor:
    """Return the loss of the labels of the views that `views` (n,) bool chooses."""
    if not views.any():
        return logits.new_zeros((), dtype=torch.float32)
    return segmentation_loss(
        logits[views].float(),
        batch.labels[views],
        settings.dice,
        settings.label_smoothing,
        batch.openings[views],
    )


class Ahead(Generic[_Drawn]):
    """Draws the batches of the next steps in other threads while the present step is computed.

    A batch depends only on its step, so threads and timing do not change it.
    """

    def __init__(self, draw: Callable[[int], _Drawn], steps: int, *, workers: int) -> None:
        self.draw, self.steps, self.depth = draw, steps, 2 * workers
        self.pool = ThreadPoolExecutor(workers)
        self.coming: dict[int, Future[_Drawn]] = {}

    def batch(self, step: int) -> _Drawn:
        """Return the batch of a step; asks for those after it."""
        for k in range(step, min(self.steps, step + self.depth + 1)):
            if k not in self.coming:
                self.coming[k] = self.pool.submit(self.draw, k)
        return self.coming.pop(step).result()


def take_statistics(
    network: SegmentationNet,
    photos: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    *,
    seed: int,
) -> None:
    """Compute the means and variances of batch norm anew, from views of three sizes.

    They are plain means over `settings.statistics` batches.
    """
    norms = [module for module in network.modules() if isinstance(module, nn.BatchNorm2d)]
    kept = [norm.momentum for norm in norms]
    device = str(next(network.parameters()).device)
    for norm in norms:
        norm.reset_running_stats()
        norm.momentum = None  # the plain mean
    sizes = (settings.small, settings.long_side, round(settings.long_side * 1.5))
    network.train()
    with torch.no_grad():
        for k in range(settings.statistics):
            rng = generator(seed, "segmentation statistics", k)
            batch = draw_batch(photos, settings, sizes[k % len(sizes)], rng).to(device)
            network(batch.images, batch.elevations)
    network.eval()
    for norm, momentum in zip(norms, kept, strict=True):
        norm.momentum = momentum


def parameter_groups(
    network: nn.Module, decay: float, fresh_rate: float | None = None
) -> list[dict[str, Any]]:
    """Return optimiser groups: no weight decay for norms and biases, `fresh_rate` for `_FRESH`."""
    trained = [(name, p) for name, p in network.named_parameters() if p.requires_grad]
    fresh = {name for name, _ in trained if fresh_rate and _FRESH.search(name)}
    groups = []
    for rate, own in (
        ({"lr": fresh_rate}, [p for name, p in trained if name in fresh]),
        ({}, [p for name, p in trained if name not in fresh]),
    ):
        groups.append({"params": [p for p in own if p.ndim > 1], "weight_decay": decay} | rate)
        groups.append({"params": [p for p in own if p.ndim <= 1], "weight_decay": 0.0} | rate)
    return [group for group in groups if group["params"]]


def draw_batch(
    photos: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    long: int,
    rng: np.random.Generator,
) -> Batch:
    """Return augmented views of photos drawn at random.

    A batch is landscape or portrait, with `long` pixels on the longer side, or square and smaller.
    """
    short = round(long * 0.75 / 32) * 32
    size = [(short, long), (long, short), (short, short)][rng.choice(3, p=[0.65, 0.2, 0.15])]
    chosen = [photos[index] for index in rng.integers(len(photos), size=settings.batch)]
    told = [told_elevation(photo, settings, rng) for photo in chosen]
    return training_batch(chosen, told, size, rng)


def told_elevation(
    photo: LabelledPhoto, settings: SegmentationSettings, rng: np.random.Generator
) -> np.ndarray:
    """Return the elevation map (h, w) float32 that the network gets with a photo, with noise.

    At random it is all NaN (unknown). At inference a camera has an error, and sometimes there is
    none, so the network must not trust the map too exactly.
    """
    size = (photo.labels.shape[0], photo.labels.shape[1])
    if photo.horizon is None or rng.random() >= settings.elevation_known:
        return np.full(size, np.nan, np.float32)
    wrong = 5.0 if rng.random() < 0.1 else 1.0
    noise = rng.normal(0, np.deg2rad(settings.elevation_noise_deg) * wrong, 3)
    up = np.array(photo.horizon.up) + noise
    focal = photo.horizon.focal * np.exp(rng.normal(0, 0.08 * wrong)) * size[1]
    return elevation_map(up / np.linalg.norm(up), float(focal), size, size)
