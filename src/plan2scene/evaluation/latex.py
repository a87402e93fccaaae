"""A table as LaTeX for a paper: package ``booktabs`` only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from plan2scene.evaluation.aggregate import metric_title
from plan2scene.evaluation.published import TABLE_COLUMNS
from plan2scene.metrics.registry import METRICS

if TYPE_CHECKING:
    import pandas as pd

#: Decimals of FID by the embedded network, whose figures are small.
_SMALL_FID = 3
#: Crop's observed surfaces are compared with the very crop that they show: never the best.
_COMPARED_WITH_ITSELF = ("crop", "observed")


def latex_table(tidy: pd.DataFrame, notes: Sequence[str] = ()) -> str:
    """Return a ``tabular`` of a table of :func:`.aggregate.tidy_table`.

    A group of rows per column of the paper (observed, unobserved, all), a row per method. The
    best value of a group is bold, a published one follows in brackets, and ``--`` stands where no
    surface counts. What the table was made of, and `notes`, are in comments above it.
    """
    first = tidy.iloc[0]
    networks = tidy.drop_duplicates("metric").set_index("metric")["features"]
    heads = [metric_title(name, networks[name]) for name in METRICS]
    lines = [
        f"% data set {first['dataset']}, seed {first['seed']}, plan2scene {first['version']}",
        f"% {first['packages']}",
        "% lower is better; published values in brackets",
        *(f"% {note}" for note in notes),
        f"\\begin{{tabular}}{{l{'r' * len(METRICS)}}}",
        "\\toprule",
        " & ".join(["Method", *map(_escaped, heads)]) + " \\\\",
    ]
    for column in TABLE_COLUMNS:
        group = tidy[tidy["column"] == column]
        head = f"{column.capitalize()} ({_counts(group)})"
        lines += ["\\midrule", f"\\multicolumn{{{len(METRICS) + 1}}}{{l}}{{{head}}} \\\\"]
        cells = {name: _cells(group[group["metric"] == name]) for name in METRICS}
        for method in dict.fromkeys(group["method"]):
            row = [_escaped(method), *(cells[name][method] for name in METRICS)]
            lines.append(" & ".join(row) + " \\\\")
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}", ""])


def _counts(group: pd.DataFrame) -> str:
    """Return ``n = 48``, or the range where methods differ."""
    low, high = group["n"].min(), group["n"].max()
    return f"$n = {low}$" if low == high else f"$n = {low}$ to ${high}$"


def _cells(cells: pd.DataFrame) -> dict[str, str]:
    """Return the text of each method's cell in one column of one metric."""
    texts, shown = {}, {}
    for cell in cells.itertuples():
        small = cell.metric == "FID" and cell.features != "inception"
        decimals = _SMALL_FID if small else METRICS[cell.metric].decimals
        rounded = round(cell.value, decimals) + 0.0  # never -0.000
        text = f"{rounded:.{decimals}f}" if cell.value == cell.value else "--"
        published = f" ({cell.published:.{METRICS[cell.metric].decimals}f})"
        texts[cell.method] = (text, published if cell.published == cell.published else "")
        if text != "--" and (cell.method, cell.column) != _COMPARED_WITH_ITSELF:
            shown[cell.method] = float(text)
    best = min(shown.values(), default=None)
    return {
        method: (f"\\textbf{{{text}}}" if method in shown and shown[method] == best else text)
        + rest
        for method, (text, rest) in texts.items()
    }


def _escaped(text: str) -> str:
    return text.replace("_", "\\_")
