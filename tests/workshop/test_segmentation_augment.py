from __future__ import annotations

import numpy as np
import pytest

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL
from plan2scene_workshop.segmentation.augment import (
    paste_patches,
    training_sample,
    training_sample_with_map,
)
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.effects import camera_effects, retexture, sun_and_shade
from plan2scene_workshop.segmentation.warp import Warp, random_warp


def _photo(seed: int = 0, size: tuple[int, int] = (60, 80)) -> LabelledPhoto:
    """Return a photo of four flat bands: ceiling, wall, a thing in it, floor."""
    labels = np.full(size, WALL, np.uint8)
    labels[:15], labels[45:] = CEILING, FLOOR
    labels[20:40, 30:50] = OTHER
    colours = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]], np.uint8)
    return LabelledPhoto(f"p{seed}", colours[labels], labels)


def test_a_warp_keeps_image_labels_and_maps_together() -> None:
    photo = _photo()
    bent = 0
    for seed in range(20):
        warp = random_warp((60, 80), (48, 64), np.random.default_rng(seed))
        bent += warp.distortion != 0
        image, labels = warp.image(photo.image), warp.labels(photo.labels)
        values = warp.values(photo.labels.astype(np.float32))
        sure = np.isfinite(values) & (np.abs(values - np.round(values)) < 1e-6) & (labels != IGNORE)
        assert sure.mean() > 0.4
        assert (values[sure] == labels[sure]).mean() > 0.995
        floor = image[(labels == FLOOR) & sure]
        if len(floor) > 40:
            assert np.median(floor[:, 1]) > 120
    assert 2 < bent < 18


def test_a_map_of_places_says_where_the_view_looks() -> None:
    warp = random_warp((60, 80), (48, 64), np.random.default_rng(3))
    rows, columns = np.mgrid[:60, :80].astype(np.float32)
    values = warp.values(np.dstack([columns, rows]))
    inside = np.isfinite(values).all(axis=2)
    assert inside.mean() > 0.5
    assert np.allclose(values[inside][:, 0], warp.grid[0][inside], atol=0.05)
    assert np.allclose(values[inside][:, 1], warp.grid[1][inside], atol=0.05)
    outside = (warp.grid[0] < -1) | (warp.grid[0] > 80) | (warp.grid[1] < -1) | (warp.grid[1] > 60)
    assert not inside[outside].any()


def test_distortion_moves_corners_by_its_share() -> None:
    columns, rows = Warp(np.eye(3), 0.1, (61, 81)).grid
    assert columns[30, 40] == pytest.approx(40, abs=1e-3)
    # The corner lies at about distance 1 from the middle.
    assert columns[0, 0] == pytest.approx(40 - 40 * 1.1, abs=0.15)
    assert rows[0, 0] == pytest.approx(30 - 30 * 1.1, abs=0.15)


def test_the_sample_with_a_map_is_the_sample() -> None:
    photos = [_photo(k) for k in range(3)]
    maps = [np.full((60, 80), k, np.float32) for k in range(3)]
    for seed in range(4):
        image, labels = training_sample(photos, 1, (48, 64), np.random.default_rng(seed))
        again = training_sample_with_map(photos, maps, 1, (48, 64), np.random.default_rng(seed))
        assert np.array_equal(image, again[0])
        assert np.array_equal(labels, again[1])
        assert again[2].dtype == np.float32
        assert again[2].shape == (48, 64)
        known = again[2][np.isfinite(again[2])]
        assert known == pytest.approx(1)
        assert np.isnan(again[2][labels == IGNORE]).all()


def test_another_material_stays_on_its_surface() -> None:
    photo = _photo()
    changed = 0
    for seed in range(12):
        result = retexture(photo.image, photo.labels, np.random.default_rng(seed))
        differs = (result != photo.image).any(axis=2)
        touched = np.unique(photo.labels[differs])
        assert len(touched) <= 1
        changed += len(touched)
    assert changed > 8


def test_light_and_camera_keep_size_and_type() -> None:
    photo = _photo()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        lit = sun_and_shade(photo.image, photo.labels, rng)
        taken = camera_effects(lit, rng)
        assert lit.shape == taken.shape == photo.image.shape
        assert lit.dtype == taken.dtype == np.uint8


def test_pasted_patches_are_other_and_the_rest_is_as_before() -> None:
    photo = _photo()
    image, labels = paste_patches(photo.image, photo.labels, np.random.default_rng(1))
    same = labels == photo.labels
    assert (labels[~same] == OTHER).all()
    assert (~same).sum() > 20
    untouched = (image == photo.image).all(axis=2)
    assert untouched[same & (labels != OTHER)].all()
