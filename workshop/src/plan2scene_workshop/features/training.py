"""Training of the embedded features network, which names the substance of degraded crops."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional

from plan2scene.house import SUBSTANCES
from plan2scene.metrics.networks import describe_images
from plan2scene.metrics.substance_network import SubstanceNetwork, load_substance_network
from plan2scene.provenance import file_hash
from plan2scene.seeds import derive_seed, generator
from plan2scene.weights import save_model_file
from plan2scene_workshop.texture.data import (
    TextureSet,
    draw_crops,
    read_materials,
    sampling_weights,
    seen_textures,
)
from plan2scene_workshop.texture.degradation import ROOM_PHOTO, photographed
from plan2scene_workshop.training.card import Card, table, write_card
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions, best_device, cosine

_WHAT = """
Substance classifier (wood, plaster, carpet, tile) of 128x128 texture crops. Its class is the SUBS
metric's, its 64 penultimate activations (standardised over training crops) are the FID features.
Figures made with it are named `embedded`; they are not comparable in size with SUBS by VGG-16 or
FID by InceptionV3.
"""
_SPOILED = """{:.0%} of the crops photographed: uneven light, shadows, highlights, white balance, \
blur, noise, JPEG."""
_FIGURES = """
Held-out accuracy, in all and by substance (all substances drawn equally often; a crop is a random
window, so a window may show no joint of its planks or tiles):

"""
_LIMITS = """
Four substances only; plain paint and plain carpet differ by little at a distance; glossy floors and
heavy shadow lower the accuracy.
"""


@dataclass(frozen=True)
class FeaturesSettings:
    """Hyperparameters of the features network's training."""

    # Sampling.
    batch: int = 32  #: number of crops in a step
    scanned_share: float = 0.4  #: share of crops from real textures, if there are any
    photographed_share: float = 0.75  #: share of crops that are degraded as in a photo of a room

    # Optimiser: AdamW; the rate rises linearly over 5 % of the steps, then falls by a cosine to 0.
    steps: int = 4000
    learning_rate: float = 3e-3  #: at the peak
    weight_decay: float = 1e-2
    label_smoothing: float = 0.05  #: a window may show no joint of its planks or tiles

    held_out_crops: int = 1000  #: crops of each held-out set for the card; also for `standardise`


def draw_photographed(
    textures: TextureSet,
    scanned_share: float,
    count: int,
    rng: np.random.Generator,
    photographed_share: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return crops (n, 128, 128, 3) uint8, some degraded like photos, and substances (n,) int64."""
    weights = sampling_weights(textures, scanned_share)
    crops, substances = draw_crops(textures, weights, count, rng, closest_px=96)
    return photographed(crops, rng, ROOM_PHOTO, photographed_share), substances


def train_network(
    textures: TextureSet,
    settings: FeaturesSettings,
    seed: int,
    *,
    device: str = "cpu",
    checkpoint: Path | None = None,
    run: object = None,
) -> Trained[SubstanceNetwork]:
    """Return the trained network; its features have no scale yet.

    Training continues from `checkpoint` if it is of this run; `run` identifies the textures.
    """
    torch.manual_seed(derive_seed(seed, "features weights"))
    network = SubstanceNetwork().to(device)

    def loss(step: int, rng: np.random.Generator) -> dict[str, torch.Tensor]:
        crops, substances = draw_photographed(
            textures, settings.scanned_share, settings.batch, rng, settings.photographed_share
        )
        _, logits = network(_as_tensor(crops).to(device))
        labels = torch.from_numpy(substances).to(device)
        smoothing = settings.label_smoothing
        return {"entropy": functional.cross_entropy(logits, labels, label_smoothing=smoothing)}

    steps = settings.steps
    options = TrainerOptions(
        "features",
        seed,
        steps,
        lambda step: cosine(step, steps, rise=round(0.05 * steps), floor=0.0),
    )
    optimiser = torch.optim.AdamW(
        network.parameters(), settings.learning_rate, weight_decay=settings.weight_decay
    )
    trainer = Trainer(network, loss, optimiser, options, run=(settings, run))
    trainer.resume(checkpoint)
    return trainer.fit(checkpoint)


def _as_tensor(images: np.ndarray) -> torch.Tensor:
    """Return (n, h, w, 3) uint8 sRGB images as (n, 3, h, w) float32 in [0, 1]."""
    return torch.from_numpy(np.ascontiguousarray(np.moveaxis(images, -1, 1))).float() / 255.0


def standardise(network: SubstanceNetwork, crops: np.ndarray) -> None:
    """Set the features' shift and scale to the mean and spread over `crops` (n, 128, 128, 3)."""
    network.eval()
    with torch.inference_mode():
        parts = np.array_split(crops, max(1, len(crops) // 64))
        hidden = torch.cat([network.hidden(_as_tensor(part)) for part in parts])
    # Division by the tiny spread of a feature that (almost) never fires would make it huge.
    spread = hidden.std(dim=0)
    network.shift.copy_(hidden.mean(dim=0))
    network.scale.copy_(torch.maximum(spread, 0.1 * spread.mean()))


def confusion(
    network: SubstanceNetwork, textures: TextureSet, count: int, seed: int, degraded: bool
) -> np.ndarray:
    """Return the (4, 4) counts of true (row) against predicted substance over `count` crops."""
    rng = generator(seed, "features held out", degraded)
    scanned = float(textures.scanned.all())
    crops, substances = draw_photographed(textures, scanned, count, rng, float(degraded))
    _, predicted = describe_images(network, list(crops))
    size = len(SUBSTANCES)
    return np.bincount(substances * size + predicted, minlength=size * size).reshape(size, size)


def train_features(
    materials: str | Path,
    model: str | Path,
    card: str | Path,
    *,
    settings: FeaturesSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> dict[str, float]:
    """Train the network, write its weights and card; return held-out accuracies by set.

    `materials` is a file of :func:`plan2scene_workshop.texture.data.write_materials`. Training
    continues from `checkpoint` if it is of this run.
    """
    textures, held_out = read_materials(materials)
    trained = train_network(
        textures,
        settings,
        seed,
        device=best_device(),
        checkpoint=checkpoint,
        run=file_hash(materials),
    )
    network, count = trained.network.cpu(), settings.held_out_crops
    rng, share = generator(seed, "features scale"), settings.photographed_share
    crops, _ = draw_photographed(textures, settings.scanned_share, count, rng, share)
    standardise(network, crops)
    save_model_file(model, network.state_dict(), network.architecture)
    shipped = load_substance_network(model)  # what the metrics run: weights of float16
    counts = {
        f"{name} textures, {'photographed' if degraded else 'clean'}": confusion(
            shipped, group, count, seed, degraded
        )
        for name, group in held_out.items()
        for degraded in (False, True)
    }
    accuracies = {name: float(np.trace(found) / found.sum()) for name, found in counts.items()}
    rows = {name: [count, accuracies[name], *_recalls(found)] for name, found in counts.items()}
    figures = _FIGURES + table(["crops", "n", "accuracy", *SUBSTANCES], rows)
    seen = [*seen_textures(textures), _SPOILED.format(share)]
    about = Card("features", _WHAT, seen, settings, seed, figures, _LIMITS)
    write_card(card, about, trained, model)
    return accuracies


def _recalls(counts: np.ndarray) -> list[float]:
    """Return the recall of each true substance (row)."""
    return (counts.diagonal() / np.maximum(counts.sum(axis=1), 1)).tolist()
