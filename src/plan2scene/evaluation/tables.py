"""Tables of metrics by method, drop and group of surfaces: tidy, wide and as LaTeX.

Published figures are the paper's table 1 (CVPR 2021, test split of Rent3D++, 43 houses; lower is
better). The sums for each method, column and drop are updated house by house.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import plan2scene
from plan2scene.evaluation.measurements import MeasuredHouse, Measurements
from plan2scene.io import write_csv, write_parquet, write_text
from plan2scene.metrics.feature_sets import MAX_MOMENTS_DIMENSION, SurfaceDistances
from plan2scene.metrics.registry import METRICS
from plan2scene.provenance import package_versions

if TYPE_CHECKING:
    import pandas as pd

_LOGGER = logging.getLogger("plan2scene")
_PAPER_METRICS = ("COLOR", "FREQ", "SUBS", "FID", "TILE")
#: Networks of the published values; values made by another network are not comparable.
PUBLISHED_NETWORKS: Mapping[str, str] = {"SUBS": "vgg16", "FID": "inception"}
#: Columns: observed surfaces (at drop 0.0), unobserved and all surfaces (at the table's drop).
TABLE_COLUMNS = ("observed", "unobserved", "all")
#: Published values of `_PAPER_METRICS` by method and column; SUBS by VGG-16, FID by InceptionV3.
_TABLE: Mapping[tuple[str, str], tuple[float, ...]] = {
    ("crop", "observed"): (0.0, 0.0, 0.0, 0.0, 38.1),
    ("crop", "unobserved"): (0.768, 0.026, 0.345, 57.2, 40.6),
    ("crop", "all"): (0.459, 0.016, 0.208, 35.6, 39.5),
    ("retrieve", "observed"): (0.561, 0.054, 0.473, 238.2, 17.3),
    ("retrieve", "unobserved"): (0.751, 0.040, 0.437, 261.5, 19.1),
    ("retrieve", "all"): (0.680, 0.046, 0.458, 243.2, 18.3),
    ("naivesynth", "observed"): (0.694, 0.046, 0.385, 239.3, 21.7),
    ("naivesynth", "unobserved"): (0.714, 0.044, 0.427, 245.4, 19.8),
    ("naivesynth", "all"): (0.709, 0.046, 0.404, 239.4, 20.6),
    ("synth", "observed"): (0.431, 0.035, 0.350, 196.1, 16.4),
    ("synth", "unobserved"): (0.653, 0.032, 0.393, 199.4, 18.6),
    ("synth", "all"): (0.591, 0.034, 0.392, 196.2, 17.6),
}


def published_value(method: str, column: str, metric: str) -> float:
    """Return the paper's value; NaN for a method or metric that is not in the paper."""
    row = dict(zip(_PAPER_METRICS, _TABLE.get((method, column), ()), strict=False))
    return row.get(metric, float("nan"))


def comparable(metric: str, network: str) -> bool:
    """Return whether a value made with `network` is comparable with the published one."""
    return PUBLISHED_NETWORKS.get(metric, network) == network


#: Metrics that are means of a column of ``metrics.parquet``; FID and KID are of the whole set.
MEANS = tuple(name for name in METRICS if name not in ("FID", "KID"))
#: Number of cells that are summed in one pass over the files: usually, and for features of many
#: dimensions (InceptionV3's 2048). A cell holds some megabytes, or some hundred megabytes.
_AT_ONCE, _AT_ONCE_WIDE = 48, 3


@dataclass
class Cell:
    """Sums over the surfaces of a method, column and drop."""

    method: str
    column: str
    drop: str
    measured: set[str] = field(default_factory=set)  #: houses with results of this method and drop
    houses: int = 0  #: number of houses with surfaces in the cell
    n: int = 0
    images: int = 0
    sums: np.ndarray = field(default_factory=lambda: np.zeros((2, len(MEANS))))
    distances: SurfaceDistances = field(default_factory=SurfaceDistances)

    def add(self, house: MeasuredHouse) -> None:
        """Add the surfaces of a house."""
        columns = house.columns
        chosen = (columns["method"] == self.method) & (columns["drop"] == self.drop)
        if chosen.any():
            self.measured.add(house.name)
        if self.column != "all":
            chosen &= columns["observed"].astype(bool) == (self.column == "observed")
        rows = np.flatnonzero(chosen)
        if not len(rows):
            return
        self.houses += 1
        self.n += len(rows)
        images = [house.images[row] for row in rows]
        self.images += sum(map(len, images))
        values = np.array([columns[name.lower()][rows] for name in MEANS], dtype=np.float64)
        self.sums += np.nansum(values, axis=1), (~np.isnan(values)).sum(axis=1)
        surfaces = dict.fromkeys(house.surfaces[row] for row in rows)
        crops = [house.crops[key] for key in surfaces if key in house.crops]
        self.distances.add(images, crops)

    def values(self) -> dict[str, float]:
        """Return the value of each metric; NaN if no surface is in the cell."""
        if not self.n:
            return dict.fromkeys(METRICS, float("nan"))
        total, count = self.sums
        means = np.divide(total, count, out=np.full(len(MEANS), np.nan), where=count > 0)
        return dict(zip(MEANS, means.tolist(), strict=True)) | self.distances.values()


def summed(cells: Sequence[Cell], houses: Collection[str], measured: Measurements) -> None:
    """Add all measured houses that the table covers to the cells.

    The files are read again for each group of cells (`_AT_ONCE`), which bounds the memory.
    """
    left = list(cells)
    while left:
        cell_group = left[:_AT_ONCE]
        for house in measured.houses():
            if house.images[0].shape[1] > MAX_MOMENTS_DIMENSION:
                cell_group = cell_group[:_AT_ONCE_WIDE]
            if house.name in houses:
                for cell in cell_group:
                    cell.add(house)
        left = left[len(cell_group) :]


#: Packages that the values are computed with; a table names their versions.
_PACKAGES = ("numpy", "scipy", "opencv-python-headless", "pillow", "torch")


@dataclass(frozen=True)
class TableRequest:
    """What a table covers."""

    dataset: str
    houses: Sequence[str]  #: to cover; the table names those without results
    methods: Sequence[str]
    drop: str  #: drop of unobserved and all, with one decimal; that of observed is 0.0
    seed: int
    #: drops of a sweep: every column is measured at each of them, not at `drop`
    drops: Sequence[str] = ()

    def drops_of(self, column: str) -> Sequence[str]:
        """Return the drop fractions at which a column is measured."""
        return self.drops or ["0.0" if column == "observed" else self.drop]


def tidy_table(measured: Measurements, request: TableRequest) -> pd.DataFrame:
    """Return a row per method, column, drop and metric.

    Other columns are the numbers of surfaces ``n``, of their ``images`` for FID and KID, and of
    ``houses``; ``missing`` houses; the network ``features``; ``value`` (NaN without surfaces); the
    ``published`` value; and ``difference``, ours minus that, if both are of one network.
    """
    import pandas as pd

    networks = measured.networks()
    cells = [
        Cell(method, column, drop)
        for method in request.methods
        for column in TABLE_COLUMNS
        for drop in request.drops_of(column)
    ]
    summed(cells, set(request.houses), measured)
    last = {
        "seed": request.seed,
        "version": plan2scene.__version__,
        "packages": package_versions(*_PACKAGES),
    }
    rows: list[dict[str, object]] = []
    for cell in cells:
        missing = sorted(set(request.houses) - cell.measured)
        common = {
            "dataset": request.dataset,
            "method": cell.method,
            "column": cell.column,
            "drop": cell.drop,
            "n": cell.n,
            "images": cell.images,
            "houses": cell.houses,
            "missing": " ".join(missing) or "none",
            **last,
        }
        rows += [common | figures for figures in _metric_rows(cell, networks)]
    return pd.DataFrame(rows)


def _metric_rows(cell: Cell, networks: Mapping[str, str]) -> list[dict[str, object]]:
    """Return the metric columns of a cell's rows; NaN if it has no surface."""
    values, figures = cell.values(), []
    for name, network in networks.items():
        value, published = values[name], published_value(cell.method, cell.column, name)
        difference = value - published if comparable(name, network) else float("nan")
        figure = {"metric": name, "features": network, "value": value}
        figures.append({**figure, "published": published, "difference": difference})
    return figures


def wide_table(
    tidy: pd.DataFrame,
    first: Sequence[str] = ("method", "drop", "column", "n", "houses"),
    last: Sequence[str] = ("missing", "dataset", "seed", "version"),
    *,
    published: bool = False,
) -> pd.DataFrame:
    """Return a row per method, drop and column, its metrics side by side as text.

    The title of a metric includes its network's name. A cell without surfaces shows ``n=0``, so
    none is empty. With `published`, the published values and ours minus them follow.
    """
    import pandas as pd

    rows = []
    for _, group in tidy.groupby(["method", "drop", "column"], sort=False):
        cells = list(group.itertuples())
        row = {name: group.iloc[0][name] for name in first}
        row |= {metric_title(cell.metric, cell.features): _figure(cell) for cell in cells}
        if published:
            row |= {f"{cell.metric} published": _published(cell) for cell in cells}
            row |= {f"{cell.metric} difference": _difference(cell) for cell in cells}
        rows.append(row | {name: group.iloc[0][name] for name in last})
    return pd.DataFrame(rows)


def metric_title(metric: str, features: str) -> str:
    """Return a metric's name, with that of its network if it has one."""
    return metric if features == "none" else f"{metric} ({features})"


def _figure(cell: Any) -> str:
    """Return a cell's value as text, or the number of surfaces if they are too few for a value."""
    known = cell.value == cell.value
    return f"{round(cell.value, 4) + 0.0:.4f}" if known else f"n={cell.n}"  # never -0.0000


def _published(cell: Any) -> str:
    """Return the published value as text; ``none`` if the paper has none."""
    return f"{cell.published:g}" if cell.published == cell.published else "none"


def _difference(cell: Any) -> str:
    """Return our value minus the published one as text, or why there is none."""
    if cell.published != cell.published:
        return "none"
    if not comparable(cell.metric, cell.features):
        return "other network"
    return f"{cell.difference:+.4f}" if cell.difference == cell.difference else f"n={cell.n}"


_SMALL_FID = 3  #: Decimals of FID by the embedded network, whose values are small
#: Method crop shows the reference crop itself on observed surfaces, so it is not ranked there.
_COMPARED_WITH_ITSELF = ("crop", "observed")


def latex_table(tidy: pd.DataFrame, notes: Sequence[str] = ()) -> str:
    """Return a ``tabular`` of a table of :func:`tidy_table`; it needs package ``booktabs`` only.

    There is a group of rows per column of the paper (observed, unobserved, all), with a row per
    method. The best value of a group is bold; a published value follows in brackets; ``--`` means
    that there is no surface. The data set, the versions and `notes` are in comments above it.
    """
    import pandas as pd

    networks = tidy.drop_duplicates("metric").set_index("metric")["features"]
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for column in TABLE_COLUMNS:
        group = tidy[tidy["column"] == column]
        head = f"{column.capitalize()} ({_counts(group)})"
        cells = {name: _cells(group[group["metric"] == name]) for name in METRICS}
        for method in dict.fromkeys(group["method"]):
            row = {metric_title(name, networks[name]): cells[name][method] for name in METRICS}
            rows[head, method] = row
    frame = pd.DataFrame(rows.values(), pd.MultiIndex.from_tuples(rows))
    styler = frame.style.format_index(escape="latex", axis=0).format_index(escape="latex", axis=1)
    table = styler.to_latex(
        column_format="ll" + "r" * len(METRICS),
        hrules=True,
        clines="skip-last;data",
        multirow_align="naive",
    )
    first = tidy.iloc[0]
    comments = [
        f"data set {first['dataset']}, seed {first['seed']}, plan2scene {first['version']}",
        first["packages"],
        "lower is better; published values in brackets",
        *notes,
    ]
    return "".join(f"% {line}\n" for line in comments) + table


def _counts(group: pd.DataFrame) -> str:
    """Return ``n = 48``, or the range of n if methods differ."""
    low, high = group["n"].min(), group["n"].max()
    return f"n = {low}" if low == high else f"n = {low} to {high}"


def _cells(cells: pd.DataFrame) -> dict[str, str]:
    """Return the text of each method's cell in one column of one metric."""
    texts, ranked = {}, {}
    for cell in cells.itertuples():
        small = cell.metric == "FID" and cell.features != "inception"
        decimals = _SMALL_FID if small else METRICS[cell.metric].decimals
        rounded = round(cell.value, decimals) + 0.0  # never -0.000
        text = f"{rounded:.{decimals}f}" if cell.value == cell.value else "--"
        published = f" ({cell.published:.{METRICS[cell.metric].decimals}f})"
        texts[cell.method] = (text, published if cell.published == cell.published else "")
        if text != "--" and (cell.method, cell.column) != _COMPARED_WITH_ITSELF:
            ranked[cell.method] = float(text)
    best = min(ranked.values(), default=None)
    return {
        method: (f"\\textbf{{{text}}}" if method in ranked and ranked[method] == best else text)
        + published_text
        for method, (text, published_text) in texts.items()
    }


def paper_table(
    metrics_files: Iterable[str | Path],
    reference_files: Iterable[str | Path],
    output_csv: str | Path,
    output_parquet: str | Path,
    output_latex: str | Path,
    *,
    request: TableRequest,
) -> pd.DataFrame:
    """Write the paper's table 1 as CSV, tidy Parquet and LaTeX; return the tidy table.

    Observed is measured at drop 0.0; Unobserved and All at the table's drop (0.6 in the paper),
    with references from the hidden photos too. FID and KID compare the predictions with all crops
    of the same surfaces (:mod:`plan2scene.metrics.feature_sets`).
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
