"""Scores of the embedded segmentation network: intersection over union per label, and its time.

    python benchmarks/segmentation.py --dataset data/benchmark --split val
    python benchmarks/segmentation.py --folder FOLDER

FOLDER holds ``{name}.jpg`` with ``{name}.mask.png`` (0 other, 1 floor, 2 wall, 3 ceiling,
255 left out). Each photo is labelled as the masks stage does it: once without a camera, then told
the camera that the first labels gave; both are scored.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch

from plan2scene.images import read_image
from plan2scene.photos.camera.calibration import estimate_camera
from plan2scene.photos.labels.palette import LABELS, read_label_png
from plan2scene.photos.labels.segmentation import Segmenter, load_segmenter
from plan2scene_workshop.segmentation.data import (
    LabelledPhoto,
    confusion,
    read_labelled_photos,
    scores,
)

DEFAULT_MODEL = Path(__file__).parents[1] / "resources/models/segmentation.safetensors"


def folder_photos(folder: Path) -> Iterator[LabelledPhoto]:
    """Yield the photos of a folder of photos and masks."""
    for mask in sorted(folder.glob("*.mask.png")):
        name = mask.name.removesuffix(".mask.png")
        yield LabelledPhoto(name, read_image(folder / f"{name}.jpg"), read_label_png(mask))


def two_passes(segmenter: Segmenter, photo: LabelledPhoto) -> tuple[np.ndarray, np.ndarray]:
    """Return the labels without a camera, and those told the camera found with them."""
    first = segmenter.labels(photo.image)
    camera = estimate_camera(photo.image, first)
    return first, first if camera.fallback else segmenter.labels(photo.image, camera)


def seconds(segmenter: Segmenter, threads: int) -> float:
    """Return the wall time of labelling a 1024x768 photo once, the best of five."""
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
    parser.add_argument("--model", type=Path, default=DEFAULT_MODEL)
    parser.add_argument("--dataset", type=Path, help="root of a synthetic data set with truth")
    parser.add_argument("--split", default="val")
    parser.add_argument("--folder", type=Path, help="folder of photos with .mask.png beside them")
    parser.add_argument("--threads", type=int, default=2)
    given = parser.parse_args()
    torch.set_num_threads(given.threads)
    segmenter = load_segmenter(given.model)
    if given.dataset:
        photos = read_labelled_photos(given.dataset, given.split, long_side=1024)
    elif given.folder:
        photos = list(folder_photos(given.folder))
    else:
        parser.error("--dataset or --folder")
    passes: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    print(f"| photo | {' | '.join(LABELS)} | accuracy |")
    print("|---" * (len(LABELS) + 2) + "|")
    for photo in photos:
        for found, labels in zip(passes, two_passes(segmenter, photo), strict=True):
            found.append(confusion(labels, photo.labels))
        print_row(photo.name, passes[1][-1:])
    for name, found in zip(("without camera", "told the camera"), passes, strict=True):
        print_row(f"**all, {name}**", found)
        surfaces = scores(found).iou[1:]
        print(f"mean over floor, wall, ceiling, {name}: {np.nanmean(surfaces):.3f}")
    print(f"1024x768 photo: {seconds(segmenter, given.threads):.2f} s, {given.threads} threads")


def print_row(name: str, found: list[np.ndarray]) -> None:
    """Print a table row of summed confusion matrices."""
    result = scores(found)
    values = " | ".join(f"{value:.3f}" for value in (*result.iou, result.accuracy))
    print(f"| {name} | {values} |")


if __name__ == "__main__":
    main()
