"""Measure the time of ``plan2scene run`` for a house, on one core and on two.

    python benchmarks/one_house.py --rounds 3

There are two inputs: seven photos of the demo house that has the most photos, and the same house
with 57 photos (copies of these, enlarged to 1024 x 768 as from phones and cameras). A row of the
table is an input and a number of cores: median wall-clock and processor seconds.
"""

from __future__ import annotations

import argparse
import csv
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
DEMO = ROOT / "resources" / "demo"
HEAD = "| photos | size | cores | wall s | processor s |"


def demo_house() -> tuple[Path, list[tuple[str, str]]]:
    """Return the plan of the demo's house with the most photos, and its rows (room, photo)."""
    with (DEMO / "houses.tsv").open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table, delimiter="\t"))
    most = max(rows, key=lambda row: row["photos"].count("|"))
    with (DEMO / most["assignment"]).open(encoding="utf-8") as table:
        listed = [(row["room_id"], row["photo"]) for row in csv.DictReader(table)]
    return DEMO / most["plan"], listed


def make_input(folder: Path, n_photos: int, size: tuple[int, int] | None) -> list[str]:
    """Write a table of `n_photos` and its photos; return the command's arguments for them."""
    plan, listed = demo_house()
    photos = sorted({photo for _, photo in listed})
    (folder / "photos").mkdir(parents=True)
    with (folder / "photos.csv").open("w", newline="", encoding="utf-8") as table:
        writer = csv.writer(table)
        writer.writerow(["room_id", "photo"])
        for k in range(n_photos):
            photo = photos[k % len(photos)]
            with Image.open(DEMO / "photos" / photo) as image:
                image.resize(size or image.size).save(
                    folder / "photos" / f"{k:02d}.jpg", quality=92
                )
            writer.writerows([room, f"{k:02d}.jpg"] for room, shown in listed if shown == photo)
    words = ["--plan", str(plan), "--photos", str(folder / "photos.csv")]
    return [*words, "--photos-dir", str(folder / "photos")]


def took(words: list[str], cores: int) -> tuple[float, float]:
    """Make the house once; return wall-clock and processor seconds."""
    program = [sys.executable, "-c", "from plan2scene_app.cli import main; main()", "run"]
    with tempfile.TemporaryDirectory() as out:
        before, start = os.times(), time.perf_counter()
        command = [*program, *words, "--out", f"{out}/house", "--cores", str(cores), "--quiet"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # the list of its files
        wall, after = time.perf_counter() - start, os.times()
    used = after.children_user + after.children_system
    return wall, used - before.children_user - before.children_system


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    houses = ((7, None), (57, (1024, 768)))
    print(HEAD, "|---" * 5 + "|", sep="\n")
    for n_photos, size in houses:
        with tempfile.TemporaryDirectory() as folder:
            words = make_input(Path(folder), n_photos, size)
            for cores in (1, 2):
                rounds = [took(words, cores) for _ in range(options.rounds)]
                wall, used = (statistics.median(each) for each in zip(*rounds, strict=True))
                shown = "as it is" if size is None else "x".join(map(str, size))
                print(f"| {n_photos} | {shown} | {cores} | {wall:.1f} | {used:.1f} |", flush=True)


if __name__ == "__main__":
    main()
