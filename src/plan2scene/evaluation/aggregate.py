"""Means over surfaces of the metrics of many methods and drops, as a tidy and as a wide table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import plan2scene
from plan2scene.evaluation.distances import feature_distances
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


def tidy_table(
    metrics: pd.DataFrame,
    references: pd.DataFrame,
    networks: Mapping[str, str],
    request: TableRequest,
) -> pd.DataFrame:
    """Return a row per method, column, drop and metric.

    ``n`` surfaces, ``images`` of them for FID and KID, ``houses`` counted and ``missing``, the
    metric's network (``features``), ``value`` (NaN where no surface falls into the column), the
    ``published`` figure, and ours minus it where both are of one network. `metrics`, `references`
    and `networks` are those of :mod:`plan2scene.evaluation.gather`.
    """
    import pandas as pd

    wanted = metrics[metrics["house"].isin(list(request.houses))]
    packages = package_versions(*_PACKAGES)
    rows: list[dict[str, object]] = []
    for method in request.methods:
        for column in TABLE_COLUMNS:
            for drop in request.drops_of(column):
                part = wanted[(wanted["method"] == method) & (wanted["drop"] == drop)]
                missing = sorted(set(request.houses) - set(part["house"]))
                if column != "all":
                    part = part[part["observed"].astype(bool) == (column == "observed")]
                common = {
                    "dataset": request.dataset,
                    "method": method,
                    "column": column,
                    "drop": drop,
                    "n": len(part),
                    "images": _image_count(part),
                    "houses": int(part["house"].nunique()),
                    "missing": " ".join(missing) or "none",
                    "seed": request.seed,
                    "version": plan2scene.__version__,
                    "packages": packages,
                }
                cells = _cells(part, references, networks, method, column)
                rows += [{**common, **cell} for cell in cells]
    return pd.DataFrame(rows)


def _cells(
    part: pd.DataFrame,
    references: pd.DataFrame,
    networks: Mapping[str, str],
    method: str,
    column: str,
) -> list[dict[str, object]]:
    """Return what a row says of each metric over the surfaces of `part`; NaN without any."""
    sets = feature_distances(part, references) if len(part) else {}
    cells: list[dict[str, object]] = []
    for name, network in networks.items():
        value = float("nan") if part.empty else sets.get(name)
        if value is None:
            value = float(part[name.lower()].mean())
        published = published_value(method, column, name)
        difference = value - published if comparable(name, network) else float("nan")
        cell = {"metric": name, "features": network, "value": value}
        cells.append({**cell, "published": published, "difference": difference})
    return cells


def _image_count(part: pd.DataFrame) -> int:
    """Return how many images of its surfaces FID and KID look at."""
    pairs = zip(part["features"], part["further_features"], strict=True)
    return sum(1 + len(more) // len(first) for first, more in pairs)


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
