"""Plot of the paper's table: our figures as bars, the published ones as marks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.evaluation.published import METRICS, TABLE_COLUMNS, comparable
from plan2scene.io import atomic_path

if TYPE_CHECKING:
    import pandas as pd

_COLOURS = ("#9aa5b1", "#d9a441", "#6c8ebf", "#3a7d44", "#a4508b", "#c8654f", "#5b5b5b", "#7fc0b0")


def plot_table(tidy: pd.DataFrame, output: str | Path) -> None:
    """Write a PNG of the tidy table of :func:`plan2scene.evaluation.paper_table.paper_table`.

    A panel per metric, a group of bars per column. Published figures are drawn where they are
    of one scale: not where they come from another network.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(17, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    methods = list(dict.fromkeys(tidy["method"]))
    for axes, metric in zip(figure.subplots(1, len(METRICS)), METRICS, strict=True):
        cells = tidy[tidy["metric"] == metric].set_index(["method", "column"])
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
        axes.set_title(metric if network == "none" else f"{metric} ({network})")
        axes.spines[["top", "right"]].set_visible(False)
        if cells["value"].min() >= 0:  # KID may fall below
            axes.set_ylim(bottom=0, top=None if cells["value"].max() > 0 else 1)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    dataset, n = tidy["dataset"].iloc[0], tidy.groupby("column", sort=False)["n"].max()
    counts = ", ".join(f"{name} {count}" for name, count in n.items())
    figure.suptitle(f"{dataset}: lower is better; surfaces: {counts}. Published: Rent3D++.")
    with atomic_path(output) as temporary:
        figure.savefig(temporary, dpi=110, metadata={"Software": None})
