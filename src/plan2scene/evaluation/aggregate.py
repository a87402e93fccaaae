"""Means over surfaces of the metrics of many methods and drops, as a tidy and as a wide table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import plan2scene
from plan2scene.evaluation.cells import Cell, summed
from plan2scene.evaluation.gather import Measurements
from plan2scene.evaluation.published import TABLE_COLUMNS, comparable, published_value
from plan2scene.provenance import package_versions

if TYPE_CHECKING:
    import pandas as pd

#: Packages whose versions a table names: those that its figures are computed with.
_PACKAGES = ("numpy", "scipy", "opencv-python-headless", "pillow", "torch")


@dataclass(frozen=True)
class TableRequest:
    """What a table is made of and stands for.

    Attributes
    ----------
    houses : sequence of str
        Houses that the table should cover; those without results are named in it.
    drop : str
        Drop fraction of Unobserved and All, one decimal; observed surfaces are those of 0.0.
    drops : sequence of str
        Of a sweep: every column is measured at each of them, not at `drop`.
    """

    dataset: str
    houses: Sequence[str]
    methods: Sequence[str]
    drop: str
    seed: int
    drops: Sequence[str] = ()

    def drops_of(self, column: str) -> Sequence[str]:
        """Return the drop fractions at which a column is measured."""
        return self.drops or ["0.0" if column == "observed" else self.drop]


def tidy_table(measured: Measurements, request: TableRequest) -> pd.DataFrame:
    """Return a row per method, column, drop and metric.

    ``n`` surfaces, ``images`` of them for FID and KID, ``houses`` counted and ``missing``, the
    metric's network (``features``), ``value`` (NaN where no surface falls into the column), the
    ``published`` figure, and ours minus it where both are of one network.
    """
    import pandas as pd

    networks = measured.networks()
    cells = [
        Cell(method, column, drop, bytearray(len(request.houses)))
        for method in request.methods
        for column in TABLE_COLUMNS
        for drop in request.drops_of(column)
    ]
    summed(cells, {house: place for place, house in enumerate(request.houses)}, measured)
    last = {
        "seed": request.seed,
        "version": plan2scene.__version__,
        "packages": package_versions(*_PACKAGES),
    }
    rows: list[dict[str, object]] = []
    for cell in cells:
        pairs = zip(request.houses, cell.present, strict=True)
        missing = sorted({house for house, present in pairs if not present})
        common = {
            "dataset": request.dataset,
            "method": cell.method,
            "column": cell.column,
            "drop": cell.drop,
            "n": cell.n,
            "images": cell.images,
            "houses": cell.present.count(2),
            "missing": " ".join(missing) or "none",
            **last,
        }
        rows += [common | figures for figures in _metric_rows(cell, networks)]
    return pd.DataFrame(rows)


def _metric_rows(cell: Cell, networks: Mapping[str, str]) -> list[dict[str, object]]:
    """Return what a row says of each metric; NaN without any surface."""
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

    Metrics of a network carry its name; no cell is empty: ``n=0`` where no surface is. With
    `published`, the published figures and ours minus them follow.
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
    """Return a metric's name with its features network, where it has one."""
    return metric if features == "none" else f"{metric} ({features})"


def _figure(cell: Any) -> str:
    """Return a cell's figure; how many surfaces there are where they are too few for one."""
    known = cell.value == cell.value
    return f"{round(cell.value, 4) + 0.0:.4f}" if known else f"n={cell.n}"  # never -0.0000


def _published(cell: Any) -> str:
    """Return the published figure, or that the paper does not have it."""
    return f"{cell.published:g}" if cell.published == cell.published else "none"


def _difference(cell: Any) -> str:
    """Return ours minus the published figure, or why there is none."""
    if cell.published != cell.published:
        return "none"
    if not comparable(cell.metric, cell.features):
        return "other network"
    return f"{cell.difference:+.4f}" if cell.difference == cell.difference else f"n={cell.n}"
