"""Write the sweep, the ablations and a picture of the user study into the docs.

    snakemake -j2 sweep ablation study --configfile config/benchmark.yaml
    python benchmarks/evaluation_page.py results/benchmark

It writes docs/pictures/sweep.png and study.jpg (a screenshot of the form's first question by a
headless Chromium), and the text between the two marks in docs/measurements/evaluation.md, with
commit and date.
"""

from __future__ import annotations

import argparse
import datetime
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).parents[1] / "docs"
BEGIN, END = "<!-- figures: benchmarks/evaluation_page.py -->", "<!-- end of figures -->"


def of_all_surfaces(table: str) -> str:
    """Return the table of ablations without the rows for observed and unobserved surfaces."""
    lines = table.rstrip().splitlines()
    return "\n".join(ln for ln in lines if "| observed |" not in ln and "| unobserved |" not in ln)


def screenshot(page: Path, output: Path) -> None:
    """Write a screenshot of the form's first question as JPEG."""
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
    text += [of_all_surfaces((tables / "ablation.md").read_text())]
    text += [f"Commit {commit}, {datetime.date.today()}, 2-core x86-64.", END]
    page = DOCS / "measurements" / "evaluation.md"
    old = page.read_text()
    head, tail = old.split(BEGIN)[0], old.split(END)[1]
    page.write_text(head + "\n".join(text) + tail)


if __name__ == "__main__":
    main()
