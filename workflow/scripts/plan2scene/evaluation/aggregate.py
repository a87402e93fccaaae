"""Means over surfaces of the metrics of many methods and drops, as a tidy table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import plan2scene
from plan2scene.errors import InputError
from plan2scene.io import read_parquet
from plan2scene.metrics.frechet import frechet_distance

if TYPE_CHECKING:
    import pandas as pd

#: Metrics in the paper's order; SUBS and FID are of the network that the files name.
METRICS = ("COLOR", "FREQ", "SUBS", "FID", "TILE")
#: Which surfaces count: those that a visible photo shows, the others with a reference, both.
COLUMNS = ("observed", "unobserved", "all")
#: What a cell holds when no surface of any house falls into it.
NO_SURFACES = "n=0"
_SURFACE = ["house", "room_id", "surface"]


def read_houses(files: Iterable[str | Path]) -> tuple[pd.DataFrame, str]:
    """Return the rows of all houses' metrics and the name of their one features network."""
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


def read_references(files: Iterable[str | Path]) -> pd.DataFrame:
    """Return the features of all crops of all houses, with a column ``house``."""
    import pandas as pd

    frames = []
    for file in files:
        frame, metadata = read_parquet(file)
        frames.append(frame.assign(house=metadata["house"]))
    filled = [frame for frame in frames if len(frame)]
    return pd.concat(filled, ignore_index=True) if filled else frames[0]


def surface_means(part: pd.DataFrame, references: pd.DataFrame) -> dict[str, float]:
    """Return each metric over the surfaces of `part`; NaN without any.

    FID compares the tiles with all crops of the same surfaces, each surface counting once.
    """
    if part.empty:
        return dict.fromkeys(METRICS, float("nan"))
    values = {name: float(part[name.lower()].mean()) for name in METRICS if name != "FID"}
    crops = references.merge(part[_SURFACE].drop_duplicates(), on=_SURFACE)
    if crops.empty:
        raise InputError("reference features of the measured surfaces", "none")
    weights = 1.0 / crops.groupby(_SURFACE)["features"].transform("size").to_numpy(dtype=float)
    fid = frechet_distance(np.stack(part["features"]), np.stack(crops["features"]), weights)
    return {name: fid if name == "FID" else values[name] for name in METRICS}


def tidy_table(
    metrics: pd.DataFrame,
    references: pd.DataFrame,
    *,
    methods: Sequence[str],
    drops_of: dict[str, Sequence[str]],
    houses: Sequence[str],
    dataset: str,
    seed: int,
    features: str,
) -> pd.DataFrame:
    """Return a row per method, drop, column and metric.

    Columns ``method, drop, column, n, houses, missing, metric, features, value, dataset, seed,
    version``; ``missing`` names the houses that have no measured surface at that method and drop.

    Parameters
    ----------
    drops_of : dict
        For each of :data:`COLUMNS` the drops it is measured at.
    """
    import pandas as pd

    rows: list[dict[str, object]] = []
    for method in methods:
        for column in COLUMNS:
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
                    network = features if metric in ("SUBS", "FID") else "none"
                    cell = {"metric": metric, "features": network, "value": value}
                    rows.append({**common, **cell, **after})
    return pd.DataFrame(rows)


def wide_table(tidy: pd.DataFrame) -> pd.DataFrame:
    """Return a row per method, drop and column, its metrics side by side as text.

    SUBS and FID carry the name of their network; no cell is empty: ``n=0`` where no surface is.
    """
    import pandas as pd

    keys = ["method", "drop", "column"]
    rows = []
    for _, group in tidy.groupby(keys, sort=False):
        first = group.iloc[0]
        row = {name: first[name] for name in (*keys, "n", "houses")}
        for cell in group.itertuples():
            row[metric_title(cell.metric, cell.features)] = (
                f"{cell.value:.4f}" if cell.n else NO_SURFACES
            )
        rows.append({**row, **{k: first[k] for k in ("missing", "dataset", "seed", "version")}})
    return pd.DataFrame(rows)


def metric_title(metric: str, features: str) -> str:
    """Return a metric's name with its features network, where it has one."""
    return metric if features == "none" else f"{metric} ({features})"
