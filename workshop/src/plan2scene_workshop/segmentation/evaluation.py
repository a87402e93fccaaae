"""Evaluation of a segmentation network on sets of labelled photos, by label and by group."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import read_image
from plan2scene.photos.camera.calibration import estimate_camera
from plan2scene.photos.labels.palette import (
    DOOR,
    IGNORE,
    OTHER,
    read_label_png,
    without_openings,
)
from plan2scene.photos.labels.segmentation import Segmenter, labels_of, surface_logits
from plan2scene_workshop.segmentation.data import (
    LabelledPhoto,
    confusion,
    read_labelled_photos,
    scores,
)

#: Number of bins of confidence for the calibration error.
BINS = 15
#: A photo is dim if the median of its grey values in [0, 1] is below this.
DIM = 0.35
#: A photo is wide if its horizontal field of view in degrees is at least this.
WIDE_DEG = 65.0
#: A room is furnished if at least this share of its true labels is other (with doors and windows).
FURNISHED = 0.4


@dataclass(frozen=True)
class Measured:
    """How well one photo was labelled."""

    name: str
    matrix: np.ndarray  #: of :func:`.data.confusion`, with doors and windows predicted as other
    #: (BINS, 3) float64, for each bin: pixels, sum of their confidence, number of right pixels.
    bins: np.ndarray
    dim: bool
    wide: bool
    furnished: bool
    openings: np.ndarray | None  #: `matrix` with predicted openings; None if the truth has none


def folder_photos(folder: Path) -> Iterator[LabelledPhoto]:
    """Yield the photos of a folder of ``{name}.jpg`` with ``{name}.mask.png``, doors as other."""
    for mask in sorted(folder.glob("*.mask.png")):
        name = mask.name.removesuffix(".mask.png")
        yield LabelledPhoto(name, read_image(folder / f"{name}.jpg"), read_label_png(mask))


def flat_photos(folder: Path) -> Iterator[LabelledPhoto]:
    """Yield the photos of a flat: ``photos/{name}.jpg`` with ``gt/masks/{name}.png``.

    Its masks hold 0 not scored, 1 floor, 2 wall, 3 ceiling, 4 door, window or passage.
    """
    values = np.array([IGNORE, 1, 2, 3, DOOR], np.uint8)
    for mask in sorted((folder / "gt" / "masks").glob("*.png")):
        labels = values[read_label_png(mask, openings=True)]
        image = read_image(folder / "photos" / f"{mask.stem}.jpg")
        yield LabelledPhoto(mask.stem, image, labels, openings=True)


#: Reader of a set by the name of its layout; a synthetic data set's layout is its split's name.
LAYOUTS: dict[str, Callable[[Path], Iterator[LabelledPhoto]]] = {
    "folder": folder_photos,
    "flat": flat_photos,
    "val": lambda root: iter(read_labelled_photos(root, "val", long_side=1024)),
    "test": lambda root: iter(read_labelled_photos(root, "test", long_side=1024)),
}


def read_sets(table: Path) -> dict[str, tuple[str, Path]]:
    """Return layout and folder of each set in a CSV with the columns name, layout, path.

    Paths are absolute or relative to the table.
    """
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        if row.get("layout") not in LAYOUTS or not row.get("path") or not row.get("name"):
            expected = f"columns name, layout ({', '.join(LAYOUTS)}), path"
            raise InputError(expected, str(dict(row)), file=table)
    return {row["name"]: (row["layout"], table.parent / row["path"]) for row in rows}


def measure(segmenter: Segmenter, photo: LabelledPhoto) -> Measured:
    """Label a photo as the masks stage does (camera estimated with a draft); return the scores."""
    image, true = photo.image, photo.labels
    size = (true.shape[0], true.shape[1])
    camera = estimate_camera(image, segmenter.draft(image))
    told = segmenter.network.elevation and not camera.fallback
    logits = segmenter.logits(image, camera if told else None)
    labels = labels_of(logits, size)
    opened = labels_of(segmenter.opened(logits), size, openings=True)
    fov = 2 * np.degrees(np.arctan(image.shape[1] / 2 / camera.focal_px))
    grey = image.mean(axis=2) / 255
    return Measured(
        photo.name,
        confusion(labels, true),
        confidence_bins(_confidence_of(logits, size), labels, true),
        bool(np.median(grey) < DIM),
        bool(fov >= WIDE_DEG),
        bool((without_openings(true[true != IGNORE]) == OTHER).mean() >= FURNISHED),
        confusion(opened, true) if photo.openings else None,
    )


def confidence_bins(confidence: np.ndarray, labels: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return (BINS, 3) float64, for each bin: pixels, sum of confidence, number of right pixels.

    Parameters
    ----------
    confidence : (h, w) float32 in [0, 1]
    labels, true : (h, w) uint8
        Doors and windows count as other; pixels whose truth is 255 do not count.
    """
    scored = true != IGNORE
    sure, labels, true = confidence[scored], labels[scored], true[scored]
    right = without_openings(labels) == without_openings(true)
    bins = np.minimum((sure * BINS).astype(int), BINS - 1)
    weights = (None, sure, right)
    return np.stack([np.bincount(bins, weight, BINS) for weight in weights], axis=1)


def calibration_error(bins: Sequence[np.ndarray]) -> float:
    """Return the expected calibration error: the mean gap of confidence and accuracy over bins."""
    total = np.sum(bins, axis=0)
    return float(np.abs(total[:, 1] - total[:, 2]).sum() / total[:, 0].sum())


def figures(photos: Sequence[Measured]) -> list[float]:
    """Return a table row: IoU of four labels, mean of surfaces, openings, accuracy, calibration."""
    found = scores([photo.matrix for photo in photos])
    told = [photo.openings for photo in photos if photo.openings is not None]
    openings = scores(told).openings if told else float("nan")
    error = calibration_error([photo.bins for photo in photos])
    return [*found.iou, found.surfaces, openings, found.accuracy, error]


#: Groups of photos, each with a function that says whether a photo is in it.
GROUPS: dict[str, Callable[[Measured], bool]] = {
    "dim": lambda photo: photo.dim,
    "bright": lambda photo: not photo.dim,
    "narrow": lambda photo: not photo.wide,
    "wide": lambda photo: photo.wide,
    "furnished": lambda photo: photo.furnished,
    "empty": lambda photo: not photo.furnished,
}


def _confidence_of(logits: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return (h, w) float32 at `size`: the probability of each pixel's label of `labels_of`."""
    four = surface_logits(logits)
    powers = np.exp(four - four.max(axis=0))
    best = powers.max(axis=0) / powers.sum(axis=0)
    return cv2.resize(best, size[::-1], interpolation=cv2.INTER_LINEAR)
