"""Every metric against the share of photos hidden, for all methods (paper, supplement)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from plan2scene.evaluation.measure import write_measured
from plan2scene.evaluation.measurements import Measurements
from plan2scene.evaluation.references import reference_images
from plan2scene.evaluation.tables import TableRequest, tidy_table, wide_table
from plan2scene.io import write_csv
from plan2scene.textures.inputs import HouseData, Visible
from plan2scene_app.study.evaluated_house import EvaluatedHouse, measured_at
from plan2scene_app.study.plots import plot_sweep

if TYPE_CHECKING:
    import pandas as pd


def sweep_house(
    house: EvaluatedHouse,
    embeddings: Path,
    output: str | Path,
    *,
    hidden: Mapping[str, Sequence[str]],
    methods: Sequence[str],
) -> None:
    """Write a house's ``sweep.parquet``: rows as in ``metrics.parquet`` by all methods and drops.

    `hidden` maps a drop fraction (``"0.3"``) to the photos hidden at it.
    """
    data = HouseData(house.files)
    done: dict[frozenset[str], list[pd.DataFrame]] = {}
    frames = []
    for drop, photos in hidden.items():
        key = frozenset(photos)  # with few photos, several drops hide the same ones
        if key not in done:
            done[key] = _at_drop(house, data, embeddings, photos, methods)
        frames += [frame.assign(drop=drop) for frame in done[key]]
    write_measured(output, frames, house.metadata)


def _at_drop(
    house: EvaluatedHouse,
    data: HouseData,
    embeddings: Path,
    hidden_photos: Sequence[str],
    methods: Sequence[str],
) -> list[pd.DataFrame]:
    """Return the metrics of each method with those photos hidden."""
    references = reference_images(data.crops, hidden_photos)
    with TemporaryDirectory() as name:
        surfaces, propagated = Path(name) / "surfaces.parquet", Path(name) / "propagated.parquet"
        house.select(embeddings, hidden_photos, surfaces)
        house.propagate(surfaces, hidden_photos, propagated)
        return measured_at(house, data, Visible(propagated, hidden_photos), methods, references)


def sweep_table(
    sweeps: Iterable[str | Path],
    references: Iterable[str | Path],
    output_csv: str | Path,
    output_plot: str | Path,
    *,
    request: TableRequest,
) -> None:
    """Write the sweep over all houses as CSV and as a plot.

    There is a row per method, drop and column (observed, unobserved, all). A cell is ``n=0`` if
    its column has no surface, such as observed at drop 1.0.
    """
    tidy = tidy_table(Measurements(sweeps, references), request)
    write_csv(output_csv, wide_table(tidy))
    plot_sweep(tidy, output_plot)
