"""Draw the best, the median and the worst observed surfaces of a data set by COLOR.

    python benchmarks/texture_gallery.py results/demo --by exemplar --output gallery.jpg

It reads the compared textures at drop 0.0 and the crops of every house in the results folder. Rows
look like those of a house's texture sheet. It prints COLOR of the shown rows and its quantiles.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from plan2scene.textures.methods import texture_methods
from plan2scene_app.pictures.texture_sheet import SheetRow, draw_sheet, sheet_rows


def observed_rows(results: Path) -> dict[str, SheetRow]:
    """Return the observed surfaces of all houses as rows, by "house/surface"."""
    rows = {}
    for folder in sorted(results.glob("houses/*/comparison/0.0")):
        house = folder.parents[1].name
        textures = {name: folder / name for name in texture_methods() if (folder / name).is_dir()}
        crops = results / "houses" / house / "crops.parquet"
        for key, row in sheet_rows(textures, crops).items():
            if "observed" in row.title:
                title = (house, *row.title[:3])
                rows[f"{house}/{key.filename}"] = SheetRow(title, row.reference, row.tiles)
    return rows


def ranked(rows: Mapping[str, SheetRow], method: str) -> pd.DataFrame:
    """Return ``name, color`` of all rows with a reference, sorted by COLOR of a method."""
    frame = pd.DataFrame(
        [(name, row.color(method)) for name, row in rows.items() if row.reference is not None],
        columns=["name", "color"],
    )
    return frame.sort_values(["color", "name"], ignore_index=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--by", default="exemplar")
    parser.add_argument("--each", type=int, default=3)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    rows = observed_rows(options.results)
    order = ranked(rows, options.by)
    middle = (len(order) - options.each) // 2
    each = options.each
    parts = {
        "best": order[:each],
        "median": order[middle : middle + each],
        "worst": order[-each:],
    }
    shown = []
    for part, frame in parts.items():
        for name, color in zip(frame["name"], frame["color"], strict=True):
            print(f"{part} {name} COLOR {color:.3f}")
            row = rows[name]
            shown.append(SheetRow((part, *row.title), row.reference, row.tiles))
    quantiles = np.quantile(order["color"], [0.1, 0.25, 0.5, 0.75, 0.9]).round(3)
    print(f"{len(order)} observed surfaces, quantiles .1 .25 .5 .75 .9: {quantiles.tolist()}")
    picture = draw_sheet(f"Best, median and worst by COLOR of {options.by}", shown)
    picture.convert("RGB").save(options.output, quality=82, optimize=True)


if __name__ == "__main__":
    main()
