"""Ablations of method synth: what each of its parts is worth, as a second table."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from plan2scene.evaluation.aggregate import TableRequest, metric_title, tidy_table, wide_table
from plan2scene.evaluation.gather import Measurements
from plan2scene.evaluation.houses import (
    EvaluatedHouse,
    measured_at,
    propagated_at,
    propagated_from,
    write_measured,
)
from plan2scene.evaluation.latex import latex_table
from plan2scene.evaluation.measure import reference_images
from plan2scene.evaluation.variants import (
    MISSING,
    VARIANTS,
    Variant,
    plane_noise_model,
    predicted,
    selected,
)
from plan2scene.io import read_parquet, write_csv, write_parquet, write_text
from plan2scene.metrics.registry import METRICS
from plan2scene.plans import read_scene_json
from plan2scene.textures.inputs import HouseData, Visible

if TYPE_CHECKING:
    import pandas as pd


def ablate_house(
    house: EvaluatedHouse,
    embeddings: Path,
    output: str | Path,
    *,
    hidden: Mapping[str, Sequence[str]],
) -> None:
    """Write ``ablation.parquet`` of a house: rows of ``metrics.parquet``, a variant as method.

    `hidden` maps a drop fraction to the photos hidden at it.
    """
    data = HouseData(house.files)
    frames = []
    for drop, photos in hidden.items():
        references = reference_images(data.crops, photos)
        with TemporaryDirectory() as name:
            folder = Path(name)
            surfaces, _ = propagated_at(house, embeddings, photos, folder)
            for variant in VARIANTS:
                own = _variant_of(house, variant, folder)
                propagated = _propagated(variant, surfaces, house, data.crops, embeddings, photos)
                visible = Visible(propagated, photos)
                rows = measured_at(own, data, visible, [variant.method], references, drop=drop)
                frames += [frame.assign(method=variant.name) for frame in rows]
    write_measured(output, house, frames)


def _variant_of(house: EvaluatedHouse, variant: Variant, folder: Path) -> EvaluatedHouse:
    """Return the house with the noise and the seams that a variant wants."""
    settings = replace(house.settings, seam_correction={variant.method: variant.seam_correction})
    if not variant.plane_noise:
        return replace(house, settings=settings)
    plane = plane_noise_model(house.models.texture, folder / "plane_noise.safetensors")
    return replace(house, settings=settings, models=replace(house.models, texture=plane))


def _propagated(
    variant: Variant,
    surfaces: Path,
    house: EvaluatedHouse,
    crops: pd.DataFrame,
    embeddings: Path,
    hidden_photos: Collection[str],
) -> Path:
    """Write the propagated table of a variant beside `surfaces`; return its path.

    What a variant selects is what its propagation starts from.
    """
    files = house.files
    table, embedded = read_parquet(surfaces)[0], read_parquet(embeddings)[0]
    own = surfaces.with_name(f"{variant.name}_surfaces.parquet")
    output = surfaces.with_name(f"{variant.name}_propagated.parquet")
    given = (table, crops, embedded, hidden_photos, variant)
    chosen = selected(*given, house=files.house_id, seed=house.settings.seed)
    write_parquet(own, chosen, {"house": files.house_id})
    propagated_from(own, output, house, list(hidden_photos))
    frame, metadata = read_parquet(output)
    plan = read_scene_json(files.scene, files.house_id)
    write_parquet(output, predicted(plan, frame, variant, house.models), metadata)
    return output


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

    Observed surfaces at drop 0.0, unobserved and all at `drop`, as in the paper's table 1. Rows
    that would need other weights are named beside the table.
    """
    request = TableRequest(dataset, houses, [variant.name for variant in VARIANTS], drop, seed)
    tidy = tidy_table(Measurements(ablations, references), request)
    wide = wide_table(tidy).rename(columns={"method": "variant"})
    described = {variant.name: variant.description for variant in VARIANTS}
    wide.insert(1, "description", wide["variant"].map(described))
    write_csv(output_csv, wide)
    missing = [f"{name}: not measured, {why}" for name, why in MISSING.items()]
    networks = dict(zip(tidy["metric"], tidy["features"], strict=True))
    shown = [metric_title(name, networks[name]) for name in METRICS]
    write_text(output_markdown, _markdown(wide, shown))
    write_text(output_latex, latex_table(tidy, missing))


def _markdown(wide: pd.DataFrame, metrics: Sequence[str]) -> str:
    """Return the table, three decimals a figure, and what is missing as Markdown."""
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
