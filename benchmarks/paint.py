"""How far the colours of a data set's textures are from its true materials, by kind of surface.

python benchmarks/paint.py results/demo resources/demo

Textures in the photos' colours (drop 0.0 of `house.method`), and those in paint that the house
shows. CIEDE2000 of median colours, mean over the surfaces that photos show.
"""

import sys
from pathlib import Path

import numpy as np

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.house import SURFACES
from plan2scene.images import read_image
from plan2scene.io import read_json


def difference(one: Path, other: Path) -> float:
    """Return CIEDE2000 of the median colours of two pictures."""
    labs = [rgb_to_lab(median_colour(read_image(path))) for path in (one, other)]
    return float(delta_e_2000(*labs))


def main(results: Path, data: Path, method: str = "exemplar") -> None:
    rows: dict[str, list[tuple[float, float]]] = {kind: [] for kind in SURFACES}
    for house in sorted((results / "houses").iterdir()):
        truth = data / "truth" / "test" / house.name / "materials"
        photo = results / "drop_0.0" / method / house.name / "textures"
        for key, surface in read_json(photo / "textures.json")["surfaces"].items():
            name = f"{key.replace('/', '_')}.png"
            if surface["observed"] and (truth / name).is_file():
                off = [
                    difference(folder / name, truth / name)
                    for folder in (photo, house / "textures")
                ]
                rows[key.rsplit("/", 1)[1]].append((off[0], off[1]))
    print("| surfaces | n | photos' colours | paint |\n|---|---|---|---|")
    rows["all"] = [pair for pairs in rows.values() for pair in pairs]
    for kind, pairs in rows.items():
        light, paint = np.mean(pairs, axis=0)
        print(f"| {kind} | {len(pairs)} | {light:.1f} | {paint:.1f} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
