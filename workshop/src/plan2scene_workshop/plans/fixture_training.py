"""Training of the network that finds the fixtures of baths and kitchens in a drawing of a room."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.nn import functional as F

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.seeds import derive_seed, generator
from plan2scene.weights import load_model_file, save_model_file
from plan2scene_app.tracing.settings import FIXTURE_LABELS, FIXTURE_PPM
from plan2scene_workshop.plans.drawing import DrawnPlan
from plan2scene_workshop.plans.fixtures import fixture_plan
from plan2scene_workshop.plans.paper import bend, homography, worn
from plan2scene_workshop.plans.settings import LabelTraining
from plan2scene_workshop.plans.training import fit_labels, ious
from plan2scene_workshop.training.card import Card, table, write_card

_WHAT = """
Labels every pixel of a drawn room as none, toilet, sink, bath, shower, stove or counter (a worktop
or vanity). `plan2scene.photos.labels.network.SegmentationNet`, {:.2f} M parameters, float16;
drawings are scaled to {:g} pixels per metre.
"""
_SEEN = (
    "Rooms of {} synthetic homes, drawn with fixtures and furniture (`plans/fixtures.py`); every "
    "view is turned, reduced and worn anew.",
    "No drawing of anybody else's, and no style of `style.HELD_OUT`.",
)
_FIGURES = """
Intersection over union on {} views of other homes in styles that were not trained on.

"""


@dataclass(frozen=True)
class FixtureSettings(LabelTraining):
    """Hyperparameters of the training."""

    drawings: int = 1200  #: number of homes, each drawn in one style
    wet_share: float = 0.8  #: share of views of a bath or kitchen
    side: int = 192  #: side of a view in pixels
    rare: float = 3.0  #: weight of fixtures in the loss, because they have few pixels
    widths: tuple[int, ...] = (12, 16, 32, 64, 96)  #: see :class:`SegmentationNet`
    decoder: int = 48
    held_out: int = 64  #: number of views of other homes in a validation
    figures: int = 160  #: number of views in held-out styles for the card's figures
    batch: int = 8
    steps: int = 3000
    evaluate_every: int = 500


def fixture_view(
    drawn: DrawnPlan, settings: FixtureSettings, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a view (side, side, 3) uint8 about a room, and its labels (side, side) uint8.

    It has about `FIXTURE_PPM` pixels per metre, but may be as blurred as a smaller picture.
    """
    wet = [{"Bathroom", "Kitchen"}.intersection(types) for types in drawn.plan.types]
    chosen = (
        [k for k, is_wet in enumerate(wet) if is_wet] if rng.random() < settings.wet_share else []
    )
    room = drawn.plan.rooms[int(rng.choice(chosen or len(wet)))]
    x0, z0, x1, z1 = room.bounds
    spare = np.maximum(
        0.6, np.array([x1 - x0, z1 - z0]) / 2 - settings.side / FIXTURE_PPM / 2 + 0.5
    )
    middle = np.array([x0 + x1, z0 + z1]) / 2 + rng.uniform(-spare, spare)
    x, y = (middle - drawn.origin) * drawn.ppm
    tilt = homography(drawn.labels.shape, rng, turn=float(rng.normal(0, 0.7)), keystone=0.0)
    zoom = FIXTURE_PPM / drawn.ppm * float(np.exp(rng.normal(0, 0.1)))
    turn = np.linalg.matrix_power(np.array([[0.0, -1], [1, 0]]), int(rng.integers(4))) * zoom
    turn[:, 0] *= rng.choice([-1, 1])
    move = np.eye(3)
    move[:2, :2] = turn
    move[:2, 2] = settings.side / 2 - turn @ (x, y)
    size = (settings.side, settings.side)
    edge = drawn.image[0, 0]
    beyond = (int(edge[0]), int(edge[1]), int(edge[2]))
    blurred = cv2.GaussianBlur(drawn.image, (0, 0), 0.5 / zoom) if zoom < 0.8 else drawn.image
    image, labels = bend(blurred, drawn.labels, move @ tilt, size, rng, beyond=beyond)
    seen_ppm = float(np.exp(rng.uniform(np.log(14), np.log(1.3 * FIXTURE_PPM))))
    if seen_ppm < FIXTURE_PPM:
        side = round(settings.side * seen_ppm / FIXTURE_PPM)
        small = cv2.resize(image, (side, side), interpolation=cv2.INTER_AREA)
        image = cv2.resize(
            worn(small, rng, photographed=False), size, interpolation=cv2.INTER_CUBIC
        )
        return image, labels
    return worn(image, rng, photographed=bool(rng.random() < 0.1)), labels


def _other_views(
    settings: FixtureSettings, count: int, seed: int, *, held_out: bool
) -> list[tuple[np.ndarray, np.ndarray]]:
    found = []
    for number in range(count):
        rng = generator(seed, "other fixtures", held_out, number)
        drawn = fixture_plan(number + 100_000, seed + 1, rng, held_out=held_out)
        found.append(fixture_view(drawn, settings, rng))
    return found


def _tensors(views: list[tuple[np.ndarray, np.ndarray]]) -> tuple[torch.Tensor, torch.Tensor]:
    images, labels = (np.stack(parts) for parts in zip(*views, strict=True))
    return torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255, torch.from_numpy(
        labels
    ).long()


@torch.no_grad()
def confusion(network: SegmentationNet, views: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return the confusion matrix of `FIXTURE_LABELS`: rows are true, columns found."""
    count = len(FIXTURE_LABELS)
    matrix = np.zeros((count, count), np.int64)
    device = next(network.parameters()).device
    for view in views:
        image, labels = _tensors([view])
        logits = F.interpolate(network(image.to(device)).float(), scale_factor=2, mode="bilinear")
        pairs = labels[0] * count + logits[0].argmax(0).cpu()
        matrix += np.bincount(pairs.numpy().ravel(), minlength=count * count).reshape(count, count)
    return matrix


def train_fixtures(
    model_path: str | Path,
    card_path: str | Path,
    *,
    settings: FixtureSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> float:
    """Train on drawings of synthetic rooms, write weights and card; return the mean IoU."""
    torch.manual_seed(derive_seed(seed, "fixtures", "weights"))
    network = SegmentationNet(
        widths=settings.widths,
        decoder=settings.decoder,
        long_side=settings.side,
        labels=len(FIXTURE_LABELS),
    )
    if settings.start:
        network.load_state_dict(load_model_file(settings.start)[0])

    @cache
    def drawing(number: int) -> DrawnPlan:
        rng = generator(seed, "fixtures", number)
        return fixture_plan(number, seed, rng, held_out=False)

    def draw(step: int) -> tuple[torch.Tensor, torch.Tensor]:
        rng = generator(seed, "fixture batch", step)
        numbers = rng.integers(settings.drawings, size=settings.batch)
        return _tensors([fixture_view(drawing(int(n)), settings, rng) for n in numbers])

    weights = torch.full((len(FIXTURE_LABELS),), settings.rare)
    weights[0] = 1.0
    views = _other_views(settings, settings.held_out, seed, held_out=False)
    trained = fit_labels(
        "fixtures",
        network,
        settings,
        draw,
        weights,
        lambda net: float(ious(confusion(net, views))[1:].mean()),
        seed=seed,
        checkpoint=checkpoint,
    )
    save_model_file(model_path, trained.network.state_dict(), trained.network.architecture)
    found = ious(
        confusion(trained.network, _other_views(settings, settings.figures, seed, held_out=True))
    )
    rows = {name: [float(value)] for name, value in zip(FIXTURE_LABELS, found, strict=True)}
    size = sum(parameter.numel() for parameter in trained.network.parameters()) / 1e6
    card = Card(
        "fixtures",
        _WHAT.format(size, FIXTURE_PPM),
        [line.format(settings.drawings) for line in _SEEN],
        settings,
        seed,
        _FIGURES.format(settings.figures) + table(["label", "IoU"], rows),
    )
    write_card(card_path, card, trained, model_path)
    return float(found[1:].mean())
