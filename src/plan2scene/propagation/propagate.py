"""The propagation stage of one house: it predicts the embeddings of unobserved surfaces."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES, SURFACES, SurfaceKey
from plan2scene.io import read_parquet, write_parquet
from plan2scene.paint.observations import house_colours
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.graph import HouseGraph, house_graph
from plan2scene.propagation.substances import FLOORS_OF, usual_shares, weighed
from plan2scene.provenance import file_hash
from plan2scene.weights import fitting, read_model_arrays

if TYPE_CHECKING:
    from plan2scene.propagation.predictors import Prediction

#: Side of a tile in metres if no observed surface of the house has a known scale.
DEFAULT_METRES = 1.0
_COLUMNS = ["room_id", "surface", "observed", "embedding", "naive_embedding"]
_COLUMNS += ["substance", "metres", "source", "confidence", "material", "colour"]


def propagate_house(
    scene_json: str | Path,
    surfaces: str | Path,
    output: str | Path,
    *,
    house: str,
    dataset: str,
    propagation_model: str | Path,
    texture_model: str | Path,
    predictor: str,
    materials: str | Path | None = None,
    colours: str | Path | None = None,
    hidden_photos: Collection[str] = (),
) -> None:
    """Write ``propagated.parquet`` (docs/conventions.md): a row for every surface of the house.

    `predictor` is a name of :data:`plan2scene.propagation.predictors.PREDICTORS`. `materials`
    (``materials.parquet``) names the materials that surfaces share. `colours`
    (``colours.parquet``) has the colours that photos show of all surfaces, `hidden_photos` left
    out; without it the colours of observed surfaces come from their crops.
    """
    import pandas as pd

    # PyTorch Geometric takes seconds to import; code that only reads this stage's files is spared.
    from plan2scene.propagation.graph_networks import load_propagation
    from plan2scene.propagation.predictors import PREDICTORS

    plan = read_scene_json(scene_json, house)
    table, _ = read_parquet(surfaces)
    material = shared_materials(materials)
    network, means = load_propagation(propagation_model)
    observed = {SurfaceKey(row.room_id, row.surface): row for row in table.itertuples()}
    graph = house_graph(plan, {k: row.embedding for k, row in observed.items()})
    photo_colours = None
    if colours is not None:
        photo_colours = house_colours(colours, hidden_photos, graph.room_ids)
    predicted = PREDICTORS[predictor](graph, network, means, photo_colours)
    named = {graph.place(key): row.substance for key, row in observed.items()}
    types = [room.types for room in plan.rooms]
    substances = unseen_substances(graph, types, predicted, named, texture_model)
    in_photos = np.zeros(graph.observed.shape, dtype=bool)
    if photo_colours is not None and predicted.seen is not None:
        in_photos = photo_colours.photos > 0
    embeddings, colour = _all_surfaces(graph, predicted, in_photos)
    known = {key: float(row.metres) for key, row in observed.items()}
    rows: list[dict[str, Any]] = []
    for key in plan.surface_keys():
        place = graph.place(key)
        if key in observed:
            row = _observed_row(observed[key])
        else:
            _, naive = means.predict(graph.types[place[0]])
            row = _unobserved_row(graph, predicted, place, in_part=in_photos[place])
            row |= {"naive_embedding": naive[place[1]], "substance": substances[place]}
        row |= {"room_id": key.room_id, "surface": key.surface, "metres": _metres(known, key)}
        row |= {"embedding": embeddings[place], "colour": colour[place]}
        rows.append(row | {"material": material.get(key, "")})
    metadata = {"dataset": dataset, "house": house, "model": file_hash(propagation_model)}
    write_parquet(output, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def shared_materials(path: str | Path | None) -> dict[SurfaceKey, str]:
    """Return the material's name by surface from ``materials.parquet``; none without the file."""
    if path is None:
        return {}
    table, _ = read_parquet(path)
    return {SurfaceKey(row.room_id, row.surface): row.material for row in table.itertuples()}


def _all_surfaces(
    graph: HouseGraph, predicted: Prediction, in_photos: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return embeddings (n, 3, 11) and sRGB colours (n, 3, 3) of all surfaces, float32.

    Observed surfaces keep their embedding. A surface `in_photos` (n, 3) bool gets the colour that
    photos show; if it has no crop, this is also the colour in its embedding.
    """
    observed = graph.observed[..., None]
    embeddings = np.where(observed, graph.embeddings, predicted.embedding)
    colour = embeddings[..., -3:].copy()
    if predicted.seen is not None:
        colour = np.where(in_photos[..., None], predicted.seen, colour).astype(np.float32)
        embeddings[..., -3:] = np.where(observed, embeddings[..., -3:], colour)
    return embeddings, colour


def _unobserved_row(
    graph: HouseGraph, predicted: Prediction, place: tuple[int, int], *, in_part: bool
) -> dict[str, Any]:
    """Return the predicted values of a surface without a crop, except its embedding.

    `in_part`: photos show a part of it, enough for its colour only.
    """
    alike = int(predicted.alike[place])
    like = f", like {graph.room_ids[alike]}" if alike >= 0 else ""
    return {
        "observed": False,
        "source": f"propagated{like}{', its colour seen in part' if in_part else ''}",
        "confidence": float(predicted.confidence[place]),
    }


def _observed_row(row: Any) -> dict[str, Any]:
    """Return the values of a surface that a visible photo shows, a row of surfaces.parquet."""
    return {
        "observed": True,
        "naive_embedding": np.asarray(row.naive_embedding, dtype=np.float32),
        "substance": row.substance,
        "source": row.crop_id,
        "confidence": 1.0,
    }


def _metres(known: Mapping[SurfaceKey, float], key: SurfaceKey) -> float:
    """Return a surface's tile size in metres, else the median of its kind, else of the house."""
    if np.isfinite(known.get(key, np.nan)):
        return known[key]
    alike = [v for k, v in known.items() if k.surface == key.surface and np.isfinite(v)]
    metres = alike or [v for v in known.values() if np.isfinite(v)]
    return float(np.median(metres)) if metres else DEFAULT_METRES


def unseen_substances(
    graph: HouseGraph,
    types: Sequence[Collection[str]],
    predicted: Prediction,
    named: Mapping[tuple[int, int], str],
    texture_model: str | Path,
) -> np.ndarray:
    """Return the predicted substance (n, 3) of every surface, also of the observed ones.

    If a surface is predicted to be like an observed one, and both look like one substance, it
    takes the substance that the observed one's crops have (`named`). In a room with a type in
    `FLOORS_OF` (such as a bathroom) a floor takes it only from such rooms.
    """
    both = np.stack([predicted.embedding, graph.embeddings])
    likely, looks = substances_of(both, types, texture_model)
    has_own_floors = np.array([not FLOORS_OF.keys().isdisjoint(names) for names in types])
    for (row, kind), alike_room in np.ndenumerate(predicted.alike):
        if SURFACES[kind] == "floor" and has_own_floors[row] and not has_own_floors[alike_room]:
            continue
        if alike_room >= 0 and looks[alike_room, kind] == likely[row, kind]:
            likely[row, kind] = named.get((int(alike_room), kind), likely[row, kind])
    return likely


def substances_of(
    embeddings: np.ndarray, types: Sequence[Collection[str]], texture_model: str | Path
) -> np.ndarray:
    """Return the most probable substance (..., n, 3) of embeddings (..., n, 3, 11).

    The look is judged by the texture model's head, the prior depends on the `types` of the n rooms.
    The head is one linear layer: only its two arrays are read, not the whole network.
    """
    names = ("substance_layer.weight", "substance_layer.bias")
    arrays, _ = read_model_arrays(texture_model, names)
    if len(arrays) != len(names):
        raise InputError("a texture model with a substance head", "none", file=texture_model)
    weight, bias = (arrays[name] for name in names)
    with fitting("a substance head", texture_model):
        scores = embeddings[..., : weight.shape[1]] @ weight.T + bias
    shares = np.exp(scores - scores.max(axis=-1, keepdims=True))
    prior_shares = np.array([[usual_shares(kind, names) for kind in SURFACES] for names in types])
    shares = weighed(shares / shares.sum(axis=-1, keepdims=True), prior_shares)
    return np.array(SUBSTANCES)[shares.argmax(-1)]
