"""Ablations of method synth: what each of its parts is worth, as a second table."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from plan2scene.evaluation.aggregate import (
    TableRequest,
    metric_title,
    tidy_table,
    wide_table,
)
from plan2scene.evaluation.gather import read_metrics, read_references
from plan2scene.evaluation.houses import (
    HouseFiles,
    Models,
    Textures,
    measured,
    metadata_of,
    propagated_at,
    propagated_from,
)
from plan2scene.evaluation.latex import latex_table
from plan2scene.evaluation.variants import (
    MISSING,
    VARIANTS,
    Variant,
    plane_noise_model,
    predicted,
    selected,
)
from plan2scene.floorplans import read_scene_json
from plan2scene.io import atomic_path, read_parquet, write_parquet
from plan2scene.metrics.registry import METRICS

if TYPE_CHECKING:
    import pandas as pd


def ablate_house(
    files: HouseFiles,
    models: Models,
    output: str | Path,
    *,
    hidden: Mapping[str, Sequence[str]],
    seed: int,
    size_px: int,
) -> None:
    """Write ``ablation.parquet`` of a house: rows of ``metrics.parquet``, a variant as method.

    Parameters
    ----------
    hidden : mapping
        Drop fraction to the photos hidden at it.
    """
    import pandas as pd

    frames = []
    for drop, photos in hidden.items():
        with TemporaryDirectory() as name:
            folder = Path(name)
            surfaces, _ = propagated_at(files, models, photos, folder)
            for variant in VARIANTS:
                propagated = _propagated(variant, surfaces, files, models, photos, seed)
                frames.append(
                    _measured(variant, propagated, files, models, photos, seed, size_px, drop)
                )
    frame = pd.concat([f for f in frames if len(f)] or frames[:1], ignore_index=True)
    write_parquet(output, frame, metadata_of(files, models))


def _propagated(
    variant: Variant,
    surfaces: Path,
    files: HouseFiles,
    models: Models,
    hidden_photos: Collection[str],
    seed: int,
) -> Path:
    """Write the propagated table of a variant beside `surfaces`; return its path.

    What a variant selects is what its propagation starts from.
    """
    table, crops, embeddings = (
        read_parquet(path)[0] for path in (surfaces, files.crops, files.embeddings)
    )
    own = surfaces.with_name(f"{variant.name}_surfaces.parquet")
    output = surfaces.with_name(f"{variant.name}_propagated.parquet")
    chosen = selected(
        table, crops, embeddings, hidden_photos, variant, house=files.house, seed=seed
    )
    write_parquet(own, chosen, {"house": files.house})
    propagated_from(own, output, files, models)
    frame, metadata = read_parquet(output)
    plan = read_scene_json(files.scene, files.house)
    write_parquet(output, predicted(plan, frame, variant, models), metadata)
    return output


def _measured(
    variant: Variant,
    propagated: Path,
    files: HouseFiles,
    models: Models,
    hidden_photos: Collection[str],
    seed: int,
    size_px: int,
    drop: str,
) -> pd.DataFrame:
    """Return the metrics of a variant."""
    folder = propagated.parent
    decoder = None
    if variant.plane_noise:
        decoder = plane_noise_model(models.texture, folder / "plane_noise.safetensors")
    return measured(
        "naivesynth" if variant.rgb else "synth",
        propagated,
        files,
        models,
        hidden_photos,
        folder,
        textures=Textures(seed, size_px, variant.seam_correction),
        drop=drop,
        decoder=decoder,
        name=variant.name,
    )


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
    metrics, networks = read_metrics(ablations)
    request = TableRequest(dataset, houses, [variant.name for variant in VARIANTS], drop, seed)
    tidy = tidy_table(metrics, read_references(references), networks, request)
    wide = wide_table(tidy).rename(columns={"method": "variant"})
    described = {variant.name: variant.description for variant in VARIANTS}
    wide.insert(1, "description", wide["variant"].map(described))
    with atomic_path(output_csv) as temporary:
        wide.to_csv(temporary, index=False, lineterminator="\n")
    missing = [f"{name}: not measured, {why}" for name, why in MISSING.items()]
    shown = [metric_title(name, networks[name]) for name in METRICS]
    for path, text in (
        (output_markdown, _markdown(wide, shown)),
        (output_latex, latex_table(tidy, missing)),
    ):
        with atomic_path(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


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
