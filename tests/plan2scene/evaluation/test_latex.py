"""The LaTeX table by value."""

import pandas as pd

from plan2scene.evaluation.latex import latex_table
from plan2scene.evaluation.published import TABLE_COLUMNS, published_value
from plan2scene.metrics.registry import METRICS

VALUES = {
    ("crop", "observed"): (0.0, 0.0, 0.0, 0.0516, 34.66, -0.0104),
    ("synth", "observed"): (0.3294, 0.0157, 0.125, 1.9172, 17.43, 0.2),
    ("medoid_colour", "observed"): (0.3291, 0.0162, 0.25, 2.5, 17.35, -0.0003),
    ("crop", "unobserved"): (0.757, 0.0371, 0.318, 3.302, 35.52, 0.1),
    ("synth", "unobserved"): (0.68, 0.018, 0.364, 8.283, 13.72, 0.4),
    ("medoid_colour", "unobserved"): (float("nan"),) * 6,
}

EXPECTED = r"""% data set demo, seed 0, plan2scene 9.9
% numpy 2.0, scipy 1.12
% lower is better; published values in brackets
\begin{tabular}{lrrrrrr}
\toprule
Method & COLOR & FREQ & SUBS (vgg16) & FID (embedded) & TILE & KID (embedded) \\
\midrule
\multicolumn{7}{l}{Observed ($n = 48$)} \\
crop & 0.000 (0.000) & 0.000 (0.000) & 0.000 (0.000) & 0.052 (0.0) & 34.7 (38.1) & -0.010 \\
synth & \textbf{0.329} (0.431) & \textbf{0.016} (0.035) & \textbf{0.125} (0.350) & \textbf{1.917} (196.1) & \textbf{17.4} (16.4) & 0.200 \\
medoid\_colour & \textbf{0.329} & \textbf{0.016} & 0.250 & 2.500 & \textbf{17.4} & \textbf{0.000} \\
\midrule
\multicolumn{7}{l}{Unobserved ($n = 0$ to $22$)} \\
crop & 0.757 (0.768) & 0.037 (0.026) & \textbf{0.318} (0.345) & \textbf{3.302} (57.2) & 35.5 (40.6) & \textbf{0.100} \\
synth & \textbf{0.680} (0.653) & \textbf{0.018} (0.032) & 0.364 (0.393) & 8.283 (199.4) & \textbf{13.7} (18.6) & 0.400 \\
medoid\_colour & -- & -- & -- & -- & -- & -- \\
\midrule
"""  # noqa: E501


def _tidy():
    networks = {"SUBS": "vgg16", "FID": "embedded", "KID": "embedded"}
    rows = []
    for method in ("crop", "synth", "medoid_colour"):
        for column in TABLE_COLUMNS:
            values = VALUES.get((method, column), (0.5, 0.5, 0.5, 0.5, 0.5, 0.5))
            missing = values[0] != values[0]
            for metric, value in zip(METRICS, values, strict=True):
                rows.append(
                    {
                        "dataset": "demo",
                        "method": method,
                        "column": column,
                        "n": 0 if missing else 22 if column == "unobserved" else 48,
                        "seed": 0,
                        "version": "9.9",
                        "packages": "numpy 2.0, scipy 1.12",
                        "metric": metric,
                        "features": networks.get(metric, "none"),
                        "value": value,
                        "published": published_value(method, column, metric),
                    }
                )
    return pd.DataFrame(rows)


def test_table_by_value():
    text = latex_table(_tidy())
    assert text.startswith(EXPECTED)
    assert text.endswith("\\bottomrule\n\\end{tabular}\n")
    all_rows = text.split("{All ($n = 48$)} \\\\\n")[1].splitlines()
    assert all_rows[0].startswith("crop & \\textbf{0.500} (0.459) & ")
    assert all_rows[2] == (
        "medoid\\_colour" + " & \\textbf{0.500}" * 4 + " & \\textbf{0.5} & \\textbf{0.500} \\\\"
    )


def test_fid_of_the_published_network_has_its_decimals():
    tidy = _tidy()
    tidy.loc[tidy["metric"] == "FID", "features"] = "inception"
    row = next(line for line in latex_table(tidy).splitlines() if line.startswith("synth"))
    assert " & \\textbf{1.9} (196.1) & " in row
    assert "FID (inception)" in latex_table(tidy)
