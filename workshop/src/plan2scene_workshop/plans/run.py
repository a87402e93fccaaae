"""The training run of the plan network: drawings of synthetic homes in, weights and a card out."""

from __future__ import annotations

from pathlib import Path

import torch

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.provenance import file_hash
from plan2scene.seeds import derive_seed
from plan2scene.weights import filled, load_model_file, save_model_file
from plan2scene_app.tracing.settings import MODEL, PLAN_LABELS
from plan2scene_workshop.plans.settings import PlanSettings
from plan2scene_workshop.plans.training import (
    STRUCTURE,
    ious,
    other_views,
    structure_confusion,
    train_network,
)
from plan2scene_workshop.training.card import Card, table, write_card

_WHAT = """
Labels every pixel of a picture of a floorplan as outside, wall, door, window, passage or room, and
rooms by what stands in them. `plan2scene.photos.labels.network.SegmentationNet`, {:.2f} M
parameters, float16; pictures are scaled to {} pixels on their longer side.
"""
_SEEN = (
    "Drawings of {} synthetic homes (`plans/drawing.py`), each in a style of its own; every view "
    "is turned, bent and worn anew.",
    "No drawing of anybody else's, and no style of `style.HELD_OUT`.",
)
_FIGURES = """
Intersection over union on {} drawings of other homes in styles that were not trained on; kind of
room: share of rooms' pixels.

"""


def _seen(settings: PlanSettings) -> list[str]:
    """Return the card's lines: the data that the network learned from, or has never seen."""
    lines = [line.format(settings.drawings) for line in _SEEN]
    if settings.start:
        start = settings.start
        lines.append(f"Weights of {Path(start).name} ({file_hash(start)}) to start.")
    return lines


def train_plans(
    model_path: str | Path,
    card_path: str | Path,
    *,
    settings: PlanSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> float:
    """Train on drawings of synthetic homes, write weights and card; return the mean IoU."""
    torch.manual_seed(derive_seed(seed, "plans", "weights"))
    network = SegmentationNet(long_side=settings.long_side, labels=len(PLAN_LABELS))
    if settings.start:
        network.load_state_dict(load_model_file(settings.start)[0])
    trained = train_network(network, settings, seed=seed, checkpoint=checkpoint)
    network = trained.network
    save_model_file(model_path, network.state_dict(), network.architecture)
    state, architecture = load_model_file(model_path)
    shipped = filled(lambda: SegmentationNet(**architecture), state, MODEL, model_path)
    with torch.no_grad():
        matrix, kinds = structure_confusion(
            shipped, other_views(settings.figures, seed, held_out=True)
        )
    found = ious(matrix)
    rows = {name: [float(value)] for name, value in zip(STRUCTURE, found, strict=True)}
    rows |= {"**mean**": [float(found.mean())], "kind of room": [kinds]}
    size = sum(parameter.numel() for parameter in shipped.parameters()) / 1e6
    card = Card(
        MODEL,
        _WHAT.format(size, settings.long_side),
        _seen(settings),
        settings,
        seed,
        _FIGURES.format(settings.figures) + table(["label", "IoU"], rows),
    )
    write_card(card_path, card, trained, model_path)
    return float(found.mean())
