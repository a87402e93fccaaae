"""Measure the colour errors of a data set's textures against its true materials.

python benchmarks/paint.py results/demo resources/demo

It compares textures in the photos' colours (drop 0.0 of `house.method`), and the house's final
textures in paint colours. The error is CIEDE2000 of median colours, mean over the surfaces that
photos show: by kind of surface, and for walls and ceilings by class of the true paint
(:func:`paint_class`).
"""

import sys
from pathlib import Path

import numpy as np

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.house import SURFACES
from plan2scene.images import read_image
from plan2scene.io import read_json

CLASSES = ("white", "pale", "saturated", "dark")


def lab_of(path: Path) -> np.ndarray:
    """Return L*a*b* (3,) of the median colour of a picture."""
    return rgb_to_lab(median_colour(read_image(path)))


def paint_class(lab: np.ndarray) -> str:
    """Return the class of a paint, one of `CLASSES`."""
    chroma = np.hypot(lab[1], lab[2])
    if lab[0] < 45:
        return "dark"
    if chroma >= 18:
        return "saturated"
    return "white" if lab[0] >= 86 and chroma < 9 else "pale"


def main(results: Path, data: Path, method: str = "exemplar") -> None:
    rows: dict[str, list[tuple[float, float]]] = {kind: [] for kind in (*SURFACES, "all", *CLASSES)}
    for house in sorted((results / "houses").iterdir()):
        truth = data / "truth" / "test" / house.name / "materials"
        photo = results / "drop_0.0" / method / house.name / "textures"
        for key, surface in read_json(photo / "textures.json")["surfaces"].items():
            name, kind = f"{key.replace('/', '_')}.png", key.rsplit("/", 1)[1]
            if surface["observed"] and (truth / name).is_file():
                true = lab_of(truth / name)
                shown = [lab_of(folder / name) for folder in (photo, house / "textures")]
                light, paint = (float(delta_e_2000(lab, true)) for lab in shown)
                for row in (kind, "all", *((paint_class(true),) if kind != "floor" else ())):
                    rows[row].append((light, paint))
    print("| surfaces | n | photos' colours | paint |\n|---|---|---|---|")
    for name, pairs in rows.items():
        if pairs:
            light, paint = np.mean(pairs, axis=0)
            print(f"| {name} | {len(pairs)} | {light:.1f} | {paint:.1f} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
