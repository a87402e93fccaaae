from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.io import write_json
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL, write_label_png
from plan2scene.photos.labels.segmentation import SegmentationNet, load_segmenter
from plan2scene_workshop.segmentation.data import (
    Horizon,
    LabelledPhoto,
    confusion,
    read_labelled_photos,
    scores,
)
from plan2scene_workshop.segmentation.run import train_segmentation
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.segmentation.training import (
    segmentation_loss,
    told_elevation,
    train_network,
)


def _striped(seed: int = 0, size: tuple[int, int] = (48, 64)) -> LabelledPhoto:
    """Return a photo whose labels can be told from colour: ceiling, wall, floor, a thing."""
    rng = np.random.default_rng(seed)
    labels = np.full(size, WALL, np.uint8)
    labels[: int(rng.integers(8, 16))] = CEILING
    labels[-int(rng.integers(8, 16)) :] = FLOOR
    left = int(rng.integers(0, 40))
    labels[20:40, left : left + 16] = OTHER
    colours = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]])
    noise = rng.normal(0, 6, (*size, 3))
    return LabelledPhoto(f"p{seed}", np.clip(colours[labels] + noise, 0, 255).astype("u1"), labels)


def test_confusion_and_scores_by_hand() -> None:
    true = np.array([[1, 1, 2, IGNORE]], np.uint8)
    found = scores([confusion(np.array([[1, 2, 2, 0]], np.uint8), true)])
    assert found.iou[1] == pytest.approx(1 / 2)
    assert found.iou[2] == pytest.approx(1 / 2)
    assert np.isnan(found.iou[0])
    assert found.mean_iou == pytest.approx(0.5)
    assert found.accuracy == pytest.approx(2 / 3)


def test_loss_leaves_ignored_pixels_out_and_falls_for_the_truth() -> None:
    labels = torch.full((1, 8, 8), WALL)
    labels[:, :4] = FLOOR
    right = torch.zeros(1, 4, 8, 8)
    right[:, FLOOR, :4] = 8
    right[:, WALL, 4:] = 8
    wrong = right.flip(2)
    assert segmentation_loss(right, labels, 0.5) < 0.5 < segmentation_loss(wrong, labels, 0.5)
    ignored = labels.clone()
    ignored[:, :4] = IGNORE
    changed = right.clone()
    changed[:, :, :4] = torch.randn(1, 4, 4, 8)
    assert torch.allclose(
        segmentation_loss(right, ignored, 0.5), segmentation_loss(changed, ignored, 0.5)
    )


def _tiny() -> SegmentationNet:
    torch.manual_seed(0)
    return SegmentationNet(widths=[8, 8, 8, 8, 8], depths=[1, 1, 1, 1], decoder=16, long_side=64)


def test_training_learns_what_colours_tell() -> None:
    settings = SegmentationSettings(
        batch=4, small=64, long_side=64, steps=30, learning_rate=1e-2, evaluate_every=15
    )
    photos = [_striped(k) for k in range(12)]
    held_out = [_striped(k) for k in range(100, 104)]
    trained = train_network(_tiny(), photos, held_out, settings, seed=0)
    assert trained.step in (15, 30)
    assert trained.score > 0.4  # the commonest label alone gives under 0.15


def _write_data_set(root: Path) -> None:
    (root / "data_lists").mkdir(parents=True)
    for split, house in (("train", "h1"), ("val", "h2")):
        (root / "data_lists" / f"{split}.txt").write_text(house + "\n")
        truth = root / "truth" / split / house
        photo = _striped(1 if split == "train" else 2)
        name = f"{house}_a.png"
        write_json(truth / "cameras.json", {name: {}})
        write_png(root / "photos" / name, photo.image)
        write_label_png(truth / "masks" / f"{house}_a.png", photo.labels)


def test_train_segmentation_writes_weights_and_card(tmp_path: Path) -> None:
    _write_data_set(tmp_path / "data")
    model, card = tmp_path / "m.safetensors", tmp_path / "m.md"
    settings = SegmentationSettings(steps=2, batch=2, small=64, long_side=64)
    found = train_segmentation(tmp_path / "data", model, card, settings=settings, seed=0)
    text = card.read_text()
    assert f"| **mean** | {found.mean_iou:.3f} |" in text
    assert "1 rendered photos" in text
    assert "Seed 0; settings: `batch` 2" in text
    assert load_segmenter(model).labels(_striped(2).image).shape == (48, 64)


def test_elevations_follow_the_horizon_and_are_sometimes_unknown() -> None:
    photo = dataclasses.replace(_striped(1), horizon=Horizon((0.0, -1.0, 0.0), 0.75))
    exact = SegmentationSettings(elevation_known=1.0, elevation_noise_deg=0.0)
    rng = np.random.default_rng(0)
    elevation = told_elevation(photo, exact, rng)
    height = photo.labels.shape[0]
    assert (elevation[: height // 2] > 0).all()  # a level camera has its horizon in the middle
    assert (elevation[height // 2 :] < 0).all()
    never = SegmentationSettings(elevation_known=0.0)
    assert np.isnan(told_elevation(photo, never, rng)).all()
    assert np.isnan(told_elevation(_striped(1), exact, rng)).all()


def test_a_split_without_photos_is_an_error(tmp_path: Path) -> None:
    _write_data_set(tmp_path)
    assert [p.name for p in read_labelled_photos(tmp_path, "val", long_side=32)] == ["h2_a.png"]
    (tmp_path / "data_lists" / "val.txt").write_text("")
    with pytest.raises(InputError, match=r"val\.txt"):
        read_labelled_photos(tmp_path, "val", long_side=32)
