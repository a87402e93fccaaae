"""Plot of a sweep: a row of panels per column of surfaces, a panel per metric."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.evaluation.aggregate import metric_title
from plan2scene.evaluation.published import METRICS, TABLE_COLUMNS
from plan2scene.io import atomic_path

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_STYLES = (
    ("#7a8794", "o"),
    ("#d9a441", "s"),
    ("#6c8ebf", "^"),
    ("#3a7d44", "D"),
    ("#a4508b", "v"),
    ("#b5651d", "P"),
    ("#2f4858", "X"),
    ("#c23b4b", "<"),
)


def plot_sweep(tidy: pd.DataFrame, output: str | Path) -> None:
    """Write a PNG of the tidy table of a sweep."""
    with atomic_path(output) as temporary:
        sweep_figure(tidy).savefig(temporary, dpi=90, metadata={"Software": None})


def sweep_figure(tidy: pd.DataFrame) -> Figure:
    """Return the tidy table of a sweep as a figure: lower is better in every panel."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(17, 8), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(TABLE_COLUMNS), len(METRICS), sharex=True, sharey="col")
    methods = list(dict.fromkeys(tidy["method"]))
    for column, line in zip(TABLE_COLUMNS, panels, strict=True):
        for metric, axes in zip(METRICS, line, strict=True):
            cells = tidy[(tidy["metric"] == metric) & (tidy["column"] == column)]
            for method, (colour, marker) in zip(methods, _STYLES * len(methods), strict=False):
                own = cells[cells["method"] == method]
                drops = own["drop"].astype(float)
                axes.plot(
                    drops, own["value"], color=colour, marker=marker, markersize=4, label=method
                )
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
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    first = tidy.iloc[0]
    most = tidy["houses"].max()
    figure.suptitle(
        f"{first['dataset']}, {most} houses, seed {first['seed']}: lower is better. FID falls with "
        "the number of surfaces; compare methods at one drop."
    )
    return figure
