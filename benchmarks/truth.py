"""Textures of a synthetic data set against the true materials, for every method.

    python benchmarks/truth.py resources/demo/truth/test results/demo

What no paper's data has: the albedo of every surface, those that no photo shows included. Prints
the median CIEDE2000 between the tiles' median colours, the share of surfaces within 5, and the
mean of COLOR against the true tile. Observed: drop 0.0; unobserved: drop 0.6, surfaces without a
visible photo.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from plan2scene.io import read_image, read_json
from plan2scene.metrics.color import color_distance
from plan2scene.textures.colour import delta_e_2000, median_colour, rgb_to_lab

COLUMNS = (("observed", "0.0", True), ("unobserved", "0.6", False))


def errors(truth: Path, textures: Path, *, observed: bool) -> list[tuple[float, float]]:
    """Return (dE2000 of the median colours, COLOR) of one house's surfaces."""
    found = []
    for key, surface in read_json(textures / "textures.json")["surfaces"].items():
        name = key.replace("/", "_") + ".png"
        if surface["observed"] != observed or not (truth / "materials" / name).is_file():
            continue
        made, true = read_image(textures / name), read_image(truth / "materials" / name)
        true = cv2.resize(true, made.shape[1::-1], interpolation=cv2.INTER_AREA)
        labs = [rgb_to_lab(median_colour(tile)[None]) for tile in (made, true)]
        found.append((float(delta_e_2000(*labs)[0]), color_distance(made, true)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("truth", type=Path, help="folder with a folder of truth per house")
    parser.add_argument("results", type=Path, help="results of the data set")
    given = parser.parse_args()
    print(
        "| method | surfaces | n | median dE2000 | within 5 % | COLOR |\n|---|---|---|---|---|---|"
    )
    for column, drop, observed in COLUMNS:
        for folder in sorted((given.results / f"drop_{drop}").iterdir()):
            rows = [
                row
                for house in sorted(given.truth.iterdir())
                if (folder / house.name / "textures").is_dir()
                for row in errors(house, folder / house.name / "textures", observed=observed)
            ]
            if rows:
                difference, color = np.array(rows).T
                print(
                    f"| {folder.name} | {column} | {len(rows)} | {np.median(difference):.1f} "
                    f"| {100 * (difference <= 5).mean():.0f} | {color.mean():.3f} |"
                )


if __name__ == "__main__":
    main()
