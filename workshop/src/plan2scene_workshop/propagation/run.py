"""The training run of the propagation model: houses in, weights and a model card out."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from plan2scene.house import ROOM_TYPES, SURFACES
from plan2scene.io import atomic_path
from plan2scene.propagation.model import save_propagation
from plan2scene.propagation.prior import TypeMeans, mean_by_type
from plan2scene.provenance import file_hash
from plan2scene.textures.model.network import TextureModel, load_texture_model
from plan2scene_workshop.propagation.measure import (
    HIDDEN,
    HiddenErrors,
    confidence_table,
    error_table,
    hidden_errors,
    network_predictor,
    simple_predictors,
)
from plan2scene_workshop.propagation.training import (
    PropagationSettings,
    load_houses,
    split_graphs,
    train_network,
    type_means,
)

_LOG = logging.getLogger("plan2scene")

#: Networks that the card compares with the trained one.
_ABLATIONS: Mapping[str, dict[str, Any]] = {
    "gated (the paper's)": {"network": "gated"},
    "pointer without doors": {"network": "pointer", "doors": False},
}
_CONFIDENCE = """
What a confidence is worth (same surfaces):

"""
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
    """Train on the houses of ``write_training_houses``; write weights and card.

    The card compares the network with simpler predictors and with ablations trained alike: the
    paper's network, and the network without doors.
    """
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
    network = train_network(training, validation, settings)
    naive_means = mean_by_type(
        np.repeat(data["types"], len(SURFACES), axis=0),
        np.tile(np.arange(len(SURFACES)), len(crops)),
        naive,
    )
    save_propagation(output, network, TypeMeans(means, naive_means))
    predictors = {settings.network: network_predictor(network), **simple_predictors(means)}
    for name, change in _ABLATIONS.items():
        variant = replace(settings, **change)
        if variant != settings:
            predictors[name] = network_predictor(train_network(training, validation, variant))
    errors = hidden_errors(predictors, validation, settings.seed)
    text = _card(settings, len(training), held_out, errors, time.time() - start)
    text += f"\nEmbeddings of the texture model `{file_hash(texture_model)}`.\n"
    with atomic_path(card) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _card(
    settings: PropagationSettings,
    training: int,
    held_out: int,
    errors: dict[str, HiddenErrors],
    seconds: float,
) -> str:
    """Return the model card as Markdown."""
    own, surfaces = errors[settings.network], len(errors["type_mean"].colour)
    sure = "" if np.isnan(own.confidence).all() else _CONFIDENCE + confidence_table(own) + "\n"
    return f"""# propagation

Embeddings of surfaces that no photo shows, from the room-door-room graph (paper section 4.3):
network `{settings.network}` (`propagation/{settings.network if sure else "network"}.py`). Also
holds the mean embedding by room type ({len(ROOM_TYPES)}) and surface ({len(SURFACES)}) that
NaiveSynth uses.

- Data: {training} synthetic houses (plans, styles and lit crops of `synthetic/`, procedural
  materials only), {held_out} more held out. No photo is rendered and no real house is in it.
- Training: {settings.steps} steps of {settings.batch} graphs, AdamW {settings.learning_rate},
  weight decay {settings.weight_decay}, seed {settings.seed}; {settings.room_drop_share:.0%} of the
  samples hide whole rooms. {seconds / 60:.1f} minutes with {torch.get_num_threads()} threads
  (machine of {os.cpu_count()} cores), embedding and ablations included.
- Command: `snakemake -j2 train_propagation --configfile config/training.yaml`

Held-out houses, {HIDDEN:.0%} of the rooms hidden: mean absolute error of hidden surfaces and
CIEDE2000 of their median colours (n = {surfaces}); gains over the mean of the room type.

{error_table(errors)}
{sure}"""
