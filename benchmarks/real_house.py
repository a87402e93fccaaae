"""Compare the colours of real houses with true crops, for seen and unseen surfaces.

    python benchmarks/real_house.py WORK HOUSE_FOLDER... [--masks network|true]
        [--configfile FILE ...] [--one FOLDER:floor:living,hall ...] [--brief]

A house folder holds ``scene/*.scene.json``, ``photo_assignments/*.photoroom.csv``, ``photos/``,
``unobserved_photos.json`` and under ``gt/`` label masks of the photos (1 floor, 2 wall, 3 ceiling,
anything else other) and true crops ``{room}/{surface}_{k}.png`` with ``index.csv`` (``room_id,
surface, k, medoid``). The workflow makes the houses in WORK, all as one data set; nothing is
written into the house folders. Configuration files of --configfile override all others.

A tile is compared with the medoid true crop of its surface: CIEDE2000 of the median colours, both
without any gain and after one gain (three factors on linear RGB, the median over surfaces) for all
tiles of a house; and COLOR as in the paper. Baselines without gain: "others" is the mean colour of
the true crops of the same kind in the other rooms; "crop" is another true crop; "house" is the mean
colour of that kind in the house's photos at that drop. Spread: CIEDE2000 of a surface's colour in
each photo to its mean over photos. Burnt: share of the tiles' pixels at 250 or more in all
channels, minus that share in the photos' own crops of the surface.
"""

from __future__ import annotations

import argparse
import csv
import datetime
import json
import os
import platform
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from plan2scene.colour import (
    delta_e_2000,
    linear_to_srgb,
    median_colour,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.house import SURFACES
from plan2scene.images import image_from_bytes, metric_image, read_image, write_png
from plan2scene.io import read_json, read_parquet
from plan2scene.metrics.color_freq_tile import color_distance

REPOSITORY = Path(__file__).parents[1]
DATASET, METHOD = "real", "exemplar"
DROPS = ("0.0", "0.6")
BURNT = 250


@dataclass(frozen=True)
class Truth:
    """A house folder with the house's id and true crops (128, 128, 3) uint8 by (room, surface)."""

    folder: Path
    house: str
    medoids: dict[tuple[str, str], np.ndarray]
    further: dict[tuple[str, str], np.ndarray]


def read_truth(folder: Path) -> Truth:
    """Return the true crops of a house folder."""
    house = next(folder.glob("scene/*.scene.json")).name.removesuffix(".scene.json")
    truth = Truth(folder, house, {}, {})
    with (folder / "gt" / "index.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            key = row["room_id"], row["surface"]
            image = read_image(folder / "gt" / key[0] / f"{key[1]}_{row['k']}.png")
            if row["medoid"] == "1":
                truth.medoids[key] = image
            else:
                truth.further.setdefault(key, image)
    return truth


def lay_out(houses: list[Truth], work: Path, masks: str) -> Path:
    """Write the houses as one data set in `work`; return the path of its configuration."""
    root, hidden, rows = work / "data", {}, []
    (root / "photos").mkdir(parents=True, exist_ok=True)
    for truth in houses:
        plan = next(truth.folder.glob("scene/*.scene.json"))
        table = next(truth.folder.glob("photo_assignments/*.photoroom.csv"))
        for source in (plan, table):
            shutil.copy2(source, root / source.name)
        photos = sorted(path.name for path in (truth.folder / "photos").iterdir())
        for name in photos:
            shutil.copy2(truth.folder / "photos" / name, root / "photos" / name)
            if masks == "true":
                stem = f"{Path(name).stem}.png"
                labels = read_image(truth.folder / "gt" / "masks" / stem)[..., 0]
                (work / "masks").mkdir(exist_ok=True)
                write_png(work / "masks" / stem, np.where(labels > 3, 0, labels).astype(np.uint8))
        rows.append([truth.house, "test", plan.name, table.name, "|".join(photos)])
        for drop, names in read_json(truth.folder / "unobserved_photos.json").items():
            hidden.setdefault(drop, []).extend(names)
    (root / "unobserved_photos.json").write_text(json.dumps(hidden))
    lines = ["\t".join(row) for row in [["house", "split", "plan", "assignment", "photos"], *rows]]
    (root / "houses.tsv").write_text("\n".join(lines) + "\n")
    config: dict[str, Any] = {
        "dataset": {"name": DATASET, "root": "data", "table": "houses.tsv", "splits": ["test"]}
    }
    if masks == "true":
        config["photos"] = {"masks": "precomputed", "masks_folder": "masks"}
    (work / "real.yaml").write_text(yaml.safe_dump(config))
    return work / "real.yaml"


def make(houses: list[Truth], work: Path, config: list[Path], jobs: int) -> None:
    """Run the workflow to make all tiles for the comparison."""
    targets = [
        f"results/{DATASET}/drop_{drop}/{METHOD}/{truth.house}/textures"
        for truth in houses
        for drop in DROPS
    ]
    command = [sys.executable, "-m", "snakemake", "-s", str(REPOSITORY / "Snakefile")]
    command += [f"-j{jobs}", "--directory", str(work), "--quiet", "all", "--configfile"]
    command += [str(REPOSITORY / "config" / "config.yaml"), *(str(p.resolve()) for p in config)]
    subprocess.run([*command, "--", *targets], check=True)


def difference(colour: np.ndarray, other: np.ndarray) -> float:
    """Return CIEDE2000 of two sRGB colours (3,) in [0, 1]."""
    return float(delta_e_2000(rgb_to_lab(colour), rgb_to_lab(other)))


def one_gain(pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return factors (3,) on linear RGB: the median over (tile, true crop) pairs."""
    logs = [
        [np.log(np.median(srgb_to_linear(i).reshape(-1, 3), axis=0) + 1e-4) for i in pair]
        for pair in pairs
    ]
    return np.exp(np.median([true - made for made, true in logs], axis=0))


def compared(truth: Truth, results: Path, drop: str) -> pd.DataFrame:
    """Return a row with errors and baselines for each surface with a true crop."""
    folder = results / f"drop_{drop}" / METHOD / truth.house / "textures"
    entries = read_json(folder / "textures.json")["surfaces"]
    made = {k: metric_image(read_image(folder / f"{k[0]}_{k[1]}.png")) for k in truth.medoids}
    gain = one_gain([(made[key], truth.medoids[key]) for key in truth.medoids])
    known, _ = read_parquet(results / f"drop_{drop}" / truth.house / "propagated.parquet")
    known = known[known["observed"]]
    rows = []
    for key, true in truth.medoids.items():
        colour = median_colour(true)
        others = [m for q, m in truth.medoids.items() if q[1] == key[1] and q[0] != key[0]]
        kind = known[known["surface"] == key[1]]
        shown = [e[-3:] for e in (kind if len(kind) else known)["embedding"]]
        mean = np.clip(np.mean(shown, axis=0), 0, 1)
        flat = np.broadcast_to(np.rint(mean * 255).astype(np.uint8), true.shape)
        lit = linear_to_srgb(np.clip(srgb_to_linear(made[key]) * gain, 0, 1))
        lit = np.rint(np.clip(lit, 0, 1) * 255).astype(np.uint8)
        rows.append(
            {
                "room_id": key[0],
                "surface": key[1],
                "observed": entries["/".join(key)]["observed"],
                "tile": median_colour(made[key]),
                "as_is": difference(median_colour(made[key]), colour),
                "one_gain": difference(median_colour(lit), colour),
                "color": color_distance(made[key], true),
                "others": difference(np.mean([i.mean((0, 1)) for i in others], 0) / 255, colour),
                "crop": difference(median_colour(truth.further[key]), colour)
                if key in truth.further
                else np.nan,
                "house": difference(mean, colour),
                "house_color": color_distance(flat, true),
                "burnt": float((made[key].min(axis=2) >= BURNT).mean()),
            }
        )
    return pd.DataFrame(rows)


def light_figures(truth: Truth, results: Path, table: pd.DataFrame) -> dict[str, Any]:
    """Return gains, spread of surface colours over photos (raw and corrected), burnt share."""
    house = results / "houses" / truth.house
    light = read_json(house / "light.json")
    crops, _ = read_parquet(house / "crops.parquet")
    images = [image_from_bytes(data) for data in crops["png"]]
    gains = np.array([light["gains"].get(photo, [1.0] * 3) for photo in crops["photo"]])
    linear = np.stack([srgb_to_linear(median_colour(image)) for image in images])
    crops["burnt"] = [float((image.min(axis=2) >= BURNT).mean()) for image in images]
    spread = {}
    for name, factors in (("raw", 1.0), ("corrected", gains)):
        crops[name] = list(rgb_to_lab(linear_to_srgb(np.minimum(linear * factors, 1.0))))
        values = []
        for _, group in crops.groupby(["room_id", "surface"]):
            seen = [np.mean(list(g[name]), axis=0) for _, g in group.groupby("photo")]
            if len(seen) > 1:
                values += list(
                    delta_e_2000(np.stack(seen), np.tile(np.mean(seen, axis=0), (len(seen), 1)))
                )
        spread[name] = float(np.mean(values))
    photos = crops.groupby(["room_id", "surface"])["burnt"].mean()
    kinds = crops.groupby("surface")["burnt"].max()
    excess = [
        max(0.0, r.burnt - photos.get((r.room_id, r.surface), kinds.get(r.surface, 0.0)))
        for r in table.itertuples()
    ]
    every = np.array(list(light["gains"].values()) or [[1.0] * 3])
    ceilings = rgb_to_lab(np.stack(list(table[table.surface == "ceiling"]["tile"])))
    chroma = np.hypot(ceilings[:, 1], ceilings[:, 2])
    return {
        "gains, median": " ".join(f"{g:.2f}" for g in np.median(every, axis=0)),
        "gains, range": f"{every.min():.2f}-{every.max():.2f}",
        "spread raw": f"{spread['raw']:.2f}",
        "spread corrected": f"{spread['corrected']:.2f}",
        "burnt beyond the photos %": f"{100 * np.mean(excess):.2f}",
        "ceilings' C*, mean and most": f"{chroma.mean():.1f} {chroma.max():.1f}",
    }


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    head = list(rows[0])
    lines = [head, ["---"] * len(head), *([str(row[c]) for c in head] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def colour_rows(
    name: str, table: pd.DataFrame, drop: str, *, brief: bool = False
) -> list[dict[str, Any]]:
    """Return the means over surfaces, by whether photos show them (at this drop) and by kind.

    With hidden photos (drop above 0) only unobserved surfaces count. If `brief`, only the means
    over all surfaces by kind are returned, or with hidden photos that over all unobserved ones.
    """
    rows = []
    columns = ("as_is", "one_gain", "color", "others", "crop", "house", "house_color")
    for seen, label in ((True, "observed"), (False, "unobserved"), (None, "all")):
        for kind in (*SURFACES, "all"):
            part = table if seen is None else table[table.observed == seen]
            part = part if kind == "all" else part[part.surface == kind]
            shown = seen is False if drop != "0.0" else seen is None or not brief
            if len(part) and shown and not (brief and drop != "0.0" and kind != "all"):
                means = [f"{part[c].mean():.2f}" for c in columns]
                row = {"house": name, "hidden": drop, "surfaces": f"{label} {kind}", "n": len(part)}
                rows.append(row | dict(zip(HEADS, means, strict=True)))
    return rows


HEADS = (
    "dE2000",
    "after one gain",
    "COLOR",
    "others",
    "crop",
    "house's mean",
    "COLOR of it",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("houses", type=Path, nargs="+")
    parser.add_argument("--masks", choices=("network", "true"), default="network")
    parser.add_argument("--configfile", type=Path, nargs="*", default=[])
    parser.add_argument("--one", nargs="*", default=[], metavar="HOUSE:SURFACE:ROOM,ROOM")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--brief", action="store_true", help="only the rows that sum up")
    parser.add_argument("--by-surface", action="store_true", help="print every surface too")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    houses = [read_truth(folder) for folder in given.houses]
    config = lay_out(houses, given.work, given.masks)
    make(houses, given.work, [config, *given.configfile], given.jobs)
    results = given.work / "results" / DATASET
    colours, lights = [], []
    for truth in houses:
        tables = {drop: compared(truth, results, drop) for drop in DROPS}
        for drop, table in tables.items():
            colours += colour_rows(truth.house, table, drop, brief=given.brief)
            if given.by_surface:
                print(table.drop(columns="tile").round(2).to_string())
        lights.append({"house": truth.house} | light_figures(truth, results, tables["0.0"]))
        for house, surface, rooms in (item.split(":") for item in given.one):
            if house == truth.house:
                table = tables["0.0"]
                mine = table[(table.surface == surface) & table.room_id.isin(rooms.split(","))]
                labs = rgb_to_lab(np.stack(list(mine["tile"])))
                apart = delta_e_2000(labs[:, None], labs[None]).max()
                print(f"{house}: {surface} of {rooms}: at most {apart:.1f} dE2000 apart\n")
    print(markdown(colours), markdown(lights), sep="\n\n")
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=REPOSITORY, capture_output=True, text=True
    ).stdout.strip()
    today = datetime.datetime.now(datetime.UTC).date()
    print(f"\nMasks: {given.masks}. Commit {commit}, {today}, ", end="")
    print(f"{os.cpu_count()} cores {platform.machine()}, Python {platform.python_version()}.")


if __name__ == "__main__":
    main()
