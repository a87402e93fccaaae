"""Compare the textures of a synthetic data set with the true materials, for every method.

    python benchmarks/truth.py resources/demo/truth/test results/demo

Unlike real data, a synthetic data set has the true albedo of every surface, also of those that no
photo shows. The script prints the median CIEDE2000 between the tiles' median colours, the share of
surfaces within 5, and the means of COLOR and FREQ, both against a square of the true material as
large as the method's tile. Observed: drop 0.0; unobserved: drop 0.6, surfaces without a visible
photo.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.images import METRIC_SIZE, metric_image, read_image
from plan2scene.io import read_json
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance

#: Largest number of true tiles along a side of the square: a stretched crop may cover many metres.
MOST_TILES = 16.0
COLUMNS = (("observed", "0.0", True), ("unobserved", "0.6", False))


def at_scale(tile: np.ndarray, tile_m: float, metres: float) -> np.ndarray:
    """Return a square of `metres` of the material whose tile covers `tile_m`."""
    ratio = min(metres / tile_m, MOST_TILES)
    times = math.ceil(ratio)
    side = max(1, round(ratio * len(tile)))
    square = np.tile(tile, (times, times, 1))[:side, :side]
    shrinks = side > METRIC_SIZE
    how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    return cv2.resize(square, (METRIC_SIZE, METRIC_SIZE), interpolation=how)


def errors(truth: Path, textures: Path, *, observed: bool) -> list[tuple[float, float, float]]:
    """Return (dE2000 of the median colours, COLOR, FREQ) of one house's surfaces."""
    found = []
    materials = read_json(truth / "materials.json")
    for key, surface in read_json(textures / "textures.json")["surfaces"].items():
        name = key.replace("/", "_") + ".png"
        if surface["observed"] != observed or key not in materials:
            continue
        made = metric_image(read_image(textures / name))
        tile = read_image(truth / "materials" / name)
        labs = [rgb_to_lab(median_colour(image)[None]) for image in (made, tile)]
        true = at_scale(tile, materials[key]["size_m"], surface["size_m"])
        difference = float(delta_e_2000(*labs)[0])
        found.append((difference, color_distance(made, true), freq_distance(made, true)))
    return found


def error_rows(truth: Path, results: Path) -> list[dict[str, Any]]:
    """Return a row for each method and kind of surface: n, median and mean errors."""
    rows = []
    for column, drop, observed in COLUMNS:
        made: dict[str, list[tuple[float, float, float]]] = {}
        for house in sorted(truth.iterdir()):
            for folder in (results / "houses" / house.name / "comparison" / drop).glob("*"):
                made.setdefault(folder.name, []).extend(errors(house, folder, observed=observed))
        for method, found in sorted(made.items()):
            if not found:
                continue
            difference, color, freq = np.array(found).T
            rows.append(
                {
                    "method": method,
                    "column": column,
                    "n": len(found),
                    "difference": float(np.median(difference)),
                    "within": float(100 * (difference <= 5).mean()),
                    "color": float(color.mean()),
                    "freq": float(freq.mean()),
                }
            )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("truth", type=Path, help="folder with a folder of truth per house")
    parser.add_argument("results", type=Path, help="results of the data set")
    given = parser.parse_args()
    print("| method | surfaces | n | median dE2000 | within 5 % | COLOR | FREQ |")
    print("|---" * 7 + "|")
    for row in error_rows(given.truth, given.results):
        print(
            f"| {row['method']} | {row['column']} | {row['n']} | {row['difference']:.1f} "
            f"| {row['within']:.0f} | {row['color']:.3f} | {row['freq']:.3f} |"
        )


if __name__ == "__main__":
    main()
