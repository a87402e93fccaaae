"""The predictors of unseen surfaces: one registry for configuration, stage and docs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from plan2scene.colour import delta_e_2000, rgb_to_lab
from plan2scene.paint.light import expected_colours
from plan2scene.paint.observations import HouseColours
from plan2scene.propagation.evidence import PRIOR_SURFACES, house_evidence
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.model import Network
from plan2scene.propagation.predict import Prediction, predict
from plan2scene.propagation.prior import RULES, TypeMeans, room_type_mean

#: Odds of the house's evidence against the network before any surface was tried.
PRIOR_ODDS = 2.0
#: Sum of errors (CIEDE2000) that makes one e times likelier than the other.
ERROR_SCALE = 10.0
#: A house's graph, the network, the means of training surfaces and what is seen of all surfaces,
#: also of those that no crop shows (None: what the graph's surfaces tell) -> what is expected.
Predictor = Callable[[HouseGraph, Network, TypeMeans, HouseColours | None], Prediction]


def by_house(
    graph: HouseGraph, network: Network, means: TypeMeans, photo_colours: HouseColours | None = None
) -> Prediction:
    """Return the house's evidence, the network mixed in as far as it is right in this house.

    Each observed surface is predicted by both as if it were not seen; the sums of their errors
    in colour decide the weights (model averaging, Hoeting et al. 1999, DOI 10.1214/ss/1009212519).
    """
    known = photo_colours or HouseColours.of_embeddings(graph.embeddings, graph.observed)
    found, own = predict(network, graph), house_evidence(graph, means, known)
    share = network_share(graph, network, means, known)
    kinds = graph.observed.sum(axis=0) - graph.observed
    sure = np.where(np.isnan(found.confidence), 0.0, found.confidence)
    confidence = share * sure + (1.0 - share) * kinds / (kinds + PRIOR_SURFACES)
    embedding = (share * found.embedding + (1.0 - share) * own).astype(np.float32)
    usual = room_type_mean(graph, means)[..., -3:]
    return Prediction(
        embedding,
        confidence.astype(np.float32),
        nearest_rooms(graph, embedding),
        None if photo_colours is None else expected_colours(photo_colours, usual),
    )


def network_share(
    graph: HouseGraph, network: Network, means: TypeMeans, known: HouseColours
) -> float:
    """Return the weight of the network against the house's evidence, 0..1."""
    gap = np.log(PRIOR_ODDS)
    for place in zip(*np.nonzero(graph.observed), strict=True):
        kept = graph.observed.copy()
        kept[place] = False
        shown = replace(graph, observed=kept, embeddings=graph.embeddings * kept[..., None])
        true = graph.embeddings[place]
        gap += (
            _apart(predict(network, shown).embedding[place], true)
            - _apart(house_evidence(shown, means, known.without(place))[place], true)
        ) / ERROR_SCALE
    return float(1.0 / (1.0 + np.exp(np.clip(gap, -50.0, 50.0))))


def _apart(embedding: np.ndarray, other: np.ndarray) -> float:
    """Return the CIEDE2000 difference of the colours of two embeddings (11,)."""
    labs = [rgb_to_lab(np.clip(value[-3:], 0.0, 1.0)) for value in (embedding, other)]
    return float(delta_e_2000(*labs))


def nearest_rooms(graph: HouseGraph, embedding: np.ndarray) -> np.ndarray:
    """Return the row of the room whose observed surface is nearest (n, 3); -1 for none."""
    apart = np.abs(embedding[:, None] - graph.embeddings[None]).mean(axis=3)
    apart = np.where(graph.observed[None], apart, np.inf)
    apart[np.arange(len(apart)), np.arange(len(apart))] = np.inf
    return np.where(np.isfinite(apart).any(axis=1), apart.argmin(axis=1), -1)


def _by_network(
    graph: HouseGraph, network: Network, means: TypeMeans, photo_colours: HouseColours | None = None
) -> Prediction:
    return predict(network, graph)


def _by_rule(
    name: str,
    graph: HouseGraph,
    network: Network,
    means: TypeMeans,
    photo_colours: HouseColours | None = None,
) -> Prediction:
    embedding = RULES[name](graph, means)
    unknown = np.full(graph.observed.shape, np.nan, dtype=np.float32)
    return Prediction(embedding, unknown, nearest_rooms(graph, embedding))


#: By the name that the configuration has (`propagation.predictor`).
PREDICTORS: Mapping[str, Predictor] = {
    "house": by_house,
    "network": _by_network,
    **{name: partial(_by_rule, name) for name in RULES},
}
