"""Many small houses, plan and photo to GLB, on a SLURM of this machine, without a hand.

    python benchmarks/slurm_houses.py --houses 200 --batch 20

Each house is the example plan with one photo of the demo under a name of its own (links). Every
batch is one `snakemake --profile profiles/slurm` with the houses of it in `dataset.houses`. Printed
are what was submitted, how it ended and what a submission costs beside its jobs. Wants root and
Debian's slurm-wlm.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "slurm"))

from cluster import Cluster, cluster  # noqa: E402

PLAN = ROOT / "resources" / "examples" / "plan.json"
PHOTO = ROOT / "resources" / "demo" / "photos" / "flat_test_002_00.jpg"
HEAD = ("houses", "GLBs", "submissions", "not COMPLETED", "wall s", "s a submission", "of it jobs")


def make_data_set(root: Path, names: list[str]) -> None:
    """Lay the data set: a plan, a photo and its table for each house."""
    rows = ["\t".join(("house", "split", "plan", "assignment", "photos"))]
    for folder in ("plans", "photos", "tables"):
        (root / folder).mkdir(parents=True)
    for name in names:
        os.link(PLAN, root / "plans" / f"{name}.json")
        os.link(PHOTO, root / "photos" / f"{name}.jpg")
        (root / "tables" / f"{name}.csv").write_text(f"room_id,photo\nliving,{name}.jpg\n")
        paths = (f"plans/{name}.json", f"tables/{name}.csv", f"{name}.jpg")
        rows.append("\t".join((name, "test", *paths)))
    (root / "houses.tsv").write_text("\n".join(rows) + "\n")


def run_batch(folder: Path, names: list[str], made: Cluster) -> float:
    """Make the houses of a batch; return the seconds it took."""
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    config["dataset"] |= {"name": "small", "root": "data", "houses": names}
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    command += ["--directory", str(folder), "--configfile", str(folder / "config.yaml")]
    command += [
        "--profile",
        str(ROOT / "workflow" / "profiles" / "slurm"),
        "--quiet",
        "rules",
        "--",
    ]
    command += [f"results/small/houses/{name}/house.glb" for name in names]
    began = time.perf_counter()
    with (folder / "snakemake.log").open("a") as log:
        environment = made.environment | {"OMP_NUM_THREADS": "1"}
        done = subprocess.run(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log, check=False
        )
    if done.returncode != 0:
        print(f"exit code {done.returncode}: {(folder / 'snakemake.log').read_text()[-2000:]}")
    return time.perf_counter() - began


def seconds(job: dict[str, str]) -> float:
    """Return how long a submission ran."""
    start, end = (datetime.datetime.fromisoformat(job[key]) for key in ("StartTime", "EndTime"))
    return (end - start).total_seconds()


def job_seconds(folder: Path) -> float:
    """Return the wall seconds of all jobs of the workflow."""
    files = (folder / "logs").glob("*/benchmarks/**/*.tsv")
    return sum(float(path.read_text().splitlines()[1].split("\t")[0]) for path in files)


def row(folder: Path, houses: int, ended: list[dict[str, str]], wall: float) -> str:
    """Return the row of the table after some batches."""
    glbs = len(list((folder / "results" / "small" / "houses").glob("*/house.glb")))
    bad = sum(job["JobState"] != "COMPLETED" for job in ended)
    whole = sum(seconds(job) for job in ended)
    cells = [houses, glbs, len(ended), bad, f"{wall:.0f}", f"{whole / max(len(ended), 1):.1f}"]
    cells.append(f"{100 * job_seconds(folder) / max(whole, 1):.0f} %")
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--houses", type=int, default=200)
    parser.add_argument("--batch", type=int, default=50)
    parser.add_argument("--minutes", type=float, default=1e9, help="start no batch after these")
    parser.add_argument("--memory", type=int, default=6000, help="MB that the node claims to have")
    parser.add_argument("--keep", type=Path, help="where the submissions' list is kept")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    names = [f"home_{number:04d}" for number in range(options.houses)]
    print("|", " | ".join(HEAD), "|\n|", "---|" * len(HEAD), sep="", flush=True)
    with tempfile.TemporaryDirectory() as made_in, cluster(memory=options.memory) as made:
        folder = Path(made_in)
        make_data_set(folder / "data", names)
        wall = 0.0
        for first in range(0, len(names), options.batch):
            if wall > 60 * options.minutes:
                break
            batch = names[first : first + options.batch]
            wall += run_batch(folder, batch, made)
            print(row(folder, first + len(batch), made.finished(), wall), flush=True)
            if options.keep:
                options.keep.write_text(json.dumps(made.finished(), indent=0))


if __name__ == "__main__":
    main()
