"""Make GLBs of many small houses on a SLURM cluster on this machine, unattended.

    python benchmarks/slurm_houses.py --houses 200 --batch 40 --keep slurm_houses.log
    python benchmarks/slurm_houses.py --summary slurm_houses.log

Each house is the example plan with one photo of the demo, under its own name (links). Each batch is
one run of `snakemake --profile profiles/slurm` with the houses of the batch in `dataset.houses`.
Every minute a line of JSON is added to the log: the number of houses and how the submissions ended.
A row of the table comes from one such line: submissions, retries, and the time that a submission
takes in addition to its jobs. Needs root and Debian's slurm-wlm.
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
import threading
import time
from collections import Counter
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "slurm"))

from cluster import Cluster, cluster  # noqa: E402

PLAN = ROOT / "resources" / "examples" / "plan.json"
PHOTO = ROOT / "resources" / "demo" / "photos" / "flat_test_002_00.jpg"
#: Columns of the table, computed by `row` from the values of `state`.
HEAD = (
    "houses",
    "GLBs",
    "submissions",
    "ended",
    "tried again",
    "requeued",
    "jobs",
    "wall s",
    "s a submission",
    "of it jobs",
    "beside each job, s",
)


def make_data_set(root: Path, names: list[str]) -> None:
    """Write the data set: a plan, a photo and its table for each house."""
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


def run_batch(folder: Path, names: list[str], made: Cluster) -> None:
    """Make the houses of a batch."""
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    config["dataset"] |= {"name": "small", "root": "data", "houses": names}
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    profile = ROOT / "workflow" / "profiles" / "slurm"
    command = ["setpriv", "--pdeathsig", "KILL"]  # it is killed when this process ends
    command += [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
    command += ["--directory", str(folder), "--configfile", str(folder / "config.yaml")]
    command += ["--profile", str(profile), "--quiet", "rules", "--"]
    command += [f"results/small/houses/{name}/house.glb" for name in names]
    with (folder / "snakemake.log").open("a") as log:
        environment = made.environment | {"OMP_NUM_THREADS": "1"}
        done = subprocess.run(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log, check=False
        )
    if done.returncode != 0:
        print(f"exit code {done.returncode}: {(folder / 'snakemake.log').read_text()[-2000:]}")


def seconds(job: dict[str, str]) -> float:
    """Return the running time of a submission in seconds."""
    start, end = (datetime.datetime.fromisoformat(job[key]) for key in ("StartTime", "EndTime"))
    return (end - start).total_seconds()


def state(folder: Path, houses: int, ended: list[dict[str, str]], wall: float) -> dict[str, float]:
    """Return the present state: counts of houses, submissions and jobs, and their seconds."""
    files = list((folder / "logs").glob("*/benchmarks/**/*.tsv"))
    took = [float(path.read_text().splitlines()[1].split("\t")[0]) for path in files]
    path = folder / "snakemake.log"
    log = path.read_text() if path.exists() else ""
    return {
        "houses": houses,
        "GLBs": len(list((folder / "results" / "small" / "houses").glob("*/house.glb"))),
        "submissions": log.count("submitted with SLURM jobid"),
        "ended": dict(Counter(job["JobState"] for job in ended)),
        "tried again": log.count("Trying to restart job"),
        "requeued": len(ended) - len({job["JobId"] for job in ended}),
        "jobs": len(took),
        "wall": wall,
        "submission seconds": sum(map(seconds, ended)),
        "job seconds": sum(took),
    }


def row(found: dict) -> str:
    """Return the table's row for a state."""
    whole, inside = found["submission seconds"], found["job seconds"]
    n_ended = sum(found["ended"].values())
    states = ", ".join(f"{number} {name}" for name, number in found["ended"].items())
    cells = [found["houses"], found["GLBs"], found["submissions"], states]
    cells += [found[key] for key in ("tried again", "requeued", "jobs")]
    cells += [f"{found['wall']:.0f}", f"{whole / max(n_ended, 1):.1f}"]
    cells += [f"{100 * inside / max(whole, 1):.0f} %"]
    cells += [f"{max(whole - inside, 0) / max(found['jobs'], 1):.1f}"]
    return f"| {' | '.join(map(str, cells))} |"


def summary(kept: Path) -> str:
    """Return the table of a log: a row for the end of each batch, and the last line."""
    lines = [json.loads(line) for line in kept.read_text().splitlines()]
    wanted = [line for line in lines if line.get("batch done")] or []
    if lines and (not wanted or lines[-1] is not wanted[-1]):
        wanted.append(lines[-1])
    head = [f"| {' | '.join(HEAD)} |", "|" + "---|" * len(HEAD)]
    return "\n".join([*head, *map(row, wanted)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--houses", type=int, default=200)
    parser.add_argument("--batch", type=int, default=40)
    parser.add_argument("--minutes", type=float, default=1e9, help="start no batch after these")
    parser.add_argument("--memory", type=int, default=12000, help="MB that the node claims to have")
    parser.add_argument("--keep", type=Path, default=Path("slurm_houses.log"))
    parser.add_argument("--summary", type=Path, help="only the table of what was kept")
    options = parser.parse_args()
    if options.summary:
        print(summary(options.summary))
        return
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    names = [f"home_{number:04d}" for number in range(options.houses)]
    with tempfile.TemporaryDirectory() as made_in, cluster(memory=options.memory) as made:
        folder, begun, began = Path(made_in), 0, time.perf_counter()
        make_data_set(folder / "data", names)

        def keep(**further: bool) -> None:
            found = state(folder, begun, made.finished(), time.perf_counter() - began)
            with options.keep.open("a") as log:
                log.write(json.dumps(found | further) + "\n")

        over = threading.Event()

        def look() -> None:
            while not over.wait(60):
                keep()

        threading.Thread(target=look, daemon=True).start()
        while begun < len(names) and time.perf_counter() - began < 60 * options.minutes:
            batch = names[begun : begun + options.batch]
            begun += len(batch)
            run_batch(folder, batch, made)
            keep(**{"batch done": True})
        over.set()
    print(summary(options.keep))


if __name__ == "__main__":
    main()
