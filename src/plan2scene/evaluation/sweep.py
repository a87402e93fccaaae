"""Every metric against the share of photos hidden, for all methods (paper, supplement)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from plan2scene.evaluation.aggregate import TableRequest, tidy_table, wide_table
from plan2scene.evaluation.gather import read_metrics, read_references
from plan2scene.evaluation.houses import (
    HouseFiles,
    Models,
    Textures,
    measured,
    metadata_of,
    propagated_at,
)
from plan2scene.evaluation.plot import plot_sweep
from plan2scene.io import atomic_path, write_parquet

if TYPE_CHECKING:
    import pandas as pd


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

    done: dict[frozenset[str], pd.DataFrame] = {}
    frames = []
    for drop, photos in hidden.items():
        key = frozenset(photos)  # a house of few photos hides the same at several drops
        if key not in done:
            done[key] = _at_drop(files, models, photos, seam_correction, seed, size_px)
        frames.append(done[key].assign(drop=drop))
    frame = pd.concat([f for f in frames if len(f)] or frames[:1], ignore_index=True)
    write_parquet(output, frame, metadata_of(files, models))


def _at_drop(
    files: HouseFiles,
    models: Models,
    hidden_photos: Sequence[str],
    seam_correction: Mapping[str, bool],
    seed: int,
    size_px: int,
) -> pd.DataFrame:
    """Return the metrics of all methods with those photos hidden."""
    import pandas as pd

    with TemporaryDirectory() as name:
        folder = Path(name)
        _, propagated = propagated_at(files, models, hidden_photos, folder)
        frames = [
            measured(
                method,
                propagated,
                files,
                models,
                hidden_photos,
                folder,
                textures=Textures(seed, size_px, correct),
                drop="",
            )
            for method, correct in seam_correction.items()
        ]
    return pd.concat([f for f in frames if len(f)] or frames[:1], ignore_index=True)


def sweep_table(
    sweeps: Iterable[str | Path],
    references: Iterable[str | Path],
    output_csv: str | Path,
    output_plot: str | Path,
    *,
    request: TableRequest,
) -> None:
    """Write the sweep over all houses as CSV and as a plot.

    A row per method, drop and column (observed, unobserved, all); ``n=0`` where a column has no
    surface, as observed at 1.0.
    """
    metrics, networks = read_metrics(sweeps)
    tidy = tidy_table(metrics, read_references(references), networks, request)
    with atomic_path(output_csv) as temporary:
        wide_table(tidy).to_csv(temporary, index=False, lineterminator="\n")
    plot_sweep(tidy, output_plot)
