"""The predictors of unobserved surfaces: one registry for configuration, stage and docs.

The rules without a network are the baselines of the networks. Predictor `house` is the default: on
real homes the same kind of surface elsewhere in the house is the best guess, because paint and
floors go through several rooms and the photos' light is already in them. If few or none are
observed, the mean of training surfaces of the room's type stands in, brought under the house's
light. Colours also follow the light of the surface's room
(:func:`plan2scene.paint.light.expected_colours`). The network's prediction is mixed in; its weight
depends on how well it predicts this house's observed surfaces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch
from torch import Tensor

from plan2scene.colour import delta_e_2000, rgb_to_lab
from plan2scene.house import OPEN_AIR, ROOM_TYPES, SURFACES
from plan2scene.paint.light import expected_colours
from plan2scene.paint.observations import HouseColours
from plan2scene.propagation.graph import HouseGraph, doors_between
from plan2scene.propagation.graph_networks import Mixture, Network, PointerNetwork, graph_data
from plan2scene.propagation.type_means import TypeMeans


@dataclass(frozen=True)
class PredictorSettings:
    """Weights of the predictors' evidence. Chosen on synthetic and real homes (development)."""

    #: Distance from the median, in scales of the mixture's distributions, from which on a component
    #: pulls no harder (:func:`robust_centre`).
    reach: float = 2.0
    prior_surfaces: float = 0.5  #: observed surfaces that the room type's mean counts as
    #: Prior odds of the house's evidence against the network.
    prior_odds: float = 2.0
    #: Difference of colour (CIEDE2000) that changes these odds, and a floor's vote, by a factor e.
    error_scale: float = 10.0
    # Votes for the floor that an unseen floor copies. Set by hand.
    other_use: float = 0.2  #: weight of a floor in a room of another use; of the same use: 1
    a_door: float = 0.5  #: factor on the weight for each door on the way to the floor's room


_S = PredictorSettings()
_COLOUR = 8  #: Index of the first of the embedding's three colour values


def room_type_mean(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the mean of training surfaces of the rooms' types."""
    return np.stack([means.predict(types)[0] for types in graph.types])


def house_mean(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the mean of the house's observed surfaces of the kind; if none, of the room's type."""
    values = room_type_mean(graph, means)
    for j in range(len(SURFACES)):
        if graph.observed[:, j].any():
            values[:, j] = graph.embeddings[graph.observed[:, j], j].mean(axis=0)
    return values


def nearest_room(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return the observed surface of the kind that is fewest doors away; of equals, the first.

    If doors lead to none, return the house's mean.
    """
    values = house_mean(graph, means)
    doors = doors_between(len(graph.room_ids), graph.edges)
    for j in range(len(SURFACES)):
        observed_rooms = np.flatnonzero(graph.observed[:, j])
        if len(observed_rooms):
            nearest = observed_rooms[doors[:, observed_rooms].argmin(axis=1)]
            led = np.isfinite(doors[np.arange(len(doors)), nearest])
            values[led, j] = graph.embeddings[nearest[led], j]
    return values


#: Rules by the name that tables show; each returns embeddings of all surfaces, (n, 3, 11) float32.
RULES: Mapping[str, Callable[[HouseGraph, TypeMeans], np.ndarray]] = {
    "room_type_mean": room_type_mean,
    "house_mean": house_mean,
    "nearest_room": nearest_room,
}


@dataclass(frozen=True, eq=False)
class Prediction:
    """A prediction for every surface of a house's n rooms."""

    embedding: np.ndarray  #: (n, 3, 11) float32, colours clipped to [0, 1]
    #: (n, 3) float32, probability that a photo shows a surface like it; NaN: unknown
    confidence: np.ndarray
    alike: np.ndarray  #: (n, 3) int64, row of the room whose surface it is most like; -1: none
    #: (n, 3, 3) float64, expected sRGB of each surface by all that photos show; None: not used
    seen: np.ndarray | None = None


@torch.inference_mode()
def predict(network: Network, graph: HouseGraph) -> Prediction:
    """Return a network's predictions for every surface, also for the observed ones."""
    if isinstance(network, PointerNetwork):
        centre, deviation = network.centre.numpy(), network.deviation.numpy()
        data = graph_data(graph.standardised(centre, deviation))
        mixture = network(data)
        components, weights = mixture_components(mixture, data.embeddings, data.pair_index)
        embedding = robust_centre(components, weights, _S.reach * mixture.copy_scale)
        embedding = embedding * network.deviation + network.centre
        confidence = 1.0 - mixture.log_own.exp()
        likeliest = weights.argmax(1)
        alike_rooms = likeliest.masked_fill(likeliest == len(graph.room_ids), -1)
    else:
        data = graph_data(graph)
        embedding = network(data.x, data.edge_index)
        confidence = torch.full((len(graph.room_ids), len(SURFACES)), torch.nan)
        alike_rooms = torch.full(confidence.shape, -1)
    embedding[..., _COLOUR:].clamp_(0.0, 1.0)
    return Prediction(embedding.numpy(), confidence.numpy(), alike_rooms.numpy())


def mixture_components(
    mixture: Mixture, values: Tensor, pair_index: Tensor
) -> tuple[Tensor, Tensor]:
    """Return a mixture's components (n, n + 1, 3, 11), each room's and `own`, and their weights.

    `values` (n, 3, 11) float32 are the standardised embeddings of the visible surfaces,
    `pair_index` (2, p) int64 of :func:`~plan2scene.propagation.graph_networks.room_pairs`. Weights
    (n, n + 1, 3) are zero for the room itself and for those without visible surface. All float32.
    """
    rooms = len(values)
    source, target = pair_index
    weights = values.new_zeros(rooms, rooms + 1, len(SURFACES))
    weights[target, source] = mixture.log_copies.exp()
    weights[:, rooms] = mixture.log_own.exp()
    room_values = values.expand(rooms, *values.shape)
    return torch.cat([room_values, mixture.own[:, None]], dim=1), weights


def robust_centre(values: Tensor, weights: Tensor, reach: Tensor) -> Tensor:
    """Return the weighted median over axis 1, moved towards the mean of the values near it.

    Surfaces of one material differ only by noise, and a mean has less noise than one value. A value
    farther than `reach` from the median pulls no harder than one at that distance (one step of
    Huber's estimator, DOI 10.1214/aoms/1177703732).

    `values` are (n, c, ..., d), `weights` (n, c, ...), `reach` is (..., d), the result (n, ..., d).
    """
    weights = weights[..., None]
    ordered, order = values.sort(dim=1, stable=True)
    reached = weights.expand_as(values).gather(1, order).cumsum(1) >= 0.5 * weights.sum(1, True)
    median = ordered.gather(1, reached.int().argmax(1, keepdim=True))
    pull = (values - median).clamp(-reach, reach)
    return median.squeeze(1) + (weights * pull).sum(1) / weights.sum(1)


def house_evidence(graph: HouseGraph, means: TypeMeans, photo_colours: HouseColours) -> np.ndarray:
    """Return embeddings of all surfaces, (n, 3, 11) float32, each as if it were not observed.

    Colours come from `photo_colours`, the rest from the graph's observed surfaces.
    """
    seen = graph.observed
    known = graph.embeddings.astype(np.float64)
    values = room_type_mean(graph, means).astype(np.float64)
    colours = expected_colours(photo_colours, values[..., -3:], as_if_unseen=True)
    for j in range(len(SURFACES)):
        others = (known[:, j] * seen[:, j, None]).sum(axis=0) - known[:, j] * seen[:, j, None]
        count = seen[:, j].sum() - seen[:, j]
        mixed = (others + _S.prior_surfaces * values[:, j]) / (count + _S.prior_surfaces)[:, None]
        values[:, j] = np.where(count[:, None] > 0, mixed, values[:, j])
    values[..., -3:] = colours
    return values.astype(np.float32)


#: A house's graph, the network, the means of training surfaces, and the colours that photos show of
#: surfaces, also of those without a crop (None: the colours of the graph's surfaces) -> prediction.
Predictor = Callable[[HouseGraph, Network, TypeMeans, HouseColours | None], Prediction]


def by_house(
    graph: HouseGraph, network: Network, means: TypeMeans, photo_colours: HouseColours | None = None
) -> Prediction:
    """Return the house's evidence, mixed with the network as far as that is right in this house.

    Both predict each observed surface as if it were not seen. The sums of their colour errors give
    the weights (model averaging, Hoeting et al. 1999, DOI 10.1214/ss/1009212519).
    """
    known = photo_colours or HouseColours.of_embeddings(graph.embeddings, graph.observed)
    network_says, house_says = predict(network, graph), house_evidence(graph, means, known)
    share = network_share(graph, network, means, known)
    kinds = graph.observed.sum(axis=0) - graph.observed
    sure = np.where(np.isnan(network_says.confidence), 0.0, network_says.confidence)
    confidence = share * sure + (1.0 - share) * kinds / (kinds + _S.prior_surfaces)
    embedding = share * network_says.embedding + (1.0 - share) * house_says
    embedding = embedding.astype(np.float32)
    usual = room_type_mean(graph, means)[..., -3:]
    seen_colours = None if photo_colours is None else expected_colours(photo_colours, usual)
    alike_rooms = nearest_rooms(graph, embedding)
    floor = SURFACES.index("floor")
    kin = kindred_floors(graph)
    like, rows = graph.embeddings[kin, floor], np.flatnonzero(kin >= 0)
    if seen_colours is not None:
        like[:, _COLOUR:] = seen_colours[kin, floor]
    embedding[rows, floor], alike_rooms[rows, floor] = like[rows], kin[rows]
    return Prediction(embedding, confidence.astype(np.float32), alike_rooms, seen_colours)


def kindred_floors(graph: HouseGraph) -> np.ndarray:
    """Return for each room the row (n,) of the room whose observed floor its floor copies, or -1.

    A house has few kinds of floor, and their mean is none of them, so one is chosen by votes: each
    other observed floor votes for the floors of its colour, with more weight if its room has the
    same use or is near. Bathrooms and open-air rooms copy only rooms of their own use.
    """
    floor = SURFACES.index("floor")
    uses = room_uses(graph)
    doors = doors_between(len(uses), graph.edges)
    doors[~np.isfinite(doors)] = len(uses)
    same = np.array([[not a.isdisjoint(b) for b in uses] for a in uses])
    apart = np.array([a.isdisjoint(_OF_THEIR_OWN) for a in uses])
    votes = np.where(same, 1.0, _S.other_use * (apart[:, None] & apart)) * _S.a_door**doors
    votes *= graph.observed[:, floor]
    np.fill_diagonal(votes, 0.0)
    labs = rgb_to_lab(np.clip(graph.embeddings[:, floor, _COLOUR:], 0.0, 1.0))
    gaps = delta_e_2000(labs[:, None], labs[None])
    scores = np.where(votes > 0.0, votes @ np.exp(-gaps / _S.error_scale), 0.0)
    return np.where(scores.max(axis=1) > 0.0, scores.argmax(axis=1), -1)


#: Use of a room by its type; all other types are for living.
_USES = {"Bedroom": "sleep", "Kitchen": "cook", "Bathroom": "wash"}
_USES |= dict.fromkeys(OPEN_AIR, "open air")
_OF_THEIR_OWN = {"wash", "open air"}


def room_uses(graph: HouseGraph) -> list[set[str]]:
    """Return the uses of each room; a closet has the uses of the rooms that it opens into."""
    named = [{_USES.get(ROOM_TYPES[t], "live") for t in np.flatnonzero(row)} for row in graph.types]
    closets = np.flatnonzero(graph.types[:, ROOM_TYPES.index("Closet")])
    source, target = graph.edges
    beside = {i: [named[j] for j in target[source == i] if j not in closets] for i in closets}
    for i, rooms in beside.items():
        named[i] = set().union(*rooms) - _OF_THEIR_OWN
    return [uses or {"live"} for uses in named]


def network_share(
    graph: HouseGraph, network: Network, means: TypeMeans, known: HouseColours
) -> float:
    """Return the network's weight, 0..1; the house's evidence has the rest."""
    gap = np.log(_S.prior_odds)
    for place in zip(*np.nonzero(graph.observed), strict=True):
        kept = graph.observed.copy()
        kept[place] = False
        reduced_graph = replace(graph, observed=kept, embeddings=graph.embeddings * kept[..., None])
        true = graph.embeddings[place]
        gap += (
            _apart(predict(network, reduced_graph).embedding[place], true)
            - _apart(house_evidence(reduced_graph, means, known.without(place))[place], true)
        ) / _S.error_scale
    return float(1.0 / (1.0 + np.exp(np.clip(gap, -50.0, 50.0))))


def _apart(embedding: np.ndarray, other: np.ndarray) -> float:
    """Return the CIEDE2000 difference of the colours of two embeddings (11,)."""
    labs = [rgb_to_lab(np.clip(value[-3:], 0.0, 1.0)) for value in (embedding, other)]
    return float(delta_e_2000(*labs))


def nearest_rooms(graph: HouseGraph, embedding: np.ndarray) -> np.ndarray:
    """Return the row (n, 3) of the room whose observed embedding is nearest to it; -1 for none."""
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


#: Predictors by their name in the configuration (`propagation.predictor`).
PREDICTORS: Mapping[str, Predictor] = {
    "house": by_house,
    "network": _by_network,
    **{name: partial(_by_rule, name) for name in RULES},
}
