"""Find the step at which the colours of real houses go wrong, for each surface.

    python benchmarks/real_house.py WORK HOUSE_FOLDER...
    python benchmarks/real_surfaces.py WORK HOUSE_FOLDER... [--every]

WORK holds the results of `real_house.py`. All figures are CIEDE2000 to the median colour of the
medoid true crop, without any gain. "true mask": the usual colour of the pixels on the true labels
of the room's own photos, a bound for all labels. "own mask": the same with the labels and camera
poses that were used. "together": the colour after all surfaces are solved jointly. "tile": the
final tile. "crops", "best crop": the mean colour of the kept crops, and the nearest of them. "best
photo": the usual colour in the nearest single photo, a bound for any choice among photos.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from real_house import DATASET, Truth, compared, difference, markdown, read_truth

from plan2scene.colour import linear_to_srgb, median_colour, srgb_to_linear
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.images import image_from_bytes, read_image
from plan2scene.io import read_parquet
from plan2scene.paint.observations import (
    equal_shares,
    house_colours,
    read_colours,
    usual_colour,
)

MIN_SHARE = 0.002  # smallest share of a photo that must have a surface's true label
COLUMNS = ("true mask", "own mask", "best photo", "together", "tile", "crops", "best crop")


def of_true_masks(truth: Truth) -> dict[tuple[str, str], np.ndarray]:
    """Return the usual sRGB (3,) of each surface on the true labels of its room's photos."""
    table = pd.read_csv(next(truth.folder.glob("photo_assignments/*.csv")))
    seen: dict[tuple[str, str], list[tuple[float, np.ndarray]]] = {}
    for row in table.itertuples():
        image = read_image(truth.folder / "photos" / row.photo)
        name = f"{Path(row.photo).stem}.png"
        labels = read_image(truth.folder / "gt" / "masks" / name)[..., 0]
        for label, surface in enumerate(SURFACES, start=1):
            pixels = srgb_to_linear(image[labels == label])
            if len(pixels) > MIN_SHARE * labels.size:
                shares = equal_shares(pixels, np.ones(len(pixels)))
                seen.setdefault((row.room_id, surface), []).append((len(pixels), shares))
    return {
        key: linear_to_srgb(usual_colour([s for _, s in items], [w for w, _ in items]))
        for key, items in seen.items()
    }


def of_photos(colours: Path) -> dict[tuple[str, str], list[np.ndarray]]:
    """Return the usual sRGB (3,) of each surface in each photo that shows it."""
    seen, _ = read_colours(colours, ())
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for key, planes in seen.items():
        for photo in sorted({photo for photo, *_ in planes}):
            parts = [(shares, weight) for name, weight, shares in planes if name == photo]
            usual = usual_colour([s for s, _ in parts], [w for _, w in parts])
            found.setdefault((key.room_id, key.surface), []).append(linear_to_srgb(usual))
    return found


def surfaces_of(truth: Truth, results: Path) -> list[dict[str, Any]]:
    """Return a row for each surface with a true crop."""
    folder = results / "houses" / truth.house
    crops, _ = read_parquet(folder / "crops.parquet")
    expected, _ = read_parquet(results / "drop_0.0" / truth.house / "propagated.parquet")
    rooms = sorted(set(expected["room_id"]))
    shown = house_colours(folder / "colours.parquet", (), rooms)
    best, photos = of_true_masks(truth), of_photos(folder / "colours.parquet")
    tiles = compared(truth, results, "0.0").set_index(["room_id", "surface"])
    together = {(r.room_id, r.surface): r.colour for r in expected.itertuples()}
    rows = []
    for key, image in truth.medoids.items():
        true = median_colour(image)
        mine = crops[(crops["room_id"] == key[0]) & (crops["surface"] == key[1])]
        colours = [median_colour(image_from_bytes(png)) for png in mine["png"]]
        place = rooms.index(SurfaceKey(*key).room_id), SURFACES.index(key[1])
        own = linear_to_srgb(shown.colours[place]) if shown.photos[place] > 0 else None
        known = {
            "true mask": best.get(key),
            "own mask": own,
            "together": np.clip(together[key], 0.0, 1.0),
            "crops": np.mean(colours, axis=0) if colours else None,
        }
        errors = {n: np.nan if c is None else difference(c, true) for n, c in known.items()}
        seen = [difference(c, true) for c in photos.get(key, ())]
        errors["best photo"] = min(seen, default=np.nan)
        errors["best crop"] = min((difference(c, true) for c in colours), default=np.nan)
        row = {"house": truth.house, "room": key[0], "surface": key[1], "crops kept": len(colours)}
        rows.append(row | errors | {"tile": tiles.loc[key, "as_is"]})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("work", type=Path)
    parser.add_argument("houses", type=Path, nargs="+")
    parser.add_argument("--every", action="store_true", help="print every surface too")
    given = parser.parse_args()
    results = given.work / "results" / DATASET
    truths = [read_truth(folder) for folder in given.houses]
    table = pd.DataFrame([row for truth in truths for row in surfaces_of(truth, results)])
    if given.every:
        print(table.round(1).to_string())
    rows = []
    for house, of_house in table.groupby("house", sort=False):
        for kind in (*SURFACES, "all"):
            part = of_house if kind == "all" else of_house[of_house["surface"] == kind]
            means = {name: f"{part[name].mean():.2f}" for name in COLUMNS}
            rows.append({"house": house, "surface": kind, "n": len(part)} | means)
    print(markdown(rows))


if __name__ == "__main__":
    main()
