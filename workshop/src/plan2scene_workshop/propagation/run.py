"""The training run of the propagation model: houses in, weights and a model card out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.graph_networks import Network, save_propagation
from plan2scene.propagation.type_means import TypeMeans, mean_by_type
from plan2scene.provenance import file_hash
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.texture_model import load_texture_model
from plan2scene_workshop.propagation.light import CORRECTED, PHOTOS
from plan2scene_workshop.propagation.measure import (
    HIDDEN,
    Predictor,
    confidence_table,
    error_table,
    hidden_errors,
    lit_homes,
    predictors,
)
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.propagation.training import train_network
from plan2scene_workshop.training.card import Card, write_card

#: Networks that the card compares with the trained one.
_ABLATIONS: Mapping[str, dict[str, Any]] = {
    "gated (the paper's)": {"network": "gated"},
    "pointer without doors": {"network": "pointer", "doors": False},
}
_WHAT = """
Embeddings of surfaces that no photo shows, from the room-door-room graph (paper section 5.4). Also
holds the mean embedding by room type and surface that NaiveSynth uses.
"""
_FIGURES = """
Held-out houses, {:.0%} of the rooms hidden: mean absolute error of the embedding and CIEDE2000 of
the median colours; gains over the mean of the room type.
"""
_HOMES = """
{}, {} surfaces:

{}
"""
_CONFIDENCE = """
What a confidence is worth (the last surfaces):

"""
#: The card's groups of held-out homes: whether they are plain, and their light.
_HELD_OUT = {
    "Varied homes, corrected light": (False, CORRECTED),
    "Varied homes, photos' light": (False, PHOTOS),
    "Plain homes, corrected light": (True, CORRECTED),
    "Plain homes, photos' light": (True, PHOTOS),
}
_LIMITS = """
It knows what the style model of the synthetic homes makes alike, and of real homes only how far
their light spreads.
"""


def train_propagation(
    houses: str | Path,
    texture_model: str | Path,
    naive_model: str | Path,
    output: str | Path,
    card: str | Path,
    *,
    settings: PropagationSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> None:
    """Train on the houses of ``write_training_houses``; write weights and card.

    The card compares the network with simpler predictors and with ablations that are trained the
    same way: the paper's network, and the network without doors. Training of the main network
    continues from `checkpoint` if it is of this run; ablations have no checkpoint.
    """
    with np.load(houses, allow_pickle=False) as file:
        data = {name: file[name] for name in file.files}
    crops = data["crops"].reshape(-1, *data["crops"].shape[2:])
    codes, naive = (
        embed_crops(load_texture_model(path), crops, textureness=False).codes
        for path in (texture_model, naive_model)
    )
    graphs = split_graphs(data["house"], data["types"], data["edges"], codes)
    count = max(1, round(len(graphs) * settings.held_out_share))
    held_out, graphs = graphs[:count], graphs[count:]
    first = np.unique(data["house"], return_index=True)[1]
    plain = data["plain"][first]
    rows = slice(sum(len(graph.room_ids) for graph in held_out) * len(SURFACES), None)
    types = np.repeat(data["types"], len(SURFACES), axis=0)[rows]
    surface = np.tile(np.arange(len(SURFACES)), len(data["types"]))[rows]
    means = TypeMeans(*(mean_by_type(types, surface, values[rows]) for values in (codes, naive)))
    data_seen = file_hash(houses), file_hash(texture_model)
    trained = train_network(graphs, held_out, settings, seed, checkpoint=checkpoint, run=data_seen)
    save_propagation(output, trained.network, means)
    networks: dict[str, Network] = {settings.network: trained.network}
    for name, change in _ABLATIONS.items():
        variant = replace(settings, **change)
        if variant != settings:
            networks[name] = train_network(graphs, held_out, variant, seed).network
    tried = predictors(networks, means)
    figures = _figures(tried, settings.network, held_out, plain[:count], seed)
    seen = [
        f"{len(graphs)} synthetic houses ({plain[count:].mean():.0%} plain), {count} more held "
        "out: plans, styles and crops of procedural materials, lit in training. No photo is "
        "rendered and no real house is in it.",
        f"Embeddings of the texture models {file_hash(texture_model)}, {file_hash(naive_model)}.",
    ]
    write_card(
        card, Card("propagation", _WHAT, seen, settings, seed, figures, _LIMITS), trained, output
    )


def _figures(
    tried: Mapping[str, Predictor],
    name: str,
    held_out: Sequence[HouseGraph],
    plain: np.ndarray,
    seed: int,
) -> str:
    """Return the card's figures of all predictors `tried`; `name` is the trained network's."""
    figures = _FIGURES.format(HIDDEN)
    for title, (is_plain, light) in _HELD_OUT.items():
        homes = [graph for graph, it in zip(held_out, plain, strict=True) if it == is_plain]
        if not homes:
            continue
        errors = hidden_errors(tried, lit_homes(homes, light, seed), seed)
        own = errors[name]
        figures += _HOMES.format(title, len(own.colour), error_table(errors))
    if not np.isnan(own.confidence).all():
        figures += _CONFIDENCE + confidence_table(own)
    return figures


def split_graphs(
    house: np.ndarray, types: np.ndarray, edges: np.ndarray, embeddings: np.ndarray
) -> list[HouseGraph]:
    """Return a fully observed graph of each house in the arrays of ``write_training_houses``.

    `embeddings` are (n * 3, 11) float32.
    """
    embeddings = embeddings.reshape(len(house), len(SURFACES), -1)
    graphs = []
    for k in np.unique(house):
        rows = np.flatnonzero(house == k)
        names = tuple(f"room_{i}" for i in range(len(rows)))
        mine = np.ascontiguousarray(edges[:, np.isin(edges[0], rows)] - rows[0])
        seen = np.ones((len(rows), len(SURFACES)), dtype=bool)
        graphs.append(HouseGraph(names, types[rows], mine, embeddings[rows], seen))
    return graphs
