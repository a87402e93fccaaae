"""The paper's table 1 over all houses: method x (observed, unobserved, all) x metric.

Observed is measured at drop 0.0; Unobserved and All at the table's drop (0.6 in the paper), with
references from the hidden photos too. FID and KID compare the predictions with all crops of the
same surfaces (:mod:`plan2scene.evaluation.distances`).
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import plan2scene
from plan2scene.evaluation.distances import feature_distances
from plan2scene.evaluation.gather import read_metrics, read_references
from plan2scene.evaluation.latex import latex_table
from plan2scene.evaluation.plot import plot_table
from plan2scene.evaluation.published import METRICS, TABLE_COLUMNS, comparable, published_value
from plan2scene.io import atomic_path, write_parquet
from plan2scene.provenance import package_versions

if TYPE_CHECKING:
    import pandas as pd

_LOGGER = logging.getLogger("plan2scene")
#: What a cell holds when no surface of any house falls into its column.
NOSURFACES = "n=0"
#: What a cell reads for a method that the paper does not have.
UNPUBLISHED = "none"
#: What a difference reads where the published figure comes from another network.
OTHER_NETWORK = "other network"
#: Packages whose versions a table names: those that its figures are computed with.
_PACKAGES = ("numpy", "scipy", "opencv-python-headless", "pillow", "torch")


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
    output_latex: str | Path | None = None,
    *,
    request: TableRequest,
) -> pd.DataFrame:
    """Write the table as CSV, tidy Parquet, plot and (where asked) LaTeX; return the tidy table.

    Parameters
    ----------
    metrics_files : iterable of path
        ``metrics.parquet`` of all houses, methods and drops.
    reference_files : iterable of path
        ``reference_features.parquet`` of the houses.

    The CSV has a row per method and column: n surfaces, images of them for FID and KID, houses
    counted, each metric, the published figure and ours minus it, houses missing, seed and
    versions. No cell is empty: where no surface falls into a column its metrics read ``n=0``.
    SUBS, FID and KID carry the name of their network; a difference is given only where it is
    that of the published figure.
    """
    import pandas as pd

    metrics, networks = read_metrics(metrics_files)
    references = read_references(reference_files)
    rows = []
    for method in request.methods:
        for column in TABLE_COLUMNS:
            part, missing = _select(metrics, method, column, request)
            rows += _tidy_rows(part, references, method, column, missing, networks, request)
    tidy = pd.DataFrame(rows)
    write_parquet(output_parquet, tidy, {"dataset": request.dataset, "seed": request.seed})
    with atomic_path(output_csv) as temporary:
        _wide(tidy).to_csv(temporary, index=False, lineterminator="\n")
    plot_table(tidy, output_plot)
    if output_latex is not None:
        with atomic_path(output_latex) as temporary:
            temporary.write_text(latex_table(tidy), encoding="utf-8")
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


def _tidy_rows(
    part: pd.DataFrame,
    references: pd.DataFrame,
    method: str,
    column: str,
    missing: Sequence[str],
    networks: Mapping[str, str],
    request: TableRequest,
) -> list[dict[str, object]]:
    """Return a row per metric of one method and column."""
    if part.empty:
        _LOGGER.warning("no surface counts for method %s, column %s", method, column)
        values = dict.fromkeys(METRICS, float("nan"))
    else:
        paired = [name for name in METRICS if name not in ("FID", "KID")]
        values = {name: float(part[name.lower()].mean()) for name in paired}
        values |= feature_distances(part, references)
    common = {
        "dataset": request.dataset,
        "method": method,
        "column": column,
        "drop": "0.0" if column == "observed" else request.drop,
        "n": len(part),
        "images": _image_count(part),
        "houses": int(part["house"].nunique()),
        "missing": " ".join(missing) or "none",
        "seed": request.seed,
        "version": plan2scene.__version__,
        "packages": package_versions(*_PACKAGES),
    }
    rows: list[dict[str, object]] = []
    for name in METRICS:
        published = published_value(method, column, name)
        same_scale = comparable(name, networks[name])
        rows.append(
            {
                **common,
                "metric": name,
                "features": networks[name],
                "value": values[name],
                "published": published,
                "difference": values[name] - published if same_scale else float("nan"),
            }
        )
    return rows


def _image_count(part: pd.DataFrame) -> int:
    """Return how many images of its surfaces FID and KID look at."""
    pairs = zip(part["features"], part["further_features"], strict=True)
    return sum(1 + len(more) // len(first) for first, more in pairs)


def _wide(tidy: pd.DataFrame) -> pd.DataFrame:
    """Return a row per method and column: metrics, published figures, differences side by side."""
    import pandas as pd

    rows = []
    for _, group in tidy.groupby(["method", "column"], sort=False):
        first = group.iloc[0]
        row = {name: first[name] for name in ("method", "column", "drop", "n", "images", "houses")}
        for cell in group.itertuples():
            network = "" if cell.features == "none" else f" ({cell.features})"
            row[f"{cell.metric}{network}"] = _figure(cell.value, cell.n)
        for cell in group.itertuples():
            known = cell.published == cell.published
            row[f"{cell.metric} published"] = f"{cell.published:g}" if known else UNPUBLISHED
        for cell in group.itertuples():
            row[f"{cell.metric} difference"] = _difference(cell)
        last = ("missing", "dataset", "seed", "version", "packages")
        rows.append({**row, **{name: first[name] for name in last}})
    return pd.DataFrame(rows)


def _figure(value: float, n: int) -> str:
    """Return a cell's figure; how many surfaces there are where they are too few for one."""
    return f"{round(value, 4) + 0.0:.4f}" if value == value else f"n={n}"  # never -0.0000


def _difference(cell: Any) -> str:
    """Return ours minus the published figure as the CSV has it."""
    if cell.published != cell.published:
        return UNPUBLISHED
    if not comparable(cell.metric, cell.features):
        return OTHER_NETWORK
    return f"{cell.difference:+.4f}" if cell.difference == cell.difference else f"n={cell.n}"
