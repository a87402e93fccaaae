"""Labelled photos for the segmentation network, and the scores of its answers."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import decode_image, read_image
from plan2scene.io import read_json, read_text, safe_join
from plan2scene.photos.labels.palette import DOOR, IGNORE, LABELS_AND_OPENINGS, read_label_png


@dataclass(frozen=True)
class Horizon:
    """Where a photo's horizon lies, independent of the photo's size."""

    #: The world's up direction in camera axes (x right, y down, z forward), a unit vector.
    up: tuple[float, float, float]
    focal: float  #: focal length divided by the photo's width


@dataclass(frozen=True, eq=False)
class LabelledPhoto:
    """A photo with its true labels."""

    name: str
    image: np.ndarray  #: (h, w, 3) uint8 sRGB
    #: (h, w) uint8: 0 other, 1 floor, 2 wall, 3 ceiling, 255 ignore; 4 door and 5 window if
    #: `openings` (otherwise doors and windows are 0, other).
    labels: np.ndarray
    horizon: Horizon | None = None  #: if known
    openings: bool = False
    #: (h / 2, w / 2, 4) float16, if the renderer wrote it: the normal in camera axes and the depth
    #: in metres; zero where no surface is hit.
    geometry: np.ndarray | None = None
    #: (h, w) uint8: labels of what would be seen without furniture, if the renderer wrote them.
    amodal: np.ndarray | None = None
    #: Whether teachers (if there are any) label this photo; if not, only its labels are learned.
    taught: bool = True

    @property
    def learned(self) -> np.ndarray:
        """The labels that a network learns: the amodal ones, if there are any."""
        return self.labels if self.amodal is None else self.amodal


def read_labelled_photos(root: str | Path, split: str, *, long_side: int) -> list[LabelledPhoto]:
    """Return the photos of a split of a synthetic data set, scaled down to `long_side` pixels.

    Reads ``data_lists/{split}.txt``, ``truth/{split}/{house}/cameras.json`` (which names the
    photos), ``photos/``, ``masks/`` (``docs/conventions.md``), and ``amodal/``, ``normals/`` and
    ``depth/`` if present. `openings` is true for all photos if any mask of the split has doors or
    windows.
    """
    base = Path(root)
    listing = base / "data_lists" / f"{split}.txt"
    houses = read_text(listing).split()
    photos = [photo for house in houses for photo in _house_photos(base, split, house, long_side)]
    if not photos:
        raise InputError("at least one photo with a truth mask", "none", file=listing)
    openings = any((photo.labels[photo.labels != IGNORE] >= DOOR).any() for photo in photos)
    return [replace(photo, openings=openings) for photo in photos]


def _house_photos(base: Path, split: str, house: str, long_side: int) -> Iterator[LabelledPhoto]:
    """Yield the photos of one house with their masks."""
    truth = safe_join(base / "truth" / split, house)
    cameras = read_json(truth / "cameras.json")
    for name in sorted(cameras):
        image = read_image(safe_join(base / "photos", name), house_id=house)
        mask = truth / "masks" / f"{Path(name).stem}.png"
        labels = read_label_png(mask, house_id=house, openings=True)
        if labels.shape != image.shape[:2]:
            raise InputError(
                f"a mask of size {image.shape[:2]}", str(labels.shape), file=name, house=house
            )
        behind = truth / "amodal" / mask.name
        amodal = read_label_png(behind, house_id=house, openings=True) if behind.exists() else None
        if amodal is not None:
            _, amodal = scaled_down(image, amodal, long_side)
        image, labels = scaled_down(image, labels, long_side)
        geometry = _read_geometry(truth, mask.name, (labels.shape[0], labels.shape[1]), house)
        horizon = horizon_of(cameras[name])
        yield LabelledPhoto(name, image, labels, horizon, geometry=geometry, amodal=amodal)


def _read_geometry(truth: Path, name: str, size: tuple[int, int], house: str) -> np.ndarray | None:
    """Return (h / 2, w / 2, 4) float16 normals and depth of a photo of `size`; None without them.

    Files: ``normals/`` (n + 1) / 2 x 255 as RGB, 0 0 0 for none; ``depth/`` millimetres, 16 bits.
    """
    files = truth / "normals" / name, truth / "depth" / name
    if not all(file.is_file() for file in files):
        return None
    normals = read_image(files[0], house_id=house)
    depth = decode_image(files[1], lambda image: np.array(image, np.float32), house_id=house)
    half = (max(1, size[1] // 2), max(1, size[0] // 2))
    normals, depth = (
        cv2.resize(values, half, interpolation=cv2.INTER_NEAREST) for values in (normals, depth)
    )
    unit = np.where(normals.any(axis=2, keepdims=True), normals / 127.5 - 1, 0)
    return np.concatenate([unit, depth[..., None] / 1000], axis=2).astype(np.float16)


def digest(photos: Sequence[LabelledPhoto]) -> str:
    """Return 16 hex digits of photos and their labels."""
    found = hashlib.sha256()
    for photo in photos:
        found.update(photo.image.tobytes() + photo.labels.tobytes())
    return found.hexdigest()[:16]


def horizon_of(camera: Mapping[str, Any]) -> Horizon | None:
    """Return the horizon of a camera of a truth file; None if it has no rotation."""
    if "rotation" not in camera:
        return None
    up = tuple(float(row[1]) for row in camera["rotation"])
    return Horizon((up[0], up[1], up[2]), float(camera["focal_px"]) / float(camera["width"]))


def scaled_down(
    image: np.ndarray, labels: np.ndarray, long_side: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return photo and labels with the longer side at most `long_side` pixels."""
    height, width = labels.shape
    scale = long_side / max(height, width)
    if scale >= 1:
        return image, labels
    size = (round(width * scale), round(height * scale))
    return (
        cv2.resize(image, size, interpolation=cv2.INTER_AREA),
        cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST),
    )


def confusion(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return (6, 6) int64 pixel counts of labels (h, w): rows true (without 255), columns found."""
    count = len(LABELS_AND_OPENINGS)
    kept = true != IGNORE
    pairs = true[kept].astype(np.int64) * count + predicted[kept]
    return np.bincount(pairs, minlength=count * count).reshape(count, count)


@dataclass(frozen=True)
class Scores:
    """Scores over many photos, all in [0, 1]; NaN for a label that occurs nowhere."""

    #: Intersection over union of each of LABELS; doors and windows count as other.
    iou: tuple[float, ...]
    accuracy: float  #: share of pixels with the right one of these labels
    openings: float  #: intersection over union of doors and windows taken together

    @property
    def mean_iou(self) -> float:
        """Mean over the labels that occur."""
        return float(np.nanmean(self.iou))

    @property
    def surfaces(self) -> float:
        """Mean over floor, wall and ceiling, of those that occur."""
        found = [value for value in self.iou[1:] if not np.isnan(value)]
        return float(np.mean(found)) if found else float("nan")


def scores(matrices: Sequence[np.ndarray]) -> Scores:
    """Return the scores of the sum of confusion matrices (all pixels have the same weight)."""
    total = np.sum(matrices, axis=0).astype(np.float64)
    four = _grouped(total, [0, 1, 2, 3, 0, 0])
    openings = _grouped(total, [0, 0, 0, 0, 1, 1])
    return Scores(
        tuple(_iou(four).tolist()),
        float(np.diag(four).sum() / four.sum()),
        float(_iou(openings)[1]),
    )


def _grouped(matrix: np.ndarray, groups: Sequence[int]) -> np.ndarray:
    """Return the confusion matrix of groups of labels; `groups` is the group of each label."""
    member = np.eye(max(groups) + 1)[list(groups)]
    return np.asarray(member.T @ matrix @ member)


def _iou(matrix: np.ndarray) -> np.ndarray:
    """Return intersection over union of each label (n,) of a confusion matrix."""
    hit, true = np.diag(matrix), matrix.sum(axis=1)
    union = matrix.sum(axis=0) + true - hit
    return np.divide(hit, union, out=np.full(len(hit), np.nan), where=true > 0)
