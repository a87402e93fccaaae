"""Make the paper's table and the errors against the truth, with their spread over seeds.

    python benchmarks/seeds.py run results/benchmark data/benchmark/truth/test --seeds 2 1 0
        --configfile config/config.yaml config/benchmark.yaml
    python benchmarks/seeds.py page results/benchmark

A seed changes crops, noise and library tiles; houses, photos and hidden photos stay those of the
data set. ``run`` makes the table for one seed after another in the same results folder (the files
of the last seed stay), and writes ``tables/seeds/{seed}.json``: table, errors against the true
materials and seconds. ``page`` writes means and standard deviations (over the seeds, n - 1) to
docs/measurements/benchmark.md, between its two marks.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from truth import error_rows

from plan2scene.metrics.registry import METRICS

PAGE = Path(__file__).parents[1] / "docs" / "measurements" / "benchmark.md"
BEGIN, END = "<!-- figures: benchmarks/seeds.py -->", "<!-- end of figures -->"


def record(results: Path, truth: Path, seed: int, seconds: float) -> None:
    """Write the table of a seed, its errors against the truth and its seconds as JSON."""
    with (results / "tables" / "paper_table.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    if {row["seed"] for row in table} != {str(seed)}:
        raise SystemExit(f"the table in {results} is not of seed {seed}")
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    kept = {"table": table, "truth": error_rows(truth, results), "seconds": seconds}
    output = results / "tables" / "seeds" / f"{seed}.json"
    output.parent.mkdir(exist_ok=True)
    output.write_text(json.dumps(kept | {"commit": commit}, indent=1))


def run(given: argparse.Namespace) -> None:
    """Make the table for every seed."""
    target = str(given.results / "tables" / "paper_table.csv")
    for seed in given.seeds:
        start = time.time()
        command = ["snakemake", f"-j{given.jobs}", target, "--configfile", *given.configfile]
        subprocess.run([*command, "--config", f"seed={seed}"], check=True)
        record(given.results, given.truth, seed, time.time() - start)


def spread(rows: Sequence[Mapping[str, Any]], name: str, digits: int) -> str:
    """Return "mean±deviation" of a figure over the rows of all seeds."""
    values = [float(row[name]) for row in rows]
    deviation = f"±{np.std(values, ddof=1):.{digits}f}" if len(values) > 1 else ""
    return f"{np.mean(values):.{digits}f}{deviation}"


def table_lines(seeds: Sequence[dict[str, Any]]) -> list[str]:
    """Return the paper's table as Markdown, with a column of errors to the true materials."""
    first = seeds[0]["table"]
    figures = [name for name in first[0] if name.split(" (")[0] in METRICS]
    titles = ["method", "surfaces", "n", *figures, "median dE2000 to the truth"]
    lines = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    for i, row in enumerate(first):
        counts = "/".join(dict.fromkeys(seed["table"][i]["n"] for seed in seeds))
        cells = []
        for name in figures:
            digits = 1 if name.startswith("TILE") else 2 if name.startswith("FID") else 3
            cells.append(spread([seed["table"][i] for seed in seeds], name, digits))
        kind = (row["method"], row["column"])
        true = [r for seed in seeds for r in seed["truth"] if (r["method"], r["column"]) == kind]
        cells.append(spread(true, "difference", 1) if true else "-")
        lines.append(f"| {row['method']} | {row['column']} | {counts} | {' | '.join(cells)} |")
    return lines


def page(results: Path) -> None:
    """Write the figures into the page of the docs."""
    seeds = {p.stem: json.loads(p.read_text()) for p in (results / "tables" / "seeds").iterdir()}
    names = sorted(seeds, key=int)
    kept = [seeds[name] for name in names]
    minutes = ", ".join(f"{seed['seconds'] / 60:.0f}" for seed in kept)
    commits = ", ".join(dict.fromkeys(seed["commit"] for seed in kept))
    text = [
        BEGIN,
        *table_lines(kept),
        "",
        f"{kept[0]['table'][0]['houses']} houses, seeds {', '.join(names)}, {minutes} minutes; "
        f"commit {commits}, {datetime.date.today()}, {os.cpu_count()} cores "
        f"{platform.machine()}, Python {platform.python_version()}.",
        END,
    ]
    old = PAGE.read_text()
    PAGE.write_text(old.split(BEGIN)[0] + "\n".join(text) + old.split(END)[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    running = commands.add_parser("run")
    running.add_argument("results", type=Path, help="results of the data set")
    running.add_argument("truth", type=Path, help="folder with a folder of truth per house")
    running.add_argument("--seeds", type=int, nargs="+", default=[2, 1, 0])
    running.add_argument("--configfile", nargs="+", required=True)
    running.add_argument("--jobs", type=int, default=2)
    commands.add_parser("page").add_argument("results", type=Path)
    given = parser.parse_args()
    if given.command == "run":
        run(given)
    else:
        page(given.results)


if __name__ == "__main__":
    sys.exit(main())
