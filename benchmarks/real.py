"""Print all figures of real flats: locations, light, crops and materials, unseen surfaces.

    python benchmarks/real.py WORK FLAT... [--masks network true] [--seeds 0 1 2]

FLAT is a house folder as for `real_house.py`, with ``gt/cameras.csv`` as for `locate.py`. The
scripts for single measurements run one after the other in WORK and print their tables. For each
kind of masks, the whole command runs with every seed, with the first seed last; locations, errors
by surface and predictors use the results of that seed. Tables of windows, substances and materials
are printed for the flats that are in `windows.csv` and `substances.csv`.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import yaml
from real_house import DATASET
from substances import read_seen

HERE = Path(__file__).parent
SUBSTANCES, WINDOWS = HERE / "substances.csv", HERE / "windows.csv"


def flats_of(table: Path) -> set[str]:
    """Return the flats in a CSV of judgements."""
    with table.open(newline="") as file:
        return {row["flat"] for row in csv.DictReader(file)}


def one_floors() -> dict[str, list[str]]:
    """Return the groups of floors of one substance in each flat, for `real_house.py --one`.

    In the flats of the table, floors of one substance are one material.
    """
    rooms: dict[tuple[str, str], list[str]] = {}
    for (flat, room, surface), substance in read_seen(SUBSTANCES).items():
        if surface == "floor":
            rooms.setdefault((flat, substance), []).append(room)
    found: dict[str, list[str]] = {}
    for (flat, _), names in rooms.items():
        if len(names) > 1:
            found.setdefault(flat, []).append(f"{flat}:floor:{','.join(names)}")
    return found


def configuration(work: Path, name: str, values: dict[str, object]) -> Path:
    """Write a configuration file with the values of one run; return its path."""
    path = work / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(values))
    return path


def whole_command(
    work: Path, flats: list[Path], masks: str, seeds: list[int]
) -> Iterator[tuple[str, list[str]]]:
    """Yield headings and commands that make and measure the flats with one kind of masks."""
    groups = one_floors()
    one = [group for flat in flats for group in groups.get(flat.name, ())]
    folders = [str(flat) for flat in flats]
    shared = ["real_house.py", str(work / masks), *folders, "--masks", masks]
    shared += ["--brief", *(["--one", *one] if one else [])]
    title = f"Whole command, {masks} masks"
    for seed in reversed(seeds):
        own = configuration(work, f"seed_{seed}", {"seed": seed})
        yield f"{title}, seed {seed}", [*shared, "--configfile", str(own)]
    yield f"By surface, {masks} masks", ["real_surfaces.py", str(work / masks), *folders]


def commands(
    work: Path, flats: list[Path], masks: list[str], seeds: list[int]
) -> Iterator[tuple[str, list[str]]]:
    """Yield the heading and the command (script and arguments) of every table."""
    folders = [str(flat) for flat in flats]
    for kind in masks:
        yield from whole_command(work, flats, kind, seeds)
    results = work / masks[0] / "results" / DATASET
    named = [option for flat in folders for option in ("--flat", flat)]
    yield "Places", ["locate.py", str(results), *named]
    if seen := [str(flat) for flat in flats if flat.name in flats_of(WINDOWS)]:
        yield "Verdicts on windows", ["windows.py", *seen, "--masks", "true", "network"]
    if seen := [str(flat) for flat in flats if flat.name in flats_of(SUBSTANCES)]:
        yield "Substances", ["substances.py", str(SUBSTANCES), *seen]
        for kind in masks:
            materials = work / kind / "results" / DATASET
            yield f"Materials, {kind} masks", ["real_materials.py", str(materials), *seen]
    unseen = ["real_propagation.py", *folders, "--work", str(work / masks[0])]
    yield "Unseen surfaces", unseen


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("flats", type=Path, nargs="+")
    parser.add_argument(
        "--masks", nargs="+", choices=("network", "true"), default=["network", "true"]
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    given = parser.parse_args()
    for heading, command in commands(given.work, given.flats, given.masks, given.seeds):
        print(f"\n## {heading}\n", flush=True)
        script = str(HERE / command[0])
        subprocess.run([sys.executable, script, *command[1:]], check=True)


if __name__ == "__main__":
    main()
