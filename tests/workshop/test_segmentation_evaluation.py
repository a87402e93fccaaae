"""Sets with true labels, calibration, and a row of the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.photos.labels.palette import DOOR, IGNORE, OTHER, WALL, write_label_png
from plan2scene_workshop.segmentation.evaluation import (
    LAYOUTS,
    calibration_error,
    confidence_bins,
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
