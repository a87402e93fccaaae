"""The paper's table 1 over all houses: method x (observed, unobserved, all) x metric.

Observed is measured at drop 0.0; Unobserved and All at the table's drop (0.6 in the paper), with
references from the hidden photos too. FID compares the predictions with all crops of the same
surfaces, each surface counting once however many crops it has.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import plan2scene
from plan2scene.errors import InputError
from plan2scene.io import atomic_path, read_parquet, write_parquet
from plan2scene.metrics.frechet import frechet_distance
from plan2scene.metrics.plot import plot_table
from plan2scene.metrics.published import METRICS, PUBLISHED, TABLE_COLUMNS

if TYPE_CHECKING:
    import pandas as pd

_LOGGER = logging.getLogger("plan2scene")
_SURFACE = ["house", "room_id", "surface"]
#: What a cell holds when no surface of any house falls into its column.
NO_SURFACES = "n=0"
#: What a cell reads for a method that the paper does not have.
UNPUBLISHED = "none"


@dataclass(frozen=True)
class TableRequest:
    """What a table is made of and stands for.

    Attributes
    ----------
    dataset : str
    houses : tuple of str
        Houses that the table should cover; those without results are named in it.
    methods : tuple of str
    drop : str
        Drop fraction of Unobserved and All, one decimal.
    seed : int
    """

    dataset: str
    houses: tuple[str, ...]
    methods: tuple[str, ...]
    drop: str
    seed: int


def paper_table(
    metrics_files: Iterable[str | Path],
    reference_files: Iterable[str | Path],
    output_csv: str | Path,
    output_parquet: str | Path,
    output_plot: str | Path,
    *,
    request: TableRequest,
) -> pd.DataFrame:
    """Write the table as CSV, as tidy Parquet and as a plot; return the tidy table.

    Parameters
    ----------
    metrics_files : iterable of path
        ``metrics.parquet`` of all houses, methods and drops.
    reference_files : iterable of path
        ``reference_features.parquet`` of the houses.

    The CSV has a row per method and column: n surfaces, houses counted, houses missing, each
    metric and the published figure beside it. No cell is empty: where no surface falls into a
    column its metrics read ``n=0``. SUBS and FID carry the name of their network.
    """
    import pandas as pd

    metrics, network = _read_metrics(metrics_files)
    references = _read_references(reference_files)
    rows = []
    for method in request.methods:
        for column in TABLE_COLUMNS:
            part, missing = _select(metrics, method, column, request)
            rows += _tidy_rows(part, references, method, column, missing, network, request)
    tidy = pd.DataFrame(rows)
    write_parquet(output_parquet, tidy, {"dataset": request.dataset, "seed": request.seed})
    with atomic_path(output_csv) as temporary:
        _wide(tidy).to_csv(temporary, index=False, lineterminator="\n")
    plot_table(tidy, output_plot)
    return tidy


def partial_table(
    results: str | Path, output_folder: str | Path, *, request: TableRequest
) -> Path | None:
    """Write the table of those houses that have results, for a run that failed in parts.

    Reads ``results`` (``results/{dataset}``) as docs/conventions.md lays it out and writes
    ``paper_table_partial.csv``, ``.parquet`` and ``.png`` into `output_folder`. Returns the CSV's
    path; None when there is nothing to count yet.
    """
    root, folder = Path(results), Path(output_folder)
    metrics = [
        path
        for drop in sorted({"0.0", request.drop})
        for method in request.methods
        for house in request.houses
        if (path := root / f"drop_{drop}" / method / house / "metrics.parquet").is_file()
    ]
    references = [
        path
        for house in request.houses
        if (path := root / "houses" / house / "reference_features.parquet").is_file()
    ]
    if not metrics or not references:
        return None
    output = folder / "paper_table_partial.csv"
    paper_table(
        metrics,
        references,
        output,
        output.with_suffix(".parquet"),
        output.with_suffix(".png"),
        request=request,
    )
    return output


def _read_metrics(files: Iterable[str | Path]) -> tuple[pd.DataFrame, str]:
    """Return all houses' metrics, and the name of the one network that SUBS and FID come from."""
    import pandas as pd

    frames, networks = [], {}
    for file in files:
        frame, metadata = read_parquet(file)
        networks[str(metadata.get("features")), str(metadata.get("model"))] = file
        frames.append(frame)
    if len(networks) != 1:
        raise InputError("metrics of one features network", str(sorted(networks)))
    filled = [frame for frame in frames if len(frame)] or frames[:1]
    return pd.concat(filled, ignore_index=True), next(iter(networks))[0]


def _read_references(files: Iterable[str | Path]) -> pd.DataFrame:
    """Return the features of all crops of all houses, with a column ``house``."""
    import pandas as pd

    frames = []
    for file in files:
        frame, metadata = read_parquet(file)
        frames.append(frame.assign(house=metadata["house"]))
    filled = [frame for frame in frames if len(frame)]
    if not filled:
        return pd.DataFrame(columns=[*_SURFACE, "features"])
    return pd.concat(filled, ignore_index=True)


def _select(
    metrics: pd.DataFrame, method: str, column: str, request: TableRequest
) -> tuple[pd.DataFrame, list[str]]:
    """Return the surfaces of a column and the expected houses that have no surface measured."""
    drop = "0.0" if column == "observed" else request.drop
    wanted = metrics["house"].isin(list(request.houses))
    part = metrics[wanted & (metrics["method"] == method) & (metrics["drop"] == drop)]
    missing = sorted(set(request.houses) - set(part["house"]))
    if column != "all":
        part = part[part["observed"].astype(bool) == (column == "observed")]
    return part, missing


def _frechet(part: pd.DataFrame, references: pd.DataFrame) -> float:
    """Return the Frechet distance of predictions to the crops of their surfaces."""
    crops = references.merge(part[_SURFACE].drop_duplicates(), on=_SURFACE)
    if crops.empty:
        raise InputError("reference features of the measured surfaces", "none")
    weights = 1.0 / crops.groupby(_SURFACE)["features"].transform("size").to_numpy(dtype=float)
    return frechet_distance(np.stack(part["features"]), np.stack(crops["features"]), weights)


def _tidy_rows(
    part: pd.DataFrame,
    references: pd.DataFrame,
    method: str,
    column: str,
    missing: Sequence[str],
    network: str,
    request: TableRequest,
) -> list[dict[str, object]]:
    """Return a row per metric of one method and column."""
    if part.empty:
        _LOGGER.warning("no surface counts for method %s, column %s", method, column)
        values = dict.fromkeys(METRICS, float("nan"))
    else:
        values = {name: float(part[name.lower()].mean()) for name in METRICS if name != "FID"}
        values["FID"] = _frechet(part, references)
    common = {
        "dataset": request.dataset,
        "method": method,
        "column": column,
        "drop": "0.0" if column == "observed" else request.drop,
        "n": len(part),
        "houses": int(part["house"].nunique()),
        "missing": " ".join(missing) or "none",
        "seed": request.seed,
        "version": plan2scene.__version__,
    }
    unpublished = (float("nan"),) * len(METRICS)
    figures = PUBLISHED[method][column] if method in PUBLISHED else unpublished
    published = dict(zip(METRICS, figures, strict=True))
    return [
        {
            **common,
            "metric": name,
            "features": network if name in ("SUBS", "FID") else "none",
            "value": values[name],
            "published": published[name],
        }
        for name in METRICS
    ]


def _wide(tidy: pd.DataFrame) -> pd.DataFrame:
    """Return a row per method and column, metrics side by side, published figures after them."""
    import pandas as pd

    rows = []
    for _, group in tidy.groupby(["method", "column"], sort=False):
        first = group.iloc[0]
        row = {name: first[name] for name in ("method", "column", "drop", "n", "houses")}
        for cell in group.itertuples():
            network = "" if cell.features == "none" else f" ({cell.features})"
            row[f"{cell.metric}{network}"] = f"{cell.value:.4f}" if cell.n else NO_SURFACES
        for cell in group.itertuples():
            known = cell.published == cell.published
            row[f"{cell.metric} published"] = f"{cell.published:g}" if known else UNPUBLISHED
        rows.append({**row, **{k: first[k] for k in ("missing", "dataset", "seed", "version")}})
    return pd.DataFrame(rows)
