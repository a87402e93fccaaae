"""Means over surfaces of the metrics of many methods and drops, as a tidy table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import plan2scene
from plan2scene.evaluation.distances import feature_distances
from plan2scene.evaluation.published import METRICS, TABLE_COLUMNS

if TYPE_CHECKING:
    import pandas as pd


def surface_means(part: pd.DataFrame, references: pd.DataFrame) -> dict[str, float]:
    """Return each metric over the surfaces of `part`; NaN without any."""
    if part.empty:
        return dict.fromkeys(METRICS, float("nan"))
    paired = {
        name: float(part[name.lower()].mean()) for name in METRICS if name not in ("FID", "KID")
    }
    found = paired | feature_distances(part, references)
    return {name: found[name] for name in METRICS}


def tidy_table(
    metrics: pd.DataFrame,
    references: pd.DataFrame,
    *,
    methods: Sequence[str],
    drops_of: dict[str, Sequence[str]],
    houses: Sequence[str],
    dataset: str,
    seed: int,
    networks: dict[str, str],
) -> pd.DataFrame:
    """Return a row per method, drop, column and metric.

    Columns ``method, drop, column, n, houses, missing, metric, features, value, dataset, seed,
    version``; ``missing`` names the houses that have no measured surface at that method and drop.

    Parameters
    ----------
    drops_of : dict
        For each of ``TABLE_COLUMNS`` the drops it is measured at.
    networks : dict
        Each metric's network, of :func:`plan2scene.evaluation.gather.read_metrics`.
    """
    import pandas as pd

    rows: list[dict[str, object]] = []
    for method in methods:
        for column in TABLE_COLUMNS:
            for drop in drops_of[column]:
                whole = metrics[(metrics["method"] == method) & (metrics["drop"] == drop)]
                missing = sorted(set(houses) - set(whole["house"]))
                part = whole
                if column != "all":
                    part = whole[whole["observed"].astype(bool) == (column == "observed")]
                common = {
                    "method": method,
                    "drop": drop,
                    "column": column,
                    "n": len(part),
                    "houses": int(part["house"].nunique()),
                    "missing": " ".join(missing) or "none",
                }
                after = {"dataset": dataset, "seed": seed, "version": plan2scene.__version__}
                for metric, value in surface_means(part, references).items():
                    cell = {"metric": metric, "features": networks[metric], "value": value}
                    rows.append({**common, **cell, **after})
    return pd.DataFrame(rows)


def wide_table(tidy: pd.DataFrame) -> pd.DataFrame:
    """Return a row per method, drop and column, its metrics side by side as text.

    Metrics of a network carry its name; no cell is empty: ``n=0`` where no surface is.
    """
    import pandas as pd

    keys = ["method", "drop", "column"]
    rows = []
    for _, group in tidy.groupby(keys, sort=False):
        first = group.iloc[0]
        row = {name: first[name] for name in (*keys, "n", "houses")}
        for cell in group.itertuples():
            row[metric_title(cell.metric, cell.features)] = (
                f"{cell.value:.4f}" if cell.value == cell.value else f"n={cell.n}"
            )
        rows.append({**row, **{k: first[k] for k in ("missing", "dataset", "seed", "version")}})
    return pd.DataFrame(rows)


def metric_title(metric: str, features: str) -> str:
    """Return a metric's name with its features network, where it has one."""
    return metric if features == "none" else f"{metric} ({features})"
