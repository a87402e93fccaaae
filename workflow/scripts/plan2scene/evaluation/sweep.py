"""Every metric against the share of photos hidden, for all methods (paper, supplement)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from plan2scene.evaluation.aggregate import (
    COLUMNS,
    read_houses,
    read_references,
    tidy_table,
    wide_table,
)
from plan2scene.evaluation.houses import HouseFiles, Models, Textures, measured, propagated_at
from plan2scene.evaluation.sweep_plot import plot_sweep
from plan2scene.io import atomic_path, write_parquet
from plan2scene.metrics.features import FEATURE_NETWORK
from plan2scene.provenance import file_hash


def sweep_house(
    files: HouseFiles,
    models: Models,
    output: str | Path,
    *,
    hidden: Mapping[str, Sequence[str]],
    seam_correction: Mapping[str, bool],
    seed: int,
    size_px: int,
) -> None:
    """Write ``sweep.parquet`` of a house: the rows of ``metrics.parquet`` for all methods, drops.

    Parameters
    ----------
    hidden : mapping
        Drop fraction (``"0.3"``) to the photos hidden at it.
    seam_correction : mapping
        The methods, and whether each one's seams are corrected.
    """
    import pandas as pd

    frames = []
    for drop, photos in hidden.items():
        with TemporaryDirectory() as name:
            folder = Path(name)
            _, propagated = propagated_at(files, models, photos, folder)
            for method, correct in seam_correction.items():
                textures = Textures(seed, size_px, correct)
                frames.append(
                    measured(
                        method,
                        propagated,
                        files,
                        models,
                        photos,
                        folder,
                        textures=textures,
                        drop=drop,
                    )
                )
    metadata = {"dataset": files.dataset, "house": files.house, "features": FEATURE_NETWORK}
    frame = pd.concat([f for f in frames if len(f)] or frames[:1], ignore_index=True)
    write_parquet(output, frame, {**metadata, "model": file_hash(models.features)})


def sweep_table(
    sweeps: Iterable[str | Path],
    references: Iterable[str | Path],
    output_csv: str | Path,
    output_plot: str | Path,
    *,
    dataset: str,
    houses: Sequence[str],
    methods: Sequence[str],
    drops: Sequence[str],
    seed: int,
) -> None:
    """Write the sweep over all houses as CSV and as a plot.

    A row per method, drop and column (observed, unobserved, all); ``n=0`` where a column has no
    surface, as observed at 1.0.
    """
    metrics, network = read_houses(sweeps)
    tidy = tidy_table(
        metrics,
        read_references(references),
        methods=methods,
        drops_of=dict.fromkeys(COLUMNS, drops),
        houses=houses,
        dataset=dataset,
        seed=seed,
        features=network,
    )
    with atomic_path(output_csv) as temporary:
        wide_table(tidy).to_csv(temporary, index=False, lineterminator="\n")
    plot_sweep(tidy, output_plot)
