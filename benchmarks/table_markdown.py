"""Print a paper_table.csv as Markdown, with machine, date and commit, for the docs.

python benchmarks/table_markdown.py results/demo/tables/paper_table.csv
"""

import csv
import datetime
import os
import platform
import subprocess
import sys
from pathlib import Path

from plan2scene.metrics.registry import METRICS


def main(path: Path) -> None:
    rows = list(csv.DictReader(path.open(encoding="utf-8")))
    # "SUBS (network)", but not "SUBS published".
    figures = [name for name in rows[0] if name.split(" (")[0] in METRICS]
    print("| method | surfaces | n | " + " | ".join(figures) + " |")
    print("|---" * (3 + len(figures)) + "|")
    for row in rows:
        cells = []
        for name in figures:
            published = row[f"{name.split()[0]} published"]
            known = "" if published == "none" else f" ({published})"
            cells.append(f"{float(row[name]):.3f}{known}")
        print(f"| {row['method']} | {row['column']} | {row['n']} | " + " | ".join(cells) + " |")
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    print(
        f"\nPublished values (other data, other feature networks) in brackets. Data set "
        f"{rows[0]['dataset']}, {rows[0]['houses']} houses, seed {rows[0]['seed']}; "
        f"commit {commit}, "
        f"{datetime.date.today()}, {os.cpu_count()} cores, Python {platform.python_version()}."
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
