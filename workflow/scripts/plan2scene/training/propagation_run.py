"""The training run of the propagation model: houses in, weights and a model card out."""

from __future__ import annotations

import logging
import os
import time
from pathlib import Path

import numpy as np
import torch

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.io import atomic_path
from plan2scene.propagation.model import save_propagation
from plan2scene.propagation.prior import TypeMeans, mean_by_type
from plan2scene.provenance import file_hash
from plan2scene.textures.model import TextureModel, load_texture_model
from plan2scene.training.propagation import (
    PropagationSettings,
    hidden_errors,
    load_houses,
    split_graphs,
    train_network,
    type_means,
)

_LOG = logging.getLogger("plan2scene")

#: Share of the synthetic houses held out for choosing the checkpoint and for the card.
VALIDATION_SHARE = 0.15


def embed_all(model: TextureModel, crops: np.ndarray, batch: int = 64) -> np.ndarray:
    """Return embeddings (n, d) float32 of crops (n, 128, 128, 3) uint8."""
    parts = []
    with torch.no_grad():
        for start in range(0, len(crops), batch):
            rgb = torch.from_numpy(crops[start : start + batch]).permute(0, 3, 1, 2).float() / 255
            parts.append(model.encode(rgb).embedding.numpy())
            if start // batch % 50 == 0:
                _LOG.info("embedded %d of %d crops", start, len(crops))
    return np.concatenate(parts).astype(np.float32)


def train_propagation(
    houses: str | Path,
    texture_model: str | Path,
    naive_model: str | Path,
    output: str | Path,
    card: str | Path,
    *,
    settings: PropagationSettings,
) -> None:
    """Train on the houses of ``write_training_houses``; write weights and card."""
    start = time.time()
    data = load_houses(houses)
    crops = data["crops"]
    flat = crops.reshape(-1, *crops.shape[2:])
    embeddings = embed_all(load_texture_model(texture_model), flat)
    naive = embed_all(load_texture_model(naive_model), flat)
    shape = (len(crops), len(SURFACES), -1)
    graphs = split_graphs(data["house"], data["types"], data["edges"], embeddings.reshape(shape))
    held_out = max(1, round(len(graphs) * VALIDATION_SHARE))
    training, validation = graphs[held_out:], graphs[:held_out]
    means = type_means(training)
    network, _ = train_network(training, validation, settings)
    errors = hidden_errors(network, validation, settings, means)
    naive_means = mean_by_type(
        np.repeat(data["types"], len(SURFACES), axis=0),
        np.tile(np.arange(len(SURFACES)), len(crops)),
        naive,
    )
    architecture = {"width": 96, "layers": 3}
    save_propagation(output, network, TypeMeans(means, naive_means), **architecture)
    text = _card(settings, len(training), held_out, errors, time.time() - start)
    text += f"\nEmbeddings of the texture model `{file_hash(texture_model)}`.\n"
    with atomic_path(card) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _card(
    settings: PropagationSettings,
    training: int,
    held_out: int,
    errors: dict[str, np.ndarray],
    seconds: float,
) -> str:
    """Return the model card as Markdown."""
    network, prior = errors["network"].mean(), errors["type_mean"].mean()
    rows = "\n".join(
        f"| {name} | {e.mean():.4f} | {e[:, :8].mean():.4f} | {e[:, 8:].mean():.4f} |"
        for name, e in errors.items()
    )
    return f"""# propagation

Gated graph network of the paper (section 4.3): embeddings of surfaces that no photo shows, from
the room-door-room graph. Also holds the mean embedding by room type ({len(ROOM_TYPES)}) and
surface ({len(SURFACES)}) that NaiveSynth uses.

- Data: {training} synthetic houses (plans, styles and lit crops of `synthetic/`, procedural
  materials only), {held_out} more held out. No photo is rendered and no real house is in it.
- Training: {settings.steps} steps of {settings.batch} graphs, Adam {settings.learning_rate},
  weight decay {settings.weight_decay}, seed {settings.seed}; {settings.room_drop_share:.0%} of the
  samples hide whole rooms. {seconds / 60:.1f} minutes with {torch.get_num_threads()} threads
  (machine of {os.cpu_count()} cores), embedding included.
- Command: `snakemake -j2 train_propagation --configfile config/training.yaml`

Held-out houses, 60 % of the rooms hidden, mean absolute error of hidden surfaces
(n = {len(errors["network"])}):

| predictor | all 11 | code (8) | median colour (3) |
|---|---|---|---|
{rows}

The network's L1 is {1 - network / prior:.1%} below the mean of the room type's.
"""
