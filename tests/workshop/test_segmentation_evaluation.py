"""Sets with true labels, calibration, and a row of the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import DOOR, IGNORE, OTHER, WALL, write_label_png
from plan2scene.photos.labels.segmentation import Segmenter
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.evaluation import (
    BINS,
    LAYOUTS,
    calibration_error,
    confidence_bins,
    figures,
    measure,
    read_sets,
)


def _picture(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 60, (48, 64, 3), dtype=np.uint8)


def test_calibration_error_is_the_gap_between_confidence_and_accuracy() -> None:
    labels = np.full((10, 10), WALL, np.uint8)
    true = labels.copy()
    true[:3] = OTHER  # 70 % are right
    exact = confidence_bins(np.full((10, 10), 0.7, np.float32), labels, true)
    assert calibration_error([exact]) == pytest.approx(0, abs=1e-6)
    sure = confidence_bins(np.ones((10, 10), np.float32), labels, true)
    assert calibration_error([sure]) == pytest.approx(0.3)
    assert calibration_error([exact, sure]) == pytest.approx(0.15)
    true[:] = IGNORE
    assert confidence_bins(np.ones((10, 10), np.float32), labels, true).sum() == 0


def test_doors_are_other_when_confidence_is_judged() -> None:
    labels, true = np.full((2, 2), DOOR, np.uint8), np.zeros((2, 2), np.uint8)
    bins = confidence_bins(np.ones((2, 2), np.float32), labels, true)
    assert bins[BINS - 1].tolist() == [4, 4, 4]


def test_layouts_read_photos_with_their_labels(tmp_path: Path) -> None:
    for folder in ("some", "flat/photos", "flat/gt/masks"):
        (tmp_path / folder).mkdir(parents=True)
    labels = np.full((48, 64), WALL, np.uint8)
    labels[0], labels[1] = OTHER, DOOR
    for photo in ("some/a.jpg", "flat/photos/a.jpg"):
        write_png(tmp_path / photo, _picture())
    for mask in ("some/a.mask.png", "flat/gt/masks/a.png"):
        write_label_png(tmp_path / mask, labels)
    table = tmp_path / "sets.csv"
    table.write_text("name,layout,path\none,folder,some\ntwo,flat,flat\n")
    sets = {k: list(LAYOUTS[layout](path)) for k, (layout, path) in read_sets(table).items()}
    assert sets["one"][0].labels[:3, 0].tolist() == [OTHER, OTHER, WALL]
    assert not sets["one"][0].openings
    assert sets["two"][0].labels[:3, 0].tolist() == [IGNORE, DOOR, WALL]
    assert sets["two"][0].openings
    table.write_text("name,layout,path\none,heap,some\n")
    with pytest.raises(InputError, match=r"layout.*heap"):
        read_sets(table)


def test_a_row_of_the_table_says_what_a_photo_is_like() -> None:
    torch.manual_seed(0)
    network = SegmentationNet(
        widths=[8] * 5, depths=[1] * 4, decoder=16, long_side=64, labels=6, elevation=True
    )
    labels = np.zeros((48, 64), np.uint8)
    found = measure(Segmenter(network), LabelledPhoto("a", _picture(), labels))
    assert found.dim and found.furnished
    assert found.matrix.sum() == found.bins[:, 0].sum() == 48 * 64
    row = figures([found])
    assert row[0] == pytest.approx(found.matrix[0, [0, 4, 5]].sum() / (48 * 64))
    assert np.isnan(row[5])  # the truth does not tell openings
    assert row[6] == pytest.approx(row[0])
