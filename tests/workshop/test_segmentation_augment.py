"""Views for training: labels, elevations, geometry and picture move together."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL
from plan2scene_workshop.segmentation.augment import View, cut_view, training_batch, transplant
from plan2scene_workshop.segmentation.camera_looks import LOOKS, other_camera
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.surfaces import (
    FRONT,
    TOP,
    faced,
    recolour_labels,
    retexture,
)

COLOURS = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]], np.uint8)


def _photo(seed: int = 0, size: tuple[int, int] = (60, 80)) -> LabelledPhoto:
    """Return a photo of four flat bands: ceiling, wall, a thing in it, floor."""
    labels = np.full(size, WALL, np.uint8)
    labels[:15], labels[45:] = CEILING, FLOOR
    labels[20:40, 30:50] = OTHER
    return LabelledPhoto(f"p{seed}", COLOURS[labels], labels)


def _batch(photos: list[LabelledPhoto], elevations: list[np.ndarray], seed: int, size=(32, 64)):
    return training_batch(photos, elevations, size, np.random.default_rng(seed))


def test_views_have_their_size_and_depend_on_the_generator_alone() -> None:
    photos = [_photo(0, (60, 80)), _photo(1, (80, 60)), _photo(2), _photo(3)]
    unknown = [np.full(p.labels.shape, np.nan, np.float32) for p in photos]
    first, again = _batch(photos, unknown, 5), _batch(photos, unknown, 5)
    assert tuple(first.images.shape) == (4, 3, 32, 64)
    assert first.elevations.shape == first.labels.shape == (4, 32, 64)
    assert first.images.min() >= 0 and first.images.max() <= 1
    assert first.elevations.isnan().all()
    assert first.geometry is None
    torch.testing.assert_close(first.images, again.images, rtol=0, atol=0)
    assert torch.equal(first.labels, again.labels)
    assert (first.images != _batch(photos, unknown, 6).images).any()


def test_labels_elevations_and_geometry_stay_together() -> None:
    """Elevations and depths that equal the labels still do, but for things put in front."""
    photos, told = [], []
    for k in range(8):
        photo = _photo(k)
        half = photo.labels[::2, ::2]
        geometry = np.zeros((*half.shape, 4), np.float16)
        geometry[..., 0], geometry[..., 3] = 1, half + 1
        photos.append(dataclasses.replace(photo, geometry=geometry, openings=k % 2 == 0))
        told.append(photo.labels.astype(np.float32) / 4)
    turned, agreed, sides = 0, [], set()
    for seed in range(4):
        batch = _batch(photos, told, seed, (48, 64))
        labels, geometry = batch.labels, batch.geometry
        assert geometry is not None
        known = ~batch.elevations.isnan() & (labels != OTHER)
        agreed.append((batch.elevations[known] * 4 == labels[known]).float().mean())
        deep = (geometry[:, 3][known] == labels[known] + 1).float().mean()
        assert deep > 0.9  # half the resolution: all but borders
        assert (geometry.permute(0, 2, 3, 1)[labels == IGNORE] == 0).all()
        sides |= set(geometry[:, 0].unique().tolist())
        assert set(labels.unique().tolist()) <= {OTHER, FLOOR, WALL, CEILING, IGNORE}
        assert batch.openings.tolist() == [True, False] * 4
        turned += int((labels == IGNORE).any())
    assert min(agreed) > 0.999
    assert turned > 0
    assert sides == {-1.0, 0.0, 1.0}  # mirrored views see a normal to the right as one to the left


def test_a_view_keeps_photo_and_labels_together() -> None:
    photo = _photo()
    for seed in range(20):
        unknown = np.full((60, 80), np.nan, np.float32)
        view = cut_view(photo, unknown, (48, 64), np.random.default_rng(seed))
        assert view.image.shape == (48, 64, 3)
        near = np.abs(view.image.astype(int) - COLOURS[view.labels]).max(axis=2) < 8
        assert near.mean() > 0.85  # all but borders


@pytest.mark.parametrize("look", [look for look, _ in LOOKS])
def test_every_look_changes_a_picture_and_keeps_its_shape(look) -> None:
    image = _photo().image.astype(np.float32) / 255
    changed = look(image.copy(), np.random.default_rng(0))
    assert changed.shape == image.shape
    assert np.isfinite(changed).all()
    assert np.abs(changed - image).max() > 0.01


def test_another_camera_gives_bytes_by_its_generator() -> None:
    image = _photo().image
    found = [other_camera(image, np.random.default_rng(k)) for k in (0, 0, 1)]
    assert found[0].dtype == np.uint8
    assert np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])


def test_things_of_another_view_come_with_their_label() -> None:
    photo, sines = _photo(), np.zeros((60, 80), np.float32)
    other = View(np.full_like(photo.image, 7), photo.labels, sines, None)
    view = View(photo.image, np.full((60, 80), WALL, np.uint8), sines, None)
    transplant(view, other, np.random.default_rng(1))
    put = (view.image == 7).all(axis=2)
    assert put.any()
    assert (view.labels[put] == OTHER).all()
    assert (view.labels[~put] == WALL).all()
    assert not (photo.image == 7).any()


def test_recolouring_leaves_other_alone() -> None:
    photo = _photo(1)
    changed = recolour_labels(photo.image, photo.labels, np.random.default_rng(0))
    inside = (slice(22, 38), slice(32, 48))  # the tint is blurred by a pixel
    assert np.array_equal(changed[inside], photo.image[inside])
    assert not np.array_equal(changed, photo.image)


def test_tops_and_fronts_of_things_are_told_by_their_normals_but_not_rugs() -> None:
    labels = np.full((40, 40), WALL, np.uint8)
    labels[20:], labels[22:28, 10:20], labels[30:38, 10:20] = FLOOR, OTHER, OTHER
    labels[10:22, 10:20] = OTHER
    geometry = np.zeros((40, 40, 4), np.float32)
    geometry[..., 2], geometry[..., 3] = -1, 3
    geometry[20:, :, :3] = (0, -1, 0)
    geometry[20:, :, 3] = 20 / np.arange(1, 21)[:, None]  # a plane: linear in its inverse
    geometry[20:28, 10:20, 3] *= 0.5  # a table's top stands above it, a rug does not
    found = faced(labels, geometry)
    assert (found[20:28, 10:20] == TOP).all()
    assert (found[10:20, 10:20] == FRONT).all()
    assert (found[30:38, 10:20] == OTHER).all()
    assert ((found == labels) | (labels == OTHER)).all()
    assert faced(labels, None) is labels


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
