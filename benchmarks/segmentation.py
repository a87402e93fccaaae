"""Score the embedded segmentation network on sets of labelled photos, and measure its time.

    python benchmarks/segmentation.py --sets sets.csv [--model FILE] [--every N [--first K]]
        [--photos] [--temperature T] [--wall LOGIT] [--further FILE]

The table of sets has the columns name, layout and path; without ``--sets`` the environment variable
``PLAN2SCENE_SEGMENTATION_SETS`` names it, and without that the demo's photos are scored. Layouts:
``folder`` (``{name}.jpg`` with ``{name}.mask.png``: 0 other, 1 floor, 2 wall, 3 ceiling, 255 left
out), ``flat`` (``photos/{name}.jpg``, ``gt/masks/{name}.png``: 0 left out, 1 floor, 2 wall,
3 ceiling, 4 door or window), ``val`` and ``test`` (that split of a synthetic data set). Each photo
is labelled as in the masks stage: first without a camera, then with the camera estimated from the
first labels. The script prints intersections over union (of summed pixels; doors and windows
together, if the truth has them), the share of right pixels, and the expected calibration error, by
set and by group over all real sets.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import cast

import numpy as np
import torch

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import LABELS, WALL
from plan2scene.photos.labels.segmentation import Segmenter, load_segmenter
from plan2scene.weights import MODELS
from plan2scene_workshop.segmentation.evaluation import (
    GROUPS,
    LAYOUTS,
    Measured,
    figures,
    measure,
    read_sets,
)

VARIABLE = "PLAN2SCENE_SEGMENTATION_SETS"
DEMO = {"demo": ("test", Path(__file__).parents[1] / "resources" / "demo")}
HEAD = ("photos", "n", *LABELS, "surfaces", "openings", "accuracy", "ECE")


def seconds(segmenter: Segmenter, threads: int) -> float:
    """Return the wall-clock time of labelling a 1024x768 photo, the best of five."""
    torch.set_num_threads(threads)
    image = np.random.default_rng(0).integers(0, 256, (768, 1024, 3), dtype=np.uint8)
    times = []
    for _ in range(5):
        started = time.perf_counter()
        segmenter.labels(image)
        times.append(time.perf_counter() - started)
    return min(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", type=Path, default=MODELS / "segmentation.safetensors")
    parser.add_argument("--further", type=Path, help="a network beside the model's")
    parser.add_argument("--sets", type=Path, default=os.environ.get(VARIABLE))
    parser.add_argument("--every", type=int, default=1, help="of the photos of each set")
    parser.add_argument("--first", type=int, default=0, help="photo of each set to begin with")
    parser.add_argument("--temperature", type=float, help="instead of the weights' own")
    parser.add_argument(
        "--wall", type=float, help="added to its logit, instead of the weights' own"
    )
    parser.add_argument("--photos", action="store_true", help="a line for each photo, too")
    parser.add_argument("--threads", type=int, default=2)
    given = parser.parse_args()
    torch.set_num_threads(given.threads)
    segmenter = load_segmenter(given.model)
    if given.further:
        further = cast("SegmentationNet", load_segmenter(given.further).network)
        segmenter = Segmenter(segmenter.network, further)
    constants = segmenter.network.architecture
    if given.temperature is not None:
        constants["temperature"] = given.temperature
    if given.wall is not None:
        constants["logit_adjustment"][WALL] = given.wall
    print(f"| {' | '.join(HEAD)} |")
    print("|---" * len(HEAD) + "|")
    real: list[Measured] = []
    means: list[float] = []
    for name, (layout, path) in (read_sets(given.sets) if given.sets else DEMO).items():
        found = [
            measure(segmenter, photo)
            for photo in list(LAYOUTS[layout](path))[given.first :: given.every]
        ]
        for photo in found if given.photos else ():
            print_row(photo.name, [photo])
        print_row(f"**{name}**", found)
        if layout in ("folder", "flat"):
            real += found
            means.append(figures(found)[len(LABELS)])
    for name, member in GROUPS.items():
        print_row(f"real, {name}", [photo for photo in real if member(photo)])
    if means:
        print(f"mean of the surfaces over the real sets: {np.mean(means):.4f}")
    print(f"1024x768 photo: {seconds(segmenter, given.threads):.2f} s, {given.threads} threads")


def print_row(name: str, photos: list[Measured]) -> None:
    """Print a row of the table, unless there are no photos."""
    if photos:
        values = ("-" if np.isnan(value) else f"{value:.3f}" for value in figures(photos))
        print(f"| {name} | {len(photos)} | {' | '.join(values)} |", flush=True)


if __name__ == "__main__":
    main()
