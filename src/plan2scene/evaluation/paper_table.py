"""The paper's table 1 over all houses: method x (observed, unobserved, all) x metric.

Observed is measured at drop 0.0; Unobserved and All at the table's drop (0.6 in the paper), with
references from the hidden photos too. FID and KID compare the predictions with all crops of the
same surfaces (:mod:`plan2scene.metrics.feature_sets`).
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.evaluation.measurements import Measurements
from plan2scene.evaluation.tables import TableRequest, latex_table, tidy_table, wide_table
from plan2scene.io import write_csv, write_parquet, write_text

if TYPE_CHECKING:
    import pandas as pd

_LOGGER = logging.getLogger("plan2scene")


def paper_table(
    metrics_files: Iterable[str | Path],
    reference_files: Iterable[str | Path],
    output_csv: str | Path,
    output_parquet: str | Path,
    output_latex: str | Path,
    *,
    request: TableRequest,
) -> pd.DataFrame:
    """Write the table as CSV, tidy Parquet and LaTeX; return the tidy table.

    `metrics_files` are ``metrics.parquet`` of the houses, `reference_files` their
    ``reference_features.parquet``.
    """
    tidy = tidy_table(Measurements(metrics_files, reference_files), request)
    empty = tidy.loc[tidy["n"] == 0, ["method", "column"]].drop_duplicates()
    for method, column in empty.itertuples(index=False, name=None):
        _LOGGER.warning("no surface counts for method %s, column %s", method, column)
    write_parquet(output_parquet, tidy, {"dataset": request.dataset, "seed": request.seed})
    wide = wide_table(
        tidy,
        ("method", "column", "drop", "n", "images", "houses"),
        ("missing", "dataset", "seed", "version", "packages"),
        published=True,
    )
    write_csv(output_csv, wide)
    write_text(output_latex, latex_table(tidy))
    return tidy
