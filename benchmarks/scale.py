"""Measure the cost of planning the workflow for N houses: time and memory of `snakemake -n all`.

    python benchmarks/scale.py --houses 6 100 1000 5000 --finished 1000

Each data set repeats the demo's houses under other names; its files are links. In a finished run
the outputs are empty files that `snakemake --touch` has marked as made, with the records of every
job. Its row measures another `snakemake -n all`, which finds nothing to do. Linux only (/proc).
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
DEMO = ROOT / "resources" / "demo"
COLUMNS = ("house", "split", "plan", "assignment", "photos")


@dataclass(frozen=True)
class Cost:
    """The cost of a command: wall-clock and processor seconds, peak MiB of one process."""

    wall: float
    processor: float
    memory: float


def make_data_set(root: Path, n_houses: int) -> None:
    """Write a data set of `n_houses` under `root`; photos, plans and tables are links."""
    lines = (DEMO / "houses.tsv").read_text().splitlines()
    header = lines[0].split("\t")
    demo = [dict(zip(header, line.split("\t"), strict=True)) for line in lines[1:]]
    hidden = json.loads((DEMO / "unobserved_photos.json").read_text())
    copies: dict[str, list[str]] = {drop: [] for drop in hidden}
    rows = ["\t".join(COLUMNS)]
    for number in range(n_houses):
        old = demo[number % len(demo)]
        name = f"home_{number:06d}"
        row = {"house": name, "split": old["split"], "photos": ""}
        for key, suffix in (("plan", ".scene.json"), ("assignment", ".photoroom.csv")):
            row[key] = ""
            if old[key]:
                row[key] = f"{Path(old[key]).parent}/{name}{suffix}"
                _link(DEMO / old[key], root / row[key])
        photos = [photo for photo in old["photos"].split("|") if photo]
        for photo in photos:
            _link(DEMO / "photos" / photo, root / "photos" / f"{name}_{photo}")
        row["photos"] = "|".join(f"{name}_{photo}" for photo in photos)
        for drop, names in hidden.items():
            copies[drop] += [f"{name}_{photo}" for photo in photos if photo in names]
        rows.append("\t".join(row[key] for key in COLUMNS))
    (root / "houses.tsv").write_text("\n".join(rows) + "\n")
    (root / "unobserved_photos.json").write_text(json.dumps(copies, indent=1) + "\n")


def _link(source: Path, target: Path) -> None:
    """Link one file to another: a hard link if the file system can, else a symbolic link."""
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.link(source, target)
    except OSError:
        target.symlink_to(source)


def make_config(folder: Path) -> Path:
    """Write the configuration of the data set `data` in `folder`."""
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    config["dataset"] |= {"name": "scale", "root": "data"}
    path = folder / "config.yaml"
    path.write_text(yaml.safe_dump(config))
    return path


def snakemake(folder: Path, *arguments: str) -> tuple[Cost, str]:
    """Run Snakemake in `folder`; return its cost and its output."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    command += ["--directory", str(folder), "--configfile", str(folder / "config.yaml")]
    command += ["--workflow-profile", str(ROOT / "workflow" / "profiles" / "default")]
    with tempfile.TemporaryFile("w+") as printed:
        start = time.perf_counter()
        process = subprocess.Popen(
            [*command, "--cores", "2", *arguments], stdout=printed, stderr=subprocess.STDOUT
        )
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        printed.seek(0)
        text = printed.read()
    if status != 0:
        sys.exit(text[-3000:])
    return Cost(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024), text


def n_jobs(text: str) -> int:
    """Return the number of jobs in the output of a dry run; 0 if there is nothing to do."""
    totals = [line.split() for line in text.splitlines() if line.startswith("total ")]
    return int(totals[-1][1]) if totals else 0


def finish(folder: Path) -> None:
    """Make every output as an empty file, and let Snakemake mark them as made."""
    _, text = snakemake(folder, "--dry-run", "all")
    for line in text.splitlines():
        if line.strip().startswith("output: "):
            for name in line.split(": ", 1)[1].split(", "):
                path = folder / name.strip()
                path.parent.mkdir(parents=True, exist_ok=True)
                if path.suffix:
                    path.touch()
                else:
                    path.mkdir(exist_ok=True)
    snakemake(folder, "--touch", "all")


def row(houses: int, what: str, jobs: int, cost: Cost) -> str:
    """Return a row of the table."""
    cells = [f"{houses:,}", what, f"{jobs:,}", f"{cost.wall:.1f}", f"{cost.processor:.1f}"]
    return "| " + " | ".join([*cells, f"{cost.memory:.0f}"]) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--houses", type=int, nargs="*", default=[6, 100, 1000, 5000])
    parser.add_argument("--finished", type=int, nargs="*", default=[1000])
    parser.add_argument("--folder", type=Path, help="default: a temporary one")
    options = parser.parse_args()
    print("| houses | run | jobs | wall s | processor s | peak MiB |", flush=True)
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        for houses in sorted({*options.houses, *options.finished}):
            folder = Path(name) / str(houses)
            make_data_set(folder / "data", houses)
            make_config(folder)
            if houses in options.houses:
                cost, text = snakemake(folder, "--dry-run", "--quiet", "rules", "--", "all")
                print(row(houses, "planned", n_jobs(text), cost), flush=True)
            if houses in options.finished:
                finish(folder)
                cost, text = snakemake(folder, "--dry-run", "all")
                print(row(houses, "finished", n_jobs(text), cost), flush=True)
    made = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    print(f"\n{datetime.date.today()}, {os.cpu_count()} cores, {platform.machine()}, commit {made}")


if __name__ == "__main__":
    main()
