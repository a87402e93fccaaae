"""Errors of networks and of simpler predictors on hidden surfaces."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from plan2scene.colour import delta_e_2000, rgb_to_lab
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.graph_networks import Network
from plan2scene.propagation.predictors import RULES, predict
from plan2scene.propagation.type_means import TypeMeans
from plan2scene.seeds import generator
from plan2scene_workshop.propagation.light import Light, lit
from plan2scene_workshop.training.card import table

#: Share of rooms that are hidden, like the photos of the paper's column "Unobserved".
HIDDEN = 0.6
#: The predictor that others are compared with.
YARDSTICK = "room_type_mean"
#: Graph (`observed` marks its visible surfaces) -> embeddings (n, 3, 11) and confidence (n, 3).
Predictor = Callable[[HouseGraph], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class HiddenErrors:
    """Errors of one predictor over n hidden surfaces."""

    absolute: np.ndarray  #: (n, 11) float64, of the embedding
    colour: np.ndarray  #: (n,) float64, CIEDE2000 of the median colours
    confidence: np.ndarray  #: (n,) float64, NaN if the predictor gives none


def predictors(networks: Mapping[str, Network], means: TypeMeans) -> dict[str, Predictor]:
    """Return networks and the rules (which give no confidence) as predictors."""

    def by_network(network: Network, graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
        found = predict(network, graph)
        return found.embedding, found.confidence

    def by_rule(name: str, graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
        return RULES[name](graph, means), np.full(graph.observed.shape, np.nan)

    found: dict[str, Predictor] = {
        name: partial(by_network, network) for name, network in networks.items()
    }
    return found | {name: partial(by_rule, name) for name in RULES}


def hidden_errors(
    predictors: Mapping[str, Predictor],
    homes: Sequence[tuple[HouseGraph, np.ndarray]],
    seed: int,
) -> dict[str, HiddenErrors]:
    """Return the errors of predictors, all on the same hidden rooms.

    `homes` are pairs: a fully photographed house with embeddings from photos, and the true
    embeddings (n, 3, 11) of its surfaces.
    """
    rng = generator(seed, "hidden rooms")
    found: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in predictors}
    for graph, embeddings in homes:
        hidden = rng.random(len(graph.room_ids)) < HIDDEN
        if not hidden.any():
            continue
        kept = graph.observed & ~hidden[:, None]
        shown = replace(graph, observed=kept, embeddings=graph.embeddings * kept[..., None])
        truth = embeddings[hidden].reshape(-1, embeddings.shape[2])
        for name, run in predictors.items():
            values, confidence = run(shown)
            values = values[hidden].reshape(truth.shape)
            colour = delta_e_2000(_lab(values), _lab(truth))
            gap = np.abs(values - truth)
            found[name].append((gap, colour, confidence[hidden].ravel()))
    return {
        name: HiddenErrors(*(np.concatenate(column) for column in zip(*rows, strict=True)))
        for name, rows in found.items()
    }


def lit_homes(
    graphs: Sequence[HouseGraph], light: Light, seed: int, repeats: int = 3
) -> list[tuple[HouseGraph, np.ndarray]]:
    """Return pairs as `hidden_errors` takes them: each house `repeats` times, in random light."""
    rng = generator(seed, "held-out light")
    homes = []
    for graph in [*graphs] * repeats:
        told, truth = lit(graph, rng, light)
        homes.append((replace(graph, embeddings=told), truth))
    return homes


def _lab(embeddings: np.ndarray) -> np.ndarray:
    """Return CIELAB (n, 3) of the embeddings' median colours."""
    return rgb_to_lab(np.clip(embeddings[:, -3:], 0.0, 1.0))


def error_table(errors: Mapping[str, HiddenErrors]) -> str:
    """Return the errors, and their gains over `YARDSTICK`, as a Markdown table."""
    base = errors[YARDSTICK]
    head = ["predictor", "L1", "gain", "code (8)", "colour (3)", "dE2000", "gain", "median dE2000"]
    rows: dict[str, list[float | int | str]] = {
        name: [
            float(e.absolute.mean()),
            f"{1 - e.absolute.mean() / base.absolute.mean():.1%}",
            float(e.absolute[:, :8].mean()),
            float(e.absolute[:, 8:].mean()),
            f"{e.colour.mean():.2f}",
            f"{1 - e.colour.mean() / base.colour.mean():.1%}",
            f"{np.median(e.colour):.2f}",
        ]
        for name, e in errors.items()
    }
    return table(head, rows)


def confidence_table(errors: HiddenErrors) -> str:
    """Return a Markdown table of errors by confidence, to show how far it can be trusted."""
    rows: dict[str, list[float | int | str]] = {}
    for low, high in itertools.pairwise((0.0, 0.2, 0.4, 0.6, 0.8, 1.0)):
        mine = (errors.confidence >= low) & (errors.confidence < (high if high < 1 else 2))
        if mine.any():
            colour = errors.colour[mine]
            rows[f"{low:.1f}-{high:.1f}"] = [
                int(mine.sum()),
                float(errors.absolute[mine].mean()),
                f"{np.median(colour):.1f}",
                f"{(colour < 5).mean():.0%}",
            ]
    return table(["confidence", "surfaces", "L1", "median dE2000", "within 5"], rows)
