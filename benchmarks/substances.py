"""Measure the substances that the texture model's head gives to true crops of real flats.

``python benchmarks/substances.py LABELS FLAT... [--model WEIGHTS]``

FLAT has the layout of a scored flat: ``gt/index.csv`` and its true crops
``gt/{room}/{surface}_{k}.png``.
LABELS is a CSV ``flat,room_id,surface,substance`` of the substances as judged by eye
(``benchmarks/substances.csv``). The script prints the accuracy over crops and over surfaces (by the
mean probability of their crops): by the head alone, and with the kind of surface known.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.images import read_image
from plan2scene.propagation.substances import on_surfaces
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.texture_model import load_texture_model
from plan2scene.weights import MODELS

Row = tuple[str, str, str]  # flat, room, surface


def read_seen(table: Path) -> dict[Row, str]:
    """Return the substance of each surface in a CSV of substances judged by eye."""
    with table.open(newline="") as file:
        return {
            (row["flat"], row["room_id"], row["surface"]): row["substance"]
            for row in csv.DictReader(file)
        }


def read_crops(flats: list[Path]) -> tuple[list[Row], np.ndarray]:
    """Return the flat, room and surface of each true crop, and the crops (n, 128, 128, 3) uint8."""
    rows, images = [], []
    for flat in flats:
        with (flat / "gt" / "index.csv").open(newline="") as file:
            for row in csv.DictReader(file):
                rows.append((flat.name, row["room_id"], row["surface"]))
                name = f"{row['surface']}_{row['k']}.png"
                images.append(read_image(flat / "gt" / row["room_id"] / name))
    return rows, np.stack(images)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("labels", type=Path)
    parser.add_argument("flats", nargs="+", type=Path)
    parser.add_argument("--model", type=Path, default=MODELS / "texture.safetensors")
    options = parser.parse_args()
    seen = read_seen(options.labels)
    rows, crops = read_crops(options.flats)
    model = load_texture_model(options.model)
    head = embed_crops(model, crops, textureness=False).substance_probabilities
    truth = np.array([SUBSTANCES.index(seen[row]) for row in rows])
    variants = {"head": head, "head, kind of surface": on_surfaces(head, [row[2] for row in rows])}
    present = [name for k, name in enumerate(SUBSTANCES) if (truth == k).any()]
    print(f"| by | crops | surfaces | {' | '.join(present)} |")
    print("|" + "---|" * (3 + len(present)))
    for name, found in variants.items():
        print(f"| {name} | {' | '.join(_shares(found, truth, rows))} |")


def _shares(found: np.ndarray, truth: np.ndarray, rows: list[Row]) -> list[str]:
    """Return the accuracy over crops, over surfaces, and over the crops of each substance."""
    right = found.argmax(axis=1) == truth
    groups: dict[Row, list[int]] = {}
    for number, row in enumerate(rows):
        groups.setdefault(row, []).append(number)
    whole = [found[g].mean(axis=0).argmax() == truth[g[0]] for g in groups.values()]
    each = [f"{right[truth == k].mean():.2f} of {(truth == k).sum()}" for k in np.unique(truth)]
    return [f"{right.mean():.2f} of {len(right)}", f"{np.mean(whole):.2f} of {len(whole)}", *each]


if __name__ == "__main__":
    main()
