"""Measure surfaces of finished houses: repetition and sharpness of maps and tiles, file sizes.

python benchmarks/surfaces.py results/demo [HOUSE...]

Repetition: highest normalised autocorrelation of 4 x 4 m (walls: the room's height) at lags beyond
25 cm. Sharpness: square root of the power above 32 cycles per metre, divided by that of the
photos' rectified crops (the three sharpest of the tile's), in the band that each crop resolves.
"""

import argparse
import datetime
import math
import os
import platform
import subprocess
from pathlib import Path

import cv2
import numpy as np
from repetition import FINE, fine_power, repetition

from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.io import read_json, read_parquet

SIDE_M = 4.0
SHOWN_PX_PER_M = 64.0  # resolution for measuring repetition, low enough for every surface
KINDS = ("floor", "wall", "ceiling")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results/{dataset}")
    parser.add_argument("houses", nargs="*")
    parser.add_argument("--method", default="exemplar")
    args = parser.parse_args()
    folders = sorted((args.results / "drop_0.0" / args.method).iterdir())
    folders = [folder for folder in folders if not args.houses or folder.name in args.houses]
    rows = [row for folder in folders for row in house_rows(folder, args.results)]
    print("| surfaces | n | px/m | photo px/m | repetition, tile | map | sharpness, tile | map |")
    print("|---|---|---|---|---|---|---|---|")
    for kind in KINDS:
        mine = [row for row in rows if row["kind"] == kind]
        if mine:
            print(f"| {kind} | {len(mine)} | " + " | ".join(cells(mine)) + " |")
    areas = {f.name: house_sizes(args.results / "houses" / f.name) for f in folders}
    print("\n| house | m2 | GLB MB | MB a 100 m2 |\n|---|---|---|---|")
    for name, (area, size) in areas.items():
        print(f"| {name} | {area:.0f} | {size:.2f} | {100 * size / area:.2f} |")
    git = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()
    print(f"\nMedians; commit {commit}, {datetime.date.today()}, {os.cpu_count()} cores,", end=" ")
    print(f"Python {platform.python_version()}.")


def house_rows(folder: Path, results: Path) -> list[dict]:
    """Return a row for each surface of a house; surfaces with the same crops have one row."""
    textures = folder / "textures"
    entries = read_json(textures / "textures.json")["surfaces"]
    maps = read_json(textures / "maps.json")["surfaces"]
    crops, _ = read_parquet(results / "houses" / folder.name / "crops.parquet")
    rows, seen = [], set()
    for name, entry in entries.items():
        key = SurfaceKey(*name.split("/"))
        sign = (key.surface, tuple(entry.get("crops", [name])))
        if sign in seen or name not in maps:
            continue
        seen.add(sign)
        tile = image_from_bytes((textures / f"{key.filename}.png").read_bytes())
        whole = image_from_bytes((textures / f"{key.filename}.jpg").read_bytes())
        ppm, tile_ppm = maps[name]["px_per_m"], tile.shape[0] / entry["size_m"]
        part = whole[: round(SIDE_M * ppm), : round(SIDE_M * ppm)]
        count = [math.ceil(n / ppm * tile_ppm / tile.shape[0]) for n in part.shape[:2]]
        repeated = np.tile(tile, (*count, 1))
        repeated = repeated[: round(part.shape[0] / ppm * tile_ppm)]
        repeated = repeated[:, : round(part.shape[1] / ppm * tile_ppm)]
        row = {"kind": key.surface, "px": ppm, "photo": maps[name]["photo_px_per_m"]}
        for kind, image, scale in (("tile", repeated, tile_ppm), ("map", part, ppm)):
            row[f"repeats_{kind}"] = repetition(at_scale(image, scale), SHOWN_PX_PER_M)
        row |= sharpness(crops[crops["crop_id"].isin(sign[1])], (tile, tile_ppm), (part, ppm))
        rows.append(row)
    return rows


def at_scale(image: np.ndarray, px_per_m: float) -> np.ndarray:
    """Return an image resized to `SHOWN_PX_PER_M`."""
    scale = SHOWN_PX_PER_M / px_per_m
    size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, size, interpolation=way)


def sharpness(crops, tile: tuple[np.ndarray, float], whole: tuple[np.ndarray, float]) -> dict:
    """Return the sharpness of tile and map relative to the sharpest crops; NaN without crops."""
    crops = crops.drop_duplicates("crop_id")
    crops = crops.assign(resolved=crops["sharpness"] / crops["metres"])
    crops = crops.sort_values("resolved", ascending=False).head(3)
    ratios: dict[str, list[float]] = {"sharp_tile": [], "sharp_map": []}
    for crop in crops.itertuples():
        image = image_from_bytes(crop.detail or crop.png)
        ppm = image.shape[0] / crop.metres
        most = min(ppm, crop.sharpness * 128 / crop.metres) / 2  # Nyquist of the photo
        reference = fine_power(image, ppm, most)
        if not reference > 0 or most <= FINE:
            continue
        for name, (other, scale) in (("sharp_tile", tile), ("sharp_map", whole)):
            power = fine_power(other, scale, most)
            ratios[name].append(math.sqrt((0.0 if math.isnan(power) else power) / reference))
    return {name: float(np.median(found)) if found else math.nan for name, found in ratios.items()}


def cells(rows: list[dict]) -> list[str]:
    """Return the medians of the table's columns as text."""
    names = ("px", "photo", "repeats_tile", "repeats_map", "sharp_tile", "sharp_map")
    values = [np.nanmedian([row[name] for row in rows]) for name in names]
    return [f"{value:.0f}" if k < 2 else f"{value:.2f}" for k, value in enumerate(values)]


def house_sizes(folder: Path) -> tuple[float, float]:
    """Return the floor area in square metres and the size of the GLB in megabytes."""
    from plan2scene.plans.geometry import room_polygon
    from plan2scene.plans.scene_json import read_scene_json

    house = read_scene_json(folder / "scene.json", folder.name)
    area = sum(room_polygon(room).area for room in house.rooms)
    return area, (folder / "house.glb").stat().st_size / 1e6


if __name__ == "__main__":
    main()
