"""Ablations of method synth: a second table, which shows what each of its parts contributes.

A variant changes the crop that stands for a surface, the noise, or the propagation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.evaluation.measure import write_measured
from plan2scene.evaluation.measurements import Measurements
from plan2scene.evaluation.references import reference_images
from plan2scene.evaluation.tables import (
    TableRequest,
    latex_table,
    metric_title,
    tidy_table,
    wide_table,
)
from plan2scene.house import House, SurfaceKey
from plan2scene.io import read_parquet, write_csv, write_parquet, write_text
from plan2scene.metrics.registry import METRICS
from plan2scene.propagation.graph import house_graph
from plan2scene.propagation.graph_networks import load_propagation
from plan2scene.propagation.predictors import PREDICTORS
from plan2scene.seeds import generator
from plan2scene.textures.inputs import HouseData, Visible
from plan2scene.weights import load_model_file, save_model_file
from plan2scene_app.study.evaluated_house import EvaluatedHouse, Models, measured_at

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Variant:
    """One row of the ablation table."""

    name: str
    description: str
    #: how an observed surface's code is chosen from its crops: textureness, random, mean (of all)
    select: str = "textureness"
    #: use the selected crop's colour, not the median over the surface's crops
    crop_colour: bool = False
    #: embedding of unobserved surfaces: graph, no_graph or one of PREDICTORS
    propagate: str = "graph"
    rgb: bool = False  #: use the unmodified RGB network, not that of delta-HSV
    #: use the reference's noise, which does not tile, not the noise on a torus
    plane_noise: bool = False
    seam_correction: bool = True  #: no effect on tiles that repeat by construction

    @property
    def method(self) -> str:
        """Return the texture method that decodes its embeddings."""
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
#: Ablations of the paper without a row, because they need other weights, and the reason.
MISSING = {
    "no_substance_head": "needs a texture network trained without the head, and a propagation "
    "network of its embeddings"
}


def selected(
    surfaces: pd.DataFrame, crops: pd.DataFrame, variant: Variant, *, house: str, seed: int
) -> pd.DataFrame:
    """Return ``surfaces.parquet`` with the crops that a variant selects.

    `surfaces` is the table with the method's own selection, `crops` the visible crops with their
    embeddings.
    """
    import pandas as pd

    groups = {key: group for key, group in crops.groupby(["room_id", "surface"])}
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
    """Return ``propagated.parquet`` with the embeddings that a variant predicts."""
    if variant.propagate == "graph":
        return propagated
    network, means = load_propagation(models.propagation)
    observed_embeddings = {
        SurfaceKey(row.room_id, row.surface): np.asarray(row.embedding, np.float32)
        for row in propagated.itertuples()
        if row.observed
    }
    graph = house_graph(plan, observed_embeddings)
    name = variant.propagate
    if name == "no_graph":
        name, graph = "network", replace(graph, edges=graph.edges[:, :0])
    output = PREDICTORS[name](graph, network, means, None).embedding
    frame = propagated.copy()
    frame["embedding"] = [
        row.embedding if row.observed else output[graph.place(SurfaceKey(row.room_id, row.surface))]
        for row in propagated.itertuples()
    ]
    return frame


def ablate_house(
    house: EvaluatedHouse,
    embeddings: Path,
    output: str | Path,
    *,
    hidden: Mapping[str, Sequence[str]],
) -> None:
    """Write a house's ``ablation.parquet``: ``metrics.parquet`` with variants as methods.

    `hidden` maps a drop fraction to the photos hidden at it.
    """
    data, house_id = HouseData(house.files), house.files.house_id
    codes = read_parquet(embeddings)[0][["embedding", "naive_embedding"]]
    crops = data.crops[["crop_id", "photo", "room_id", "surface", "metres"]].join(codes)
    frames = []
    for drop, photos in hidden.items():
        references = reference_images(data.crops, photos)
        visible = crops[~crops["photo"].isin(set(photos))]
        with TemporaryDirectory() as name:
            folder = Path(name)
            surfaces = house.select(embeddings, photos, folder / "surfaces.parquet")
            for variant in VARIANTS:
                variant_surfaces = folder / f"{variant.name}_surfaces.parquet"
                propagated = folder / f"{variant.name}_propagated.parquet"
                # A variant's propagation starts from the crops that the variant selects.
                chosen = selected(
                    surfaces, visible, variant, house=house_id, seed=house.settings.seed
                )
                write_parquet(variant_surfaces, chosen, {"house": house_id})
                house.propagate(variant_surfaces, photos, propagated)
                frame, metadata = read_parquet(propagated)
                write_parquet(
                    propagated, predicted(data.house, frame, variant, house.models), metadata
                )
                rows = measured_at(
                    _variant_of(house, variant, folder),
                    data,
                    Visible(propagated, photos),
                    [variant.method],
                    references,
                    drop=drop,
                )
                frames += [frame.assign(method=variant.name) for frame in rows]
    write_measured(output, frames, house.metadata)


def _variant_of(house: EvaluatedHouse, variant: Variant, folder: Path) -> EvaluatedHouse:
    """Return the house with a variant's noise and seam correction."""
    settings = replace(house.settings, seam_correction={variant.method: variant.seam_correction})
    if not variant.plane_noise:
        return replace(house, settings=settings)
    plane = folder / "plane_noise.safetensors"
    state, architecture = load_model_file(house.models.texture)
    save_model_file(plane, state, architecture | {"periodic": False})
    return replace(house, settings=settings, models=replace(house.models, texture=plane))


def ablation_table(
    ablations: Iterable[str | Path],
    references: Iterable[str | Path],
    output_csv: str | Path,
    output_markdown: str | Path,
    output_latex: str | Path,
    *,
    dataset: str,
    houses: Sequence[str],
    drop: str,
    seed: int,
) -> None:
    """Write the ablations over all houses as CSV, Markdown and LaTeX.

    Observed surfaces are measured at drop 0.0, unobserved and all at `drop`, as in the paper's
    table 1. Ablations that need other weights are only named in the Markdown and LaTeX.
    """
    request = TableRequest(dataset, houses, [variant.name for variant in VARIANTS], drop, seed)
    tidy = tidy_table(Measurements(ablations, references), request)
    wide = wide_table(tidy).rename(columns={"method": "variant"})
    described = {variant.name: variant.description for variant in VARIANTS}
    wide.insert(1, "description", wide["variant"].map(described))
    write_csv(output_csv, wide)
    missing = [f"{name}: not measured, {why}" for name, why in MISSING.items()]
    networks = dict(zip(tidy["metric"], tidy["features"], strict=True))
    titles = [metric_title(name, networks[name]) for name in METRICS]
    write_text(output_markdown, _markdown(wide, titles))
    write_text(output_latex, latex_table(tidy, missing))


def _markdown(wide: pd.DataFrame, metrics: Sequence[str]) -> str:
    """Return the table, with three decimals, and the missing ablations as Markdown."""
    head = ["variant", "surfaces", "n", *metrics]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for row in wide.to_dict("records"):
        figures = [row[m] if row[m].startswith("n=") else f"{float(row[m]):.3f}" for m in metrics]
        cells = [row["variant"], row["column"], str(row["n"]), *figures]
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    lines += [f"- `{v.name}`: {v.description}." for v in VARIANTS]
    lines += [f"- `{name}`: not measured, {why}." for name, why in MISSING.items()]
    first = wide.iloc[0]
    lines.append(
        f"\nData set {first['dataset']}, {wide['houses'].max()} houses, seed {first['seed']}."
    )
    return "\n".join(lines) + "\n"
