"""Plots of the paper's table (bars) and of a sweep (lines); a method has one colour in both."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.evaluation.tables import TABLE_COLUMNS, comparable, metric_title
from plan2scene.io import atomic_path
from plan2scene.metrics.registry import METRICS

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#9aa5b1", "#d9a441", "#6c8ebf", "#3a7d44", "#a4508b", "#c8654f", "#5b5b5b", "#7fc0b0")
_MARKERS = "os^DvPX<"


def plot_table(tidy: pd.DataFrame, output: str | Path) -> None:
    """Write a PNG of the tidy table of :func:`plan2scene.evaluation.tables.paper_table`.

    There is a panel per metric and a group of bars per column. Published values are drawn only
    if the same network made them, so that they are comparable.
    """
    figure = _figure(17, 3.6)
    for axes, metric in zip(figure.subplots(1, len(METRICS)), METRICS, strict=True):
        cells = tidy[tidy["metric"] == metric].set_index(["method", "column"])
        _bars(axes, cells, metric, list(dict.fromkeys(tidy["method"])))
    dataset, n = tidy["dataset"].iloc[0], tidy.groupby("column", sort=False)["n"].max()
    counts = ", ".join(f"{name} {count}" for name, count in n.items())
    _entitle(figure, f"{dataset}: lower is better; surfaces: {counts}. Published: Rent3D++.")
    with atomic_path(output) as temporary:
        figure.savefig(temporary, dpi=110, metadata={"Software": None})


def _bars(axes: Axes, cells: pd.DataFrame, metric: str, methods: list[str]) -> None:
    """Draw the cells of one metric, indexed by method and column."""
    network = cells["features"].iloc[0]
    width = 0.8 / len(methods)
    for i, method in enumerate(methods):
        place = np.arange(len(TABLE_COLUMNS)) + (i - (len(methods) - 1) / 2) * width
        values = [cells.loc[(method, column), "value"] for column in TABLE_COLUMNS]
        axes.bar(place, values, 0.92 * width, color=_COLOURS[i % len(_COLOURS)], label=method)
        if comparable(metric, network):
            marks = [cells.loc[(method, column), "published"] for column in TABLE_COLUMNS]
            label = "published" if i == 0 else None
            axes.plot(place, marks, "D", color="black", markersize=4, mfc="none", label=label)
    axes.set_xticks(range(len(TABLE_COLUMNS)), TABLE_COLUMNS, fontsize=8)
    axes.set_title(metric_title(metric, network))
    axes.spines[["top", "right"]].set_visible(False)
    if cells["value"].min() >= 0:  # KID may be negative
        axes.set_ylim(bottom=0, top=None if cells["value"].max() > 0 else 1)


def plot_sweep(tidy: pd.DataFrame, output: str | Path) -> None:
    """Write a PNG of a sweep's tidy table: a row per column of surfaces, a panel per metric."""
    figure = _figure(17, 8)
    panels = figure.subplots(len(TABLE_COLUMNS), len(METRICS), sharex=True, sharey="col")
    for column, line in zip(TABLE_COLUMNS, panels, strict=True):
        for metric, axes in zip(METRICS, line, strict=True):
            cells = tidy[(tidy["metric"] == metric) & (tidy["column"] == column)]
            for i, (method, own) in enumerate(cells.groupby("method", sort=False)):
                style = {"color": _COLOURS[i % len(_COLOURS)], "marker": _MARKERS[i % 8]}
                drops = own["drop"].astype(float)
                axes.plot(drops, own["value"], markersize=4, label=method, **style)
            axes.spines[["top", "right"]].set_visible(False)
            if column == TABLE_COLUMNS[0]:
                axes.set_title(metric_title(metric, cells["features"].iloc[0]))
            if column == TABLE_COLUMNS[-1]:
                axes.set_xlabel("share of photos hidden")
        line[0].set_ylabel(f"{column} surfaces")
    for metric, axes in zip(METRICS, panels[0], strict=True):
        if metric != "KID":  # unbiased, so it may be negative
            highest = tidy.loc[tidy["metric"] == metric, "value"].max()
            axes.set_ylim(0, 1.05 * highest if highest > 0 else 1)
    first = tidy.iloc[0]
    _entitle(
        figure,
        f"{first['dataset']}, {tidy['houses'].max()} houses, seed {first['seed']}: lower is "
        "better. FID falls with the number of surfaces; compare methods at one drop.",
    )
    with atomic_path(output) as temporary:
        figure.savefig(temporary, dpi=90, metadata={"Software": None})


def _figure(width: float, height: float) -> Figure:
    """Return an empty figure; sizes are in inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _entitle(figure: Figure, title: str) -> None:
    """Put a legend below all panels and a title above them."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    figure.suptitle(title)
