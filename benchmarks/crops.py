"""Compare crops with the truth of a synthetic data set, with and without the filter.

``python benchmarks/crops.py ROOT [--split SPLIT] [--masks true network] [--work DIR]``

ROOT has the layout of docs/conventions.md with ``truth/{split}/{house}``. Cameras are estimated
from the masks; the windows' seed is 0. Per combination of corrections:

- crops kept and windows drawn; lost: surfaces that have a crop only without the filter; last
  resorts: surfaces without any good crop;
- wrong surface: share of the kept crops whose quad in the photo contains the centre of any pixel of
  another surface or of none (furniture, doors), and the share with over 1 % such pixels; other
  plane: share with any pixel of another plane (a different wall has the same surface);
- colour: for each surface (room, floor/wall/ceiling) CIEDE2000 between the median (by channel) over
  all pixels of its kept crops and the median of the true albedo tile. "Within 3, light level free"
  first scales the tile's linear RGB by one factor to the luminance of the crops, because the
  brightness of the light at that place is no error of the albedo. The same comparison is repeated
  for each photo of each surface, so that a single tinted photo is not averaged away;
- COLOR and FREQ of each surface's medoid crop against the true tile at the crop's scale.
"""

from __future__ import annotations

import argparse
import logging
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd

from plan2scene.colour import (
    delta_e_2000,
    linear_to_srgb,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.house import House
from plan2scene.images import medoid_index, read_image
from plan2scene.io import read_json
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance
from plan2scene.photos.crops.extract_crops import crops_of_house
from plan2scene.photos.crops.sampling import CROP_PX, Candidate, CropSettings
from plan2scene.photos.crops.selection import select_candidates
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL, read_label_png
from plan2scene.photos.masks import make_masks
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.weights import MODELS
from plan2scene_app.workflow.house_table import read_table

LABEL = {"floor": FLOOR, "wall": WALL, "ceiling": CEILING}
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: Corrections that are on in each line of the table.
VARIANTS = (
    (),
    ("filter",),
)


@dataclass(frozen=True)
class Source:
    """A house of the data set with its photos and truth."""

    house: House
    rooms_of_photo: dict[str, list[str]]
    photos: dict[str, Path]
    truth: Path


def sources(root: Path, split: str) -> Iterator[Source]:
    """Yield the houses of a split that have photos."""
    table = read_table(root / "houses.tsv").of_splits([split])
    for name, row in table.items():
        house = read_scene_json(root / row.plan, name)
        rooms = rooms_of_photos(root / row.assignment, house)
        if rooms:
            photos = {photo: root / "photos" / photo for photo in rooms}
            yield Source(house, rooms, photos, root / "truth" / split / name)


def masks_of(source: Source, kind: str, work: Path) -> Path:
    """Return the folder of masks and cameras of a house; make it if it does not exist."""
    folder = work / kind / source.house.id
    if not folder.is_dir():
        label = partial(
            labeller,
            "precomputed" if kind == "true" else "embedded",
            model=MODELS / "segmentation.safetensors",
            precomputed_dir=source.truth / "masks",
        )
        make_masks(source.photos, label, folder, house_id=source.house.id)
    return folder


@dataclass(frozen=True)
class Truth:
    """True labels (h, w) and plane ids (h, w) of a photo."""

    labels: np.ndarray
    planes: np.ndarray


def touched(corners: np.ndarray, surface: str, truth: Truth) -> tuple[float, float]:
    """Return the shares of a quad's pixels on another surface and on another plane.

    `corners` (4, 2) are x y in pixels; a pixel counts if its centre is inside. The right plane is
    the most frequent one of the surface in the quad.
    """
    low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    size = np.array(truth.labels.shape)[::-1]
    high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, size)
    if (high <= low).any():
        return 1.0, 1.0
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    edge = np.roll(corners, -1, axis=0) - corners
    side = [e[0] * (y - c[1]) - e[1] * (x - c[0]) for e, c in zip(edge, corners, strict=True)]
    inside = np.all([s > 0 for s in side], axis=0) | np.all([s < 0 for s in side], axis=0)
    labels = truth.labels[low[1] : high[1], low[0] : high[0]][inside]
    planes = truth.planes[low[1] : high[1], low[0] : high[0]][inside]
    right = labels == LABEL[surface]
    if not right.any():
        return 1.0, 1.0
    plane = np.bincount(planes[right]).argmax()
    return float(1 - right.mean()), float((planes != plane).mean())


def tile_window(tile: np.ndarray, size_m: float, metres: float) -> np.ndarray:
    """Return `metres` of a repeated tile (n, n, 3) uint8 as a crop of 128 px."""
    side = max(1, round(tile.shape[0] * metres / size_m))
    count = -(-side // tile.shape[0])
    window = np.tile(tile, (count, count, 1))[:side, :side]
    shrink = cv2.INTER_AREA if side > CROP_PX else cv2.INTER_CUBIC
    return cv2.resize(window, (CROP_PX, CROP_PX), interpolation=shrink)


def differences(crop_rgb: np.ndarray, tile_rgb: np.ndarray) -> tuple[float, float]:
    """Return CIEDE2000 of two sRGB colours in [0, 1], as they are and at equal luminance."""
    linear, true = srgb_to_linear(crop_rgb), srgb_to_linear(tile_rgb)
    level = float(linear @ LUMINANCE) / max(float(true @ LUMINANCE), 1e-6)
    lit = linear_to_srgb(np.clip(true * level, 0, 1))
    lab = rgb_to_lab(np.stack([crop_rgb, tile_rgb, lit]))
    return float(delta_e_2000(lab[0], lab[1])), float(delta_e_2000(lab[0], lab[2]))


def median_of(images: list[np.ndarray]) -> np.ndarray:
    """Return the median (3,) in [0, 1] over all pixels of uint8 crops."""
    return np.median(np.concatenate([i.reshape(-1, 3) for i in images]), axis=0) / 255.0


@dataclass(frozen=True)
class Drawn:
    """Candidates of a house, gains of each photo, and shares of wrong pixels of each candidate."""

    source: Source
    candidates: list[Candidate]
    gains: dict[str, np.ndarray]
    touched: list[tuple[float, float]]


def draw(source: Source, masks: Path, *, filtered: bool) -> Drawn:
    """Return the windows of a house, judged by the filter if `filtered`."""
    made = crops_of_house(
        source.house,
        source.rooms_of_photo,
        source.photos,
        masks,
        seed=0,
        settings=CropSettings(filter=filtered),
    )
    truth = {
        photo: Truth(
            read_label_png(source.truth / "masks" / f"{Path(photo).stem}.png"),
            read_image(source.truth / "planes" / f"{Path(photo).stem}.png")[..., 0],
        )
        for photo in {item.photo for item in made.candidates}
    }
    shares = [
        touched(np.array(item.crop.corners).reshape(4, 2), item.surface, truth[item.photo])
        for item in made.candidates
    ]
    return Drawn(source, made.candidates, made.gains, shares)


def measure_house(drawn: Drawn) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Return tables of the selected crops, of the surfaces, and of the surfaces per photo."""
    rows = []
    for number, room in sorted(select_candidates(drawn.candidates)):
        item = drawn.candidates[number]
        rows.append(
            {
                "house": drawn.source.house.id,
                "photo": item.photo,
                "room_id": room,
                "surface": item.surface,
                "good": item.verdict.good,
                "metres": item.crop.size_m,
                "wrong": drawn.touched[number][0],
                "other_plane": drawn.touched[number][1],
                "image": item.crop.image,
                "drawn": len(drawn.candidates),
            }
        )
    crops = pd.DataFrame(rows)
    return crops, _surfaces(crops, drawn.source, []), _surfaces(crops, drawn.source, ["photo"])


def _surfaces(crops: pd.DataFrame, source: Source, more: list[str]) -> pd.DataFrame:
    """Return a row with colour errors for each surface (and each value of the columns `more`)."""
    sizes = read_json(source.truth / "materials.json")
    rows: list[dict[str, Any]] = []
    for key, group in crops.groupby(["room_id", "surface", *more], sort=True):
        room, surface = key[0], key[1]
        tile = read_image(source.truth / "materials" / f"{room}_{surface}.png")
        medoid = group.iloc[medoid_index(list(group.image))]
        true = tile_window(tile, sizes[f"{room}/{surface}"]["size_m"], float(medoid.metres))
        median = median_of(list(group.image))
        absolute, free = differences(median, median_of([tile]))
        rows.append(
            {
                "house": source.house.id,
                "surface": surface,
                "room_id": room,
                "absolute": absolute,
                "free": free,
                "color": color_distance(medoid.image, true),
                "freq": freq_distance(medoid.image, true),
                "last": not group.good.any(),
            }
        )
    return pd.DataFrame(rows)


COLUMNS = (
    "corrections",
    "crops (drawn)",
    "surfaces",
    "lost",
    "last resorts",
    "wrong surface %",
    "over 1 % of it",
    "other plane %",
    "within 3 %",
    "median dE",
    "within 3 %, level free",
    "median dE, level free",
    "the same per photo %",
    "COLOR",
    "FREQ",
)


def line(name: str, tables: list[tuple[pd.DataFrame, ...]], first: set[Any] | None) -> list[str]:
    """Return one line of the table."""
    crops, surfaces, by_photo = (
        pd.concat([table[k] for table in tables], ignore_index=True) for k in range(3)
    )
    seen = set(zip(surfaces.house, surfaces.room_id, surfaces.surface, strict=True))
    lost = len(first - seen) if first is not None else 0
    drawn = sum(int(table[0].drawn.iloc[0]) for table in tables if len(table[0]))
    return [
        name or "none",
        f"{len(crops)} ({drawn})",
        str(len(surfaces)),
        str(lost),
        str(int(surfaces["last"].sum())),
        f"{100 * (crops.wrong > 0).mean():.1f}",
        f"{100 * (crops.wrong > 0.01).mean():.1f}",
        f"{100 * (crops.other_plane > 0).mean():.1f}",
        f"{100 * (surfaces.absolute <= 3).mean():.0f}",
        f"{surfaces.absolute.median():.1f}",
        f"{100 * (surfaces.free <= 3).mean():.0f}",
        f"{surfaces.free.median():.1f}",
        f"{100 * (by_photo.free <= 3).mean():.0f}",
        f"{surfaces.color.mean():.3f}",
        f"{surfaces.freq.mean():.4f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=Path)
    parser.add_argument("--split", default="val")
    parser.add_argument("--masks", nargs="+", choices=("true", "network"), default=["network"])
    parser.add_argument("--work", type=Path, help="folder in which masks are kept for later runs")
    parser.add_argument("--only", nargs="+", help="lines: corrections joined by +, or none")
    parser.add_argument("--by-surface", action="store_true", help="colour by kind of surface too")
    arguments = parser.parse_args()
    logging.getLogger("plan2scene").setLevel(logging.WARNING)
    houses = list(sources(arguments.root, arguments.split))
    if not houses:
        raise SystemExit(f"no photos in the split {arguments.split} of {arguments.root}")
    variants: tuple[tuple[str, ...], ...] = VARIANTS
    if arguments.only:
        variants = tuple(() if v == "none" else tuple(v.split("+")) for v in arguments.only)
    with tempfile.TemporaryDirectory() as temporary:
        work = arguments.work or Path(temporary)
        for kind in arguments.masks:
            print(f"\nMasks: {kind}\n\n| " + " | ".join(COLUMNS) + " |")
            print("|" + "---|" * len(COLUMNS))
            first: set[Any] | None = None
            windows: dict[bool, list[Drawn]] = {}
            for variant in variants:
                filtered = "filter" in variant
                if filtered not in windows:
                    windows[filtered] = [
                        draw(s, masks_of(s, kind, work), filtered=filtered) for s in houses
                    ]
                tables = [measure_house(d) for d in windows[filtered]]
                cells = line(" + ".join(variant), tables, first)
                print("| " + " | ".join(cells) + " |", flush=True)
                found = pd.concat([table[1] for table in tables])
                if first is None:
                    first = set(zip(found.house, found.room_id, found.surface, strict=True))
                if arguments.by_surface:
                    print(found.groupby("surface")[["absolute", "free"]].describe().T)


if __name__ == "__main__":
    main()
