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
from plan2scene_workshop.segmentation import paints as segmentation_paints
from plan2scene_workshop.segmentation import training as segmentation_training
from plan2scene_workshop.segmentation.augment import random_view, recolour_labels, training_sample
from plan2scene_workshop.segmentation.bodies import (
    Body,
    Eye,
    plain,
)
from plan2scene_workshop.segmentation.data import (
    Horizon,
    LabelledPhoto,
    confusion,
    read_labelled_photos,
    read_scenes,
    scores,
    write_scenes,
)
from plan2scene_workshop.segmentation.raycast import (
    cast,
    surfels,
)
from plan2scene_workshop.segmentation.run import draw_scenes, train_segmentation
from plan2scene_workshop.segmentation.scenes import random_scenes
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


def test_views_depend_on_the_generator_alone() -> None:
    photos = [_striped(k) for k in range(3)]
    first, second = (
        training_sample(photos, 1, (32, 64), np.random.default_rng(5)) for _ in range(2)
    )
    assert first[0].shape == (32, 64, 3)
    assert first[0].dtype == first[1].dtype == np.uint8
    assert np.array_equal(first[0], second[0])
    assert np.array_equal(first[1], second[1])


def test_a_view_keeps_photo_and_labels_together() -> None:
    photo = _striped(3)
    for seed in range(8):
        image, labels = random_view(photo, (48, 64), np.random.default_rng(seed))
        floor = image[labels == FLOOR].astype(float)
        if len(floor) > 50:
            assert np.median(floor[:, 1]) > np.median(floor[:, 0]) + 60  # green


def test_recolouring_leaves_other_alone() -> None:
    photo = _striped(1)
    changed = recolour_labels(photo.image, photo.labels, np.random.default_rng(0))
    inside = np.zeros(photo.labels.shape, bool)
    inside[22:38] = photo.labels[22:38] == OTHER
    inside &= np.roll(inside, 1, 1) & np.roll(inside, -1, 1)  # the tint is blurred by a pixel
    assert np.array_equal(changed[inside], photo.image[inside])
    assert not np.array_equal(changed, photo.image)


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


def test_training_learns_what_colours_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(segmentation_training, "SegmentationNet", lambda **_: _tiny())
    settings = SegmentationSettings(
        batch=4,
        scene_steps=10,
        steps=20,
        scene_side=64,
        small=64,
        long_side=64,
        learning_rate=1e-2,
        photo_learning_rate=1e-2,
        evaluate_every=10,
    )
    photos, held_out = ([_striped(k) for k in range(n, n + 8)] for n in (0, 100))
    trained = train_network(photos, photos, held_out, settings, seed=0)
    assert trained.step in (10, 20, 30)
    assert trained.score > 0.4  # the commonest label alone gives under 0.15


def test_drawn_rooms_come_first_with_a_rate_and_sizes_of_their_own() -> None:
    settings = SegmentationSettings(scene_steps=300, steps=900)
    assert [settings.side(k) for k in (0, 199, 200, 300, 899, 900)] == [
        192,
        192,
        224,
        224,
        224,
        320,
    ]
    assert settings.rate(30) == 1.0
    assert settings.rate(299) < 0.02
    assert settings.rate(390) == 0.5
    assert settings.rate(1199) < 0.01


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


def test_train_segmentation_writes_weights_and_card(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segmentation_paints, "TILES", 2)
    _write_data_set(tmp_path / "data")
    model, card = tmp_path / "m.safetensors", tmp_path / "m.md"
    settings = SegmentationSettings(
        scenes=2, scene_steps=1, steps=2, batch=2, scene_side=64, small=64, long_side=64
    )
    scenes = tmp_path / "scenes.parquet"
    draw_scenes(scenes, settings=settings, seed=0)
    found = train_segmentation(tmp_path / "data", scenes, model, card, settings=settings, seed=0)
    text = card.read_text()
    assert f"| **mean** | {found.mean_iou:.3f} |" in text
    assert "1 rendered photos" in text
    assert "Seed 0; settings: `batch` 2" in text
    assert load_segmenter(model).labels(_striped(2).image).shape == (48, 64)


def test_drawn_scenes_come_back_as_they_were_written(tmp_path: Path) -> None:
    told = dataclasses.replace(_striped(1), horizon=Horizon((0.0, -0.8, -0.6), 0.75))
    write_scenes(tmp_path / "s.parquet", [told, _striped(2)], {})
    first, second = read_scenes(tmp_path / "s.parquet")
    assert np.array_equal(first.image, told.image)
    assert np.array_equal(first.labels, told.labels)
    assert first.horizon == told.horizon
    assert second.horizon is None


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


def test_ray_caster_sees_floor_wall_and_ceiling_where_they_are() -> None:
    half = np.array([2.0, 1.25, 3.0])
    room = Body(
        np.array([0.0, 1.25, 0.0]),
        half,
        0.0,
        (WALL, WALL, FLOOR, CEILING, WALL, WALL),
        (plain(np.ones(3)),),
        hollow=True,
    )
    thing = Body(np.array([0.5, 0.5, 2.0]), np.full(3, 0.25), 0.3, (OTHER,), (plain(np.ones(3)),))
    look = np.diag([-1.0, -1.0, 1.0])  # along +z, so that +x is left
    eye = Eye(np.array([0.0, 1.25, -2.0]), look, 40.0, (81, 81))
    rays = eye.rays()
    seen = surfels([room, thing], eye, rays, cast([room, thing], eye, rays))
    labels = seen.label.reshape(81, 81)
    # The end wall is 5 m away and 1.25 m above the eye: 10 pixels above the middle row.
    assert labels[40, 40] == WALL
    assert labels[40 - 9, 40] == WALL
    assert labels[40 - 11, 40] == CEILING
    assert labels[40 + 11, 30] == FLOOR
    # The thing's centre is 4 m away, 0.5 m to the left and 0.75 m down.
    assert labels[round(40 + 0.75 / 4 * 40), round(40 - 0.5 / 4 * 40)] == OTHER
    floor = seen.point[(seen.label == FLOOR)]
    assert np.abs(floor[:, 1]).max() < 1e-4


def test_random_scenes_are_the_same_for_the_same_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(segmentation_paints, "TILES", 2)
    first, again = (random_scenes(2, seed=7) for _ in range(2))
    assert np.array_equal(first[1].image, again[1].image)
    assert np.array_equal(first[1].labels, again[1].labels)
    assert not np.array_equal(first[0].image, first[1].image)
    assert {FLOOR, WALL} <= set(np.concatenate([s.labels.ravel() for s in first]).tolist())
