"""The sweep's plot: a panel per metric and column of surfaces, nothing cut off."""

import pandas as pd

from plan2scene.evaluation.plot import sweep_figure
from plan2scene.evaluation.tables import TABLE_COLUMNS
from plan2scene.metrics.registry import METRICS


def test_every_value_lies_within_its_panel_and_methods_differ():
    methods = [f"m{k}" for k in range(8)]
    rows = [
        {
            "dataset": "d",
            "houses": 2,
            "seed": 0,
            "method": method,
            "column": column,
            "drop": drop,
            "metric": metric,
            "features": "none",
            # Unobserved surfaces, drawn later, have the largest values.
            "value": (k + 1) * (10.0 if column == "unobserved" else 1.0),
        }
        for k, method in enumerate(methods)
        for column in TABLE_COLUMNS
        for metric in METRICS
        for drop in ("0.0", "1.0")
    ]
    figure = sweep_figure(pd.DataFrame(rows))
    assert len(figure.axes) == len(METRICS) * len(TABLE_COLUMNS)
    for axes in figure.axes:
        low, high = axes.get_ylim()
        shown = [value for line in axes.lines for value in line.get_ydata()]
        assert low <= min(shown) and max(shown) <= high
        assert len({(line.get_color(), line.get_marker()) for line in axes.lines}) == len(methods)
