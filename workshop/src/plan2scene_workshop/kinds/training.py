"""Training of the classifier of rooms on photos of furnished synthetic homes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import numpy as np
import torch

from plan2scene.datasets.assignments import read_assignment
from plan2scene.images import read_image
from plan2scene.photos.labels.kinds import RoomKinds, kind_features
from plan2scene.photos.labels.palette import KINDS
from plan2scene.photos.labels.segmentation import Segmenter, load_segmenter
from plan2scene.photos.locate.which_room import KIND_OF
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.weights import save_model_file
from plan2scene_app.workflow.house_table import read_table
from plan2scene_workshop.training.card import Card, table, write_card
from plan2scene_workshop.training.loop import Trained

_WHAT = """
Tells what a photographed room is used for: a linear layer on the mean, maximum and deviation of the
encoders' channels of the shipped segmentation networks.
"""
_LIMITS = """
Rooms without their furniture are told by their floors and walls alone. It is one hint among several
(`plan2scene.photos.locate.which_room`).
"""


@dataclass(frozen=True)
class KindsSettings:
    """How the linear layer is fitted."""

    penalty: float = 1e-3  #: on squared weights (features: standardised, / sqrt of their number)
    steps: int = 200  #: largest number of L-BFGS steps
    rare: float = 5.0  #: added to each kind's count of photos before its weight is 1 / count


def photos_of_split(root: Path, split: str) -> Iterator[tuple[Path, tuple[str, ...]]]:
    """Yield each photo of a synthetic data set whose room has a known kind, with its kinds."""
    for row in read_table(root / "houses.tsv").of_splits([split]):
        house = read_scene_json(root / f"archs_no_objects/{split}/{row}.scene.json", row)
        types = {room.id: room.types for room in house.rooms}
        file = root / f"photo_assignments/{split}/{row}.photoroom.csv"
        for room_id, photo in read_assignment(file, house):
            kinds = tuple(KIND_OF[t] for t in types[room_id] if t in KIND_OF)
            if kinds:
                yield root / "photos" / photo, kinds


def features_of(
    photos: list[tuple[Path, tuple[str, ...]]], segmenter: Segmenter
) -> tuple[np.ndarray, np.ndarray]:
    """Return features (2 n, f) of photos and their mirror images, and shares of kinds (2 n, k)."""
    rows, kinds = [], []
    for path, names in photos:
        image = read_image(path)
        rows += [kind_features(segmenter, view) for view in (image, image[:, ::-1])]
        kinds += 2 * [[names.count(kind) / len(names) for kind in KINDS]]
    return np.array(rows, np.float32), np.array(kinds, np.float32)


def fit_kinds(features: np.ndarray, kinds: np.ndarray, settings: KindsSettings) -> RoomKinds:
    """Fit and return the classifier on features (n, f) and shares of kinds (n, k)."""
    inputs = features.shape[1]
    network = RoomKinds(inputs=inputs)
    network.mean.copy_(torch.from_numpy(features.mean(axis=0)))
    scale = 1 / ((features.std(axis=0) + 1e-3) * inputs**0.5)
    network.scale.copy_(torch.from_numpy(scale))
    torch.nn.init.zeros_(network.linear.weight)
    torch.nn.init.zeros_(network.linear.bias)
    x, target = torch.from_numpy(features), torch.from_numpy(kinds)
    weight = (target / (target.sum(dim=0) + settings.rare)).sum(dim=1)
    weight = weight / weight.mean()
    optimiser = torch.optim.LBFGS(
        network.linear.parameters(), max_iter=settings.steps, line_search_fn="strong_wolfe"
    )

    def loss() -> torch.Tensor:
        optimiser.zero_grad()
        entropy = -(target * torch.log_softmax(network(x), dim=1)).sum(dim=1)
        value = (weight * entropy).mean()
        value = value + settings.penalty * network.linear.weight.square().sum()
        value.backward()
        return value

    optimiser.step(loss)
    return network


def accuracy(network: RoomKinds, features: np.ndarray, kinds: np.ndarray) -> float:
    """Return the share of photos whose most probable kind is one of their true kinds."""
    with torch.inference_mode():
        best = network(torch.from_numpy(features)).argmax(dim=1).numpy()
    return float(np.mean(kinds[np.arange(len(best)), best] > 0))


def train_kinds(
    root: str | Path,
    segmentation: str | Path,
    model: str | Path,
    card: str | Path,
    *,
    settings: KindsSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> None:
    """Fit the classifier on a data set's train split, write its weights and card.

    `segmentation` is the weights file of the networks whose features it uses. The fit is not
    random: `seed` is only written on the card, and `checkpoint` is not used.
    """
    del checkpoint
    start, root = monotonic(), Path(root)
    segmenter = load_segmenter(segmentation)
    seen, held_out = (list(photos_of_split(root, split)) for split in ("train", "val"))
    features, kinds = features_of(seen, segmenter)
    network = fit_kinds(features, kinds, settings)
    save_model_file(model, network.state_dict(), network.architecture)
    right = accuracy(network, *features_of(held_out, segmenter)) if held_out else float("nan")
    counts = dict(zip(KINDS, kinds.sum(axis=0) / 2, strict=True))
    figures = table(["", "photos", "right"], {"held-out renderings": [len(held_out), right]})
    lines = [
        f"{len(seen)} renderings of furnished rooms: "
        + ", ".join(f"{kind} {count:.0f}" for kind, count in counts.items()),
        "No real photo.",
    ]
    trained = Trained(network, settings.steps, float("nan"), monotonic() - start)
    write_card(card, Card("kinds", _WHAT, lines, settings, seed, figures, _LIMITS), trained, model)
