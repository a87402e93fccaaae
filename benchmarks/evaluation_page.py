"""Put the sweep, the ablations and a picture of the user study into the docs.

    snakemake -j2 sweep ablation study --configfile config/benchmark.yaml
    python benchmarks/evaluation_page.py results/benchmark

Writes docs/pictures/sweep.png and study.jpg (a picture of the form's first question, by a headless
Chromium), and the text between the two marks of docs/measurements/evaluation.md, with commit and
date.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parents[1] / "docs"
BEGIN, END = "<!-- figures: benchmarks/evaluation_page.py -->", "<!-- end of figures -->"
#: Shares of hidden photos in the page's table.
DROPS = ("0.0", "0.2", "0.4", "0.6", "0.8", "1.0")


def sweep_rows(path: Path, metric: str) -> list[str]:
    """Return one metric over all surfaces as Markdown, a row per method."""
    rows = [row for row in csv.DictReader(path.open()) if row["column"] == "all"]
    cells: dict[str, dict[str, str]] = {}
    for row in rows:
        cells.setdefault(row["method"], {})[row["drop"]] = row[metric]
    lines = [f"| {metric}, all surfaces | " + " | ".join(DROPS) + " |"]
    lines.append("|---" * (len(DROPS) + 1) + "|")
    for method, values in cells.items():
        shown = [f"{float(values[drop]):.3f}" for drop in DROPS]
        lines.append(f"| {method} | " + " | ".join(shown) + " |")
    return lines


def screenshot(page: Path, output: Path) -> None:
    """Write a picture of the form's first question as JPEG."""
    browser = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if browser is None:
        raise SystemExit("no Chromium to draw the study's form with")
    with tempfile.TemporaryDirectory() as name:
        shot = Path(name) / "shot.png"
        command = [browser, "--headless=new", "--no-sandbox", "--hide-scrollbars"]
        command += ["--disable-background-networking", "--window-size=1500,1020"]
        command += [f"--user-data-dir={name}/profile", f"--screenshot={shot}"]
        subprocess.run([*command, page.absolute().as_uri()], check=True, capture_output=True)
        with Image.open(shot) as picture:
            picture.convert("RGB").save(output, quality=82)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results of the data set")
    results = parser.parse_args().results
    tables, pictures = results / "tables", DOCS / "pictures"
    with Image.open(tables / "sweep.png") as plot:
        plot.convert("P", palette=Image.Palette.ADAPTIVE, colors=64).save(
            pictures / "sweep.png", optimize=True
        )
    screenshot(results / "study" / "form.html", pictures / "study.jpg")
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    text = [BEGIN, "![Every metric against the share of hidden photos](../pictures/sweep.png)", ""]
    text += [*sweep_rows(tables / "sweep.csv", "COLOR"), ""]
    text += [(tables / "ablation.md").read_text().rstrip()]
    text += [f"Commit {commit}, {datetime.date.today()}, 2-core x86-64.", END]
    page = DOCS / "measurements" / "evaluation.md"
    old = page.read_text()
    head, tail = old.split(BEGIN)[0], old.split(END)[1]
    page.write_text(head + "\n".join(text) + tail)


if __name__ == "__main__":
    main()
