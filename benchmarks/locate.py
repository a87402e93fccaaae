"""Measure how well photos are located in the plan: headings, share located, position errors.

Below the table are the true ceiling heights, and those that photos give without the plan's.

    python benchmarks/locate.py RESULTS --synthetic ROOT [--split test] [--masks own truth]
    python benchmarks/locate.py RESULTS --flat FOLDER [--flat FOLDER ...] [--masks own truth]

``--without-rooms`` finds the rooms of the photos, too, as for a photo table without rooms;
``--without-windows`` removes the windows from the plans, because many plans draw none.

RESULTS (``results/{dataset}``) has the houses' scene.json and masks; only the location is computed
anew. ROOT is a synthetic data set with truth (``docs/conventions.md``). A flat's FOLDER, named as
its house, has ``gt/cameras.csv`` (photo, room_id, yaw_deg, x, y, z; forward is (cos, sin) of the
yaw in (x, z)) and ``gt/masks`` (0 not known, 1 floor, 2 wall, 3 ceiling, 4 door or window).
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from PIL import Image

from plan2scene.house import DEFAULT_HEIGHT, House
from plan2scene.io import read_json
from plan2scene.photos.locate.likelihood import OPENING
from plan2scene.photos.locate.locate_photos import Shot, locate_shots, read_shots
from plan2scene.photos.locate.pose import LOCATED
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.usual_windows import with_usual_windows
from plan2scene_app.heights.ceilings import ceiling_height, with_ceilings

#: A heading is right if its error is smaller than this, degrees.
RIGHT_DEG = 30.0
UNKNOWN = 255


@dataclass(frozen=True)
class Truth:
    """The true pose of a photo: room, azimuth of the view (radians), position; and its mask."""

    room_id: str
    azimuth: float
    position: tuple[float, float, float]
    mask: Path
    #: Value of the true mask -> label of the library.
    values: Mapping[int, int]


@dataclass(frozen=True)
class Found:
    """The result for a photo; NaN and 0 if it has no pose. `right`: room and heading are right."""

    photo: str
    located: float
    right: bool
    error_m: float


def synthetic_truth(root: Path, split: str) -> Iterator[tuple[str, dict[str, Truth]]]:
    """Yield the houses of a split with the truth of their photos."""
    for folder in sorted((root / "truth" / split).iterdir()):
        truths = {}
        for photo, value in read_json(folder / "cameras.json").items():
            ahead = np.array(value["rotation"])[2]
            azimuth = float(np.arctan2(ahead[0], ahead[2]))
            mask = folder / "masks" / f"{Path(photo).stem}.png"
            position = tuple(value["position"])
            truths[photo] = Truth(value["room_id"], azimuth, position, mask, {})
        yield folder.name, truths


def flat_truth(folder: Path) -> Iterator[tuple[str, dict[str, Truth]]]:
    """Yield a real flat with the truth of its photos."""
    with (folder / "gt" / "cameras.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    truths = {}
    for row in rows:
        yaw = np.radians(float(row["yaw_deg"]))
        azimuth = float(np.arctan2(np.cos(yaw), np.sin(yaw)))
        x, y, z = (float(row[axis]) for axis in "xyz")
        mask = folder / "gt" / "masks" / f"{Path(row['photo']).stem}.png"
        values = {0: UNKNOWN, 4: OPENING}
        truths[row["photo"]] = Truth(row["room_id"], azimuth, (x, y, z), mask, values)
    yield folder.name, truths


def locate_house(
    results: Path,
    name: str,
    truths: Mapping[str, Truth],
    kind: str,
    *,
    rooms_known: bool,
    windows_drawn: bool,
) -> list[Found]:
    """Return the results for the photos of a house, located by their own masks or true ones."""
    folder = results / "houses" / name
    house = read_scene_json(folder / "scene.json", name)
    if not windows_drawn:
        house = with_usual_windows(without_windows(house))
    masks = folder / "masks"
    rooms = {photo: [truth.room_id] * rooms_known for photo, truth in truths.items()}
    read = read_shots(house, rooms, masks, name_hints=False)
    shots = read.shots
    if kind == "truth":
        shots = {photo: _with_true_labels(shot, truths[photo]) for photo, shot in shots.items()}
    poses = locate_shots(house, shots, read.spots, read.turns, read.alike).poses
    found = [Found(photo, 0.0, False, float("nan")) for photo in sorted(set(shots) - set(poses))]
    for photo, pose in poses.items():
        ahead, truth = pose.camera.matrix[2], truths[photo]
        off = np.arctan2(ahead[0], ahead[2]) - truth.azimuth
        right = bool(np.abs(np.angle(np.exp(1j * off))) < np.radians(RIGHT_DEG))
        right &= pose.room_id == truth.room_id
        error = float(np.linalg.norm((pose.eye - np.array(truth.position))[[0, 2]]))
        found.append(Found(photo, pose.located, right, error))
    return found


def _with_true_labels(shot: Shot, truth: Truth) -> Shot:
    """Return a photo with its true mask in place of the labels that the networks found."""
    with Image.open(truth.mask) as image:
        labels = np.array(image)
    for value, label in truth.values.items():
        labels = np.where(labels == value, label, labels).astype(np.uint8)
    return replace(shot, labels=labels, probabilities=None, amodal=None)


def without_windows(house: House) -> House:
    """Return a house without its windows, like a plan that draws none."""
    walls = (
        replace(wall, openings=tuple(o for o in wall.openings if o.kind != "window"))
        for wall in house.walls
    )
    return replace(house, walls=tuple(walls))


def ceilings(results: Path, name: str, truths: Mapping[str, Truth], *, rooms_known: bool) -> str:
    """Return a line: the ceiling height of a house, and that found by its photos, metres."""
    folder = results / "houses" / name
    house = read_scene_json(folder / "scene.json", name)
    rooms = {photo: [truth.room_id] * rooms_known for photo, truth in truths.items()}
    read = read_shots(house, rooms, folder / "masks")
    found = ceiling_height(with_ceilings(house, DEFAULT_HEIGHT), read.shots, read.spots)
    return f"ceilings of {name}: {house.rooms[0].height:.2f} m, by {len(read.shots)} photos {found}"


def figures(found: Sequence[Found], seconds: float) -> str:
    """Return the cells of a table's row."""
    located = [item for item in found if item.located >= LOCATED]
    errors = [item.error_m for item in located]
    half, most = np.percentile(errors, [50, 90]) if errors else (np.nan, np.nan)
    right = np.mean([item.right for item in located]) if located else np.nan
    expected = np.mean([item.located for item in located]) if located else np.nan
    return (
        f"{len(found)} | {np.mean([item.right for item in found]):.0%} | "
        f"{len(located) / len(found):.0%} | {right:.0%} | {expected:.0%} | "
        f"{half:.2f} / {most:.2f} | {seconds / len(found):.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--synthetic", type=Path, help="root of a data set with truth")
    parser.add_argument("--split", default="test")
    parser.add_argument("--flat", type=Path, action="append", default=[])
    parser.add_argument("--masks", choices=("own", "truth"), nargs="+", default=["own", "truth"])
    parser.add_argument("--without-rooms", action="store_true", help="no table of rooms")
    parser.add_argument("--without-windows", action="store_true", help="plans draw none")
    parser.add_argument("--each", action="store_true", help="one line per photo too")
    given = parser.parse_args()
    sets: dict[str, Callable[[], Iterator[tuple[str, dict[str, Truth]]]]] = {}
    if given.synthetic:
        sets["synthetic"] = lambda: synthetic_truth(given.synthetic, given.split)
    for folder in given.flat:
        sets[folder.name] = lambda folder=folder: flat_truth(folder)
    if not sets:
        parser.error("--synthetic ROOT or --flat FOLDER")
    print(
        "| photos of | masks | photos | heading right | located | heading right of them "
        "| expected | off by, m (median / 90 %) | CPU s a photo |"
    )
    print("|---" * 9 + "|")
    high: list[str] = []
    for name, houses in sets.items():
        for kind in given.masks:
            start = time.process_time()
            found = [
                item
                for house, truths in houses()
                if (given.results / "houses" / house / "masks").is_dir()
                for item in locate_house(
                    given.results,
                    house,
                    truths,
                    kind,
                    rooms_known=not given.without_rooms,
                    windows_drawn=not given.without_windows,
                )
            ]
            print(f"| {name} | {kind} | {figures(found, time.process_time() - start)} |")
            for house, truths in houses() if kind == "own" else ():
                if (given.results / "houses" / house / "masks").is_dir():
                    known = not given.without_rooms
                    high.append(ceilings(given.results, house, truths, rooms_known=known))
            for item in sorted(found, key=lambda item: -item.located) if given.each else ():
                print(f"{item.photo} {item.located:.2f} {item.right} {item.error_m:.2f}")
    print("", *high, sep="\n")


if __name__ == "__main__":
    main()
