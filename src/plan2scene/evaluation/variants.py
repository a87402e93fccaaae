"""What each ablation changes: the crop that stands for a surface, the noise, the propagation."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.evaluation.houses import Models
from plan2scene.house import SURFACES, House, SurfaceKey
from plan2scene.propagation.graph import house_graph
from plan2scene.propagation.networks import load_propagation
from plan2scene.propagation.predictors import PREDICTORS
from plan2scene.seeds import generator
from plan2scene.weights import load_model_file, save_model_file

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Variant:
    """One row of the ablation table.

    Attributes
    ----------
    select : str
        Crop whose code an observed surface gets: ``textureness`` (the method's), ``random`` or
        ``mean`` (no crop, the mean embedding).
    crop_colour : bool
        The selected crop's own colour in place of the median over the surface's crops.
    propagate : str
        Embedding of an unobserved surface: ``graph`` (the method's), ``no_graph`` or one of
        ``propagation.predictors.PREDICTORS``.
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

    @property
    def method(self) -> str:
        """Return the method that decodes it."""
        return "naivesynth" if self.rgb else "synth"


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
    Variant("network", "unobserved: the network alone", propagate="network"),
    Variant("no_graph", "the network alone, without the doors", propagate="no_graph"),
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

    The tables are those of the stages (docs/conventions.md), surfaces as the method selects.
    """
    import pandas as pd

    own = ["embedding", "naive_embedding"]
    table = crops[["crop_id", "photo", "room_id", "surface", "metres"]].join(embeddings[own])
    table = table[~table["photo"].isin(set(hidden_photos))]
    groups = {key: group for key, group in table.groupby(["room_id", "surface"])}
    rows = surfaces.to_dict("records")
    for row in rows:
        group = groups[row["room_id"], row["surface"]]
        chosen = group[group["crop_id"] == row["crop_id"]].iloc[0]
        if variant.select == "random":
            rng = generator(seed, house, row["room_id"], row["surface"], "ablation")
            chosen = group.iloc[int(rng.integers(len(group)))]
            row["crop_id"] = chosen["crop_id"]
            row["embedding"] = np.concatenate([chosen["embedding"][:-3], row["embedding"][-3:]])
            if np.isfinite(chosen["metres"]):
                row["metres"] = float(chosen["metres"])
        if variant.crop_colour:
            row["embedding"] = np.asarray(chosen["embedding"], np.float32)
        if variant.select == "mean":
            row["embedding"] = np.stack(list(group["embedding"])).mean(axis=0, dtype=np.float32)
            row["crop_id"] = f"mean of {len(group)} crops"
        if variant.rgb:
            row["naive_embedding"] = np.asarray(chosen["naive_embedding"], np.float32)
    frame = surfaces.copy()
    for name in ("crop_id", "embedding", "naive_embedding", "metres"):
        values = [row[name] for row in rows]
        kind = float if name == "metres" else object
        frame[name] = pd.Series(values, index=frame.index, dtype=kind)
    return frame


def predicted(
    plan: House, propagated: pd.DataFrame, variant: Variant, models: Models
) -> pd.DataFrame:
    """Return ``propagated.parquet`` with unobserved surfaces as a variant predicts them."""
    if variant.propagate == "graph":
        return propagated
    network, means = load_propagation(models.propagation)
    seen = {
        SurfaceKey(row.room_id, row.surface): np.asarray(row.embedding, np.float32)
        for row in propagated.itertuples()
        if row.observed
    }
    graph = house_graph(plan, seen)
    if variant.propagate == "no_graph":
        cut = replace(graph, edges=graph.edges[:, :0])
        output = PREDICTORS["network"](cut, network, means, None).embedding
    else:
        output = PREDICTORS[variant.propagate](graph, network, means, None).embedding
    frame = propagated.copy()
    frame["embedding"] = [
        row.embedding
        if row.observed
        else output[graph.room_ids.index(row.room_id), SURFACES.index(row.surface)]
        for row in propagated.itertuples()
    ]
    return frame


def plane_noise_model(model: Path, output: Path) -> Path:
    """Write a texture model with the noise of the reference, which does not tile; return it."""
    state, architecture = load_model_file(model)
    save_model_file(output, state, architecture | {"periodic": False})
    return output
