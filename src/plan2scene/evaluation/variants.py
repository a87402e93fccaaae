"""What each ablation changes: the crop that stands for a surface, the noise, the propagation."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np

from plan2scene.evaluation.houses import Models
from plan2scene.house import SURFACES, House, SurfaceKey
from plan2scene.propagation.graph import house_graph
from plan2scene.propagation.inference import read_propagation
from plan2scene.propagation.predict import predict
from plan2scene.propagation.prior import TypeMeans
from plan2scene.seeds import generator
from plan2scene.weights import load_model_file, save_model_file

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Variant:
    """One row of the ablation table.

    Attributes
    ----------
    name : str
    description : str
        For people.
    select : str
        Crop whose code an observed surface gets: ``textureness`` (the method's), ``random`` or
        ``mean`` (no crop, the mean embedding).
    crop_colour : bool
        The selected crop's own colour in place of the median over the surface's crops.
    propagate : str
        Embedding of an unobserved surface: ``graph`` (the method's), ``no_graph``,
        ``room_type_mean``, ``house_mean`` or ``nearest_room``.
    rgb : bool
        The unmodified network of RGB in place of the one of delta-HSV.
    plane_noise : bool
        The reference's noise, which does not tile, in place of that on a torus.
    seam_correction : bool
        Matters only for what does not tile by construction.
    """

    name: str
    description: str
    select: str = "textureness"
    crop_colour: bool = False
    propagate: str = "graph"
    rgb: bool = False
    plane_noise: bool = False
    seam_correction: bool = True


VARIANTS = (
    Variant("synth", "the whole method"),
    Variant("random_crop", "no textureness: a random crop of the surface", select="random"),
    Variant("crop_colour", "the selected crop's own colour, as in the paper", crop_colour=True),
    Variant("mean_embedding", "no selection: the mean of the crops' embeddings", select="mean"),
    Variant(
        "rgb",
        "RGB network in place of delta-HSV (NaiveSynth's, without substance head), the selected "
        "crop; unobserved: mean of the room type",
        rgb=True,
    ),
    Variant("plane_noise", "noise that does not tile, seams corrected", plane_noise=True),
    Variant(
        "no_seam_correction",
        "noise that does not tile, seams left",
        plane_noise=True,
        seam_correction=False,
    ),
    Variant("no_graph", "propagation without the doors between rooms", propagate="no_graph"),
    Variant("room_type_mean", "unobserved: mean of the room type", propagate="room_type_mean"),
    Variant("house_mean", "unobserved: mean of the house's surfaces", propagate="house_mean"),
    Variant("nearest_room", "unobserved: the nearest room's surface", propagate="nearest_room"),
)
#: Ablations of the paper that need weights of their own, and why there is no row.
MISSING = {
    "no_substance_head": "needs a texture network trained without the head, and a propagation "
    "network of its embeddings",
}


def selected(
    surfaces: pd.DataFrame,
    crops: pd.DataFrame,
    embeddings: pd.DataFrame,
    hidden_photos: Collection[str],
    variant: Variant,
    *,
    house: str,
    seed: int,
) -> pd.DataFrame:
    """Return ``surfaces.parquet`` with the crops that a variant selects.

    Parameters
    ----------
    surfaces, crops, embeddings : DataFrame
        Of the stages (docs/conventions.md), surfaces as the method selects.
    """
    own = ["embedding", "naive_embedding"]
    table = crops[["crop_id", "photo", "room_id", "surface", "metres"]].join(embeddings[own])
    table = table[~table["photo"].isin(set(hidden_photos))]
    groups = {key: group for key, group in table.groupby(["room_id", "surface"])}
    rows = []
    for row in surfaces.to_dict("records"):
        group = groups[row["room_id"], row["surface"]]
        if variant.select == "random":
            rng = generator(seed, house, row["room_id"], row["surface"], "ablation")
            chosen = group.iloc[int(rng.integers(len(group)))]
        else:
            chosen = group[group["crop_id"] == row["crop_id"]].iloc[0]
        if variant.select == "random":
            row["crop_id"] = chosen["crop_id"]
            row["embedding"] = np.concatenate([chosen["embedding"][:-3], row["embedding"][-3:]])
            if np.isfinite(chosen["metres"]):
                row["metres"] = float(chosen["metres"])
        if variant.crop_colour:
            row["embedding"] = np.asarray(chosen["embedding"], np.float32)
        if variant.select == "mean":
            row["embedding"] = _mean(group["embedding"])
            row["crop_id"] = f"mean of {len(group)} crops"
        if variant.rgb:
            row["naive_embedding"] = np.asarray(chosen["naive_embedding"], np.float32)
        rows.append(row)
    frame = surfaces.copy()
    for name in ("crop_id", "embedding", "naive_embedding", "metres"):
        values = [row[name] for row in rows]
        frame[name] = np.array(values) if name == "metres" else _objects(values, frame)
    return frame


def _objects(values: list[object], frame: pd.DataFrame) -> pd.Series:
    """Return values of any kind as a column of `frame`."""
    import pandas as pd

    return pd.Series(values, index=frame.index, dtype=object)


def _mean(embeddings: pd.Series) -> np.ndarray:
    """Return the mean of a column of embeddings, (d,) float32."""
    return np.stack([np.asarray(code, np.float32) for code in embeddings]).mean(axis=0)


def predicted(
    plan: House, propagated: pd.DataFrame, variant: Variant, models: Models
) -> pd.DataFrame:
    """Return ``propagated.parquet`` with unobserved surfaces as a variant predicts them."""
    if variant.propagate == "graph":
        return propagated
    network, means = read_propagation(models.propagation)
    seen = {
        SurfaceKey(row.room_id, row.surface): np.asarray(row.embedding, np.float32)
        for row in propagated.itertuples()
        if row.observed
    }
    predict_one: Callable[[SurfaceKey], np.ndarray]
    if variant.propagate == "no_graph":
        graph = house_graph(plan, seen)
        bare = replace(graph, edges=np.zeros((2, 0), dtype=np.int64))
        output = predict(network, bare).embedding

        def predict_one(key: SurfaceKey) -> np.ndarray:
            return np.asarray(
                output[graph.room_ids.index(key.room_id), SURFACES.index(key.surface)]
            )

    else:
        rule = {
            "room_type_mean": _room_type_mean,
            "house_mean": _house_mean,
            "nearest_room": _nearest_room,
        }[variant.propagate]

        def predict_one(key: SurfaceKey) -> np.ndarray:
            return rule(plan, key, seen, means)

    frame = propagated.copy()
    frame["embedding"] = [
        row.embedding if row.observed else predict_one(SurfaceKey(row.room_id, row.surface))
        for row in propagated.itertuples()
    ]
    return frame


_Seen = dict[SurfaceKey, np.ndarray]


def _room_type_mean(plan: House, key: SurfaceKey, seen: _Seen, means: TypeMeans) -> np.ndarray:
    """Return the mean of training surfaces of the room's types."""
    return means.predict(plan.room(key.room_id).types, key.surface)[0].astype(np.float32)


def _house_mean(plan: House, key: SurfaceKey, seen: _Seen, means: TypeMeans) -> np.ndarray:
    """Return the mean over the house's observed surfaces of that kind; without any, as above."""
    alike = [code for other, code in seen.items() if other.surface == key.surface]
    return np.mean(alike, axis=0) if alike else _room_type_mean(plan, key, seen, means)


def _nearest_room(plan: House, key: SurfaceKey, seen: _Seen, means: TypeMeans) -> np.ndarray:
    """Return the surface of that kind fewest doors away, the first in the plan of equals.

    Where doors lead to none, the mean of the house.
    """
    graph = nx.Graph(plan.adjacency())
    graph.add_nodes_from(room.id for room in plan.rooms)
    doors = nx.single_source_shortest_path_length(graph, key.room_id)
    reached = [
        (doors[room.id], i, seen[room.id, key.surface])  # type: ignore[index]
        for i, room in enumerate(plan.rooms)
        if room.id in doors and (room.id, key.surface) in seen
    ]
    if not reached:
        return _house_mean(plan, key, seen, means)
    return min(reached, key=lambda item: item[:2])[2]


def plane_noise_model(model: Path, output: Path) -> Path:
    """Write a texture model with the noise of the reference, which does not tile; return it."""
    state, architecture = load_model_file(model)
    save_model_file(output, state, architecture | {"periodic": False})
    return output
