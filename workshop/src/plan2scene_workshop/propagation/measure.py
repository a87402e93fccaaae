"""How well hidden surfaces are predicted, by networks and by simpler predictors."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.colour import delta_e_2000, rgb_to_lab
from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.model import network_of
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pairs import doors_between
from plan2scene.propagation.pointer import PointerNetwork
from plan2scene.propagation.predict import predict
from plan2scene.seeds import generator

#: Share of rooms hidden, as of photos in the paper's Unobserved column.
HIDDEN = 0.6
#: A graph whose `observed` says what is visible -> embeddings (n, 3, 11) and confidence (n, 3).
Predictor = Callable[[HouseGraph], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, eq=False)
class HiddenErrors:
    """Errors of one predictor over n hidden surfaces.

    Parameters
    ----------
    absolute : (n, 11) float64, of the embedding
    colour : (n,) float64, CIEDE2000 of the median colours
    surface : (n,) int64, index into ``SURFACES``
    confidence : (n,) float64, NaN where not told
    """

    absolute: np.ndarray
    colour: np.ndarray
    surface: np.ndarray
    confidence: np.ndarray


def network_predictor(network: PropagationNetwork | PointerNetwork) -> Predictor:
    """Return a network as a predictor."""
    weights = network_of(network)

    def run(graph: HouseGraph) -> tuple[np.ndarray, np.ndarray]:
        found = predict(weights, graph)
        return found.embedding, found.confidence

    return run


def simple_predictors(means: np.ndarray) -> dict[str, Predictor]:
    """Return the yardsticks, given means (12, 3, 11) by room and surface type.

    ``type_mean``: mean of room and surface type. ``house_mean``: mean of the visible surfaces of
    that kind. ``nearest_room``: the visible surface of that kind behind the fewest doors. The
    last two fall back on the first where the house shows no surface of the kind.
    """

    def type_mean(graph: HouseGraph) -> np.ndarray:
        shares = graph.types / np.maximum(graph.types.sum(axis=1, keepdims=True), 1.0)
        return np.einsum("nt,tsd->nsd", shares, means)

    def house_mean(graph: HouseGraph) -> np.ndarray:
        values = type_mean(graph)
        for j in range(len(SURFACES)):
            if graph.observed[:, j].any():
                values[:, j] = graph.embeddings[graph.observed[:, j], j].mean(axis=0)
        return values

    def nearest_room(graph: HouseGraph) -> np.ndarray:
        values = type_mean(graph)
        doors = doors_between(len(graph.room_ids), graph.edges)
        for j in range(len(SURFACES)):
            seen = np.flatnonzero(graph.observed[:, j])
            if len(seen):
                values[:, j] = graph.embeddings[seen[doors[:, seen].argmin(axis=1)], j]
        return values

    def untold(rule: Callable[[HouseGraph], np.ndarray]) -> Predictor:
        return lambda graph: (rule(graph), np.full(graph.observed.shape, np.nan))

    rules = {"type_mean": type_mean, "house_mean": house_mean, "nearest_room": nearest_room}
    return {name: untold(rule) for name, rule in rules.items()}


def hidden_errors(
    predictors: Mapping[str, Predictor], graphs: list[HouseGraph], seed: int, repeats: int = 3
) -> dict[str, HiddenErrors]:
    """Return the errors of predictors on the same hidden rooms of fully known houses."""
    rng = generator(seed, "hidden rooms")
    found: dict[str, list[tuple[np.ndarray, ...]]] = {name: [] for name in predictors}
    for graph in graphs * repeats:
        hidden = rng.random(len(graph.room_ids)) < HIDDEN
        if not hidden.any():
            continue
        kept = graph.observed & ~hidden[:, None]
        shown = replace(graph, observed=kept, embeddings=graph.embeddings * kept[..., None])
        truth = graph.embeddings[hidden].reshape(-1, graph.embeddings.shape[2])
        surface = np.tile(np.arange(len(SURFACES)), int(hidden.sum()))
        for name, run in predictors.items():
            values, confidence = run(shown)
            values = values[hidden].reshape(truth.shape)
            colour = delta_e_2000(_lab(values), _lab(truth))
            gap = np.abs(values - truth)
            found[name].append((gap, colour, surface, confidence[hidden].ravel()))
    return {
        name: HiddenErrors(*(np.concatenate(column) for column in zip(*rows, strict=True)))
        for name, rows in found.items()
    }


def _lab(embeddings: np.ndarray) -> np.ndarray:
    """Return CIELAB (n, 3) of the embeddings' median colours."""
    return rgb_to_lab(np.clip(embeddings[:, -3:], 0.0, 1.0))


def error_table(errors: Mapping[str, HiddenErrors]) -> str:
    """Return the errors as a Markdown table, gains over ``type_mean`` beside them."""
    base = errors["type_mean"]
    head = ["predictor", "L1", "gain", "code (8)", "colour (3)", "dE2000", "gain", "median dE2000"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name, e in errors.items():
        cells = (
            f"{e.absolute.mean():.4f}",
            f"{1 - e.absolute.mean() / base.absolute.mean():.1%}",
            f"{e.absolute[:, :8].mean():.4f}",
            f"{e.absolute[:, 8:].mean():.4f}",
            f"{e.colour.mean():.2f}",
            f"{1 - e.colour.mean() / base.colour.mean():.1%}",
            f"{np.median(e.colour):.2f}",
        )
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def confidence_table(errors: HiddenErrors) -> str:
    """Return a Markdown table of errors by confidence: what a confidence is worth."""
    lines = ["| confidence | surfaces | L1 | median dE2000 | within 5 |", "|---|---|---|---|---|"]
    edges = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
    for low, high in itertools.pairwise(edges):
        mine = (errors.confidence >= low) & (errors.confidence < (high if high < 1 else 2))
        if mine.any():
            colour = errors.colour[mine]
            lines.append(
                f"| {low:.1f}-{high:.1f} | {mine.sum()} | {errors.absolute[mine].mean():.3f} "
                f"| {np.median(colour):.1f} | {(colour < 5).mean():.0%} |"
            )
    return "\n".join(lines)
