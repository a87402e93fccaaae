"""Views for training: labels, elevations and picture move together."""

from __future__ import annotations

import numpy as np
import torch

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL
from plan2scene_workshop.segmentation.augment import training_batch
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.surfaces import recolour_labels, retexture


def _photo(seed: int = 0, size: tuple[int, int] = (60, 80)) -> LabelledPhoto:
    """Return a photo of four flat bands: ceiling, wall, a thing in it, floor."""
    labels = np.full(size, WALL, np.uint8)
    labels[:15], labels[45:] = CEILING, FLOOR
    labels[20:40, 30:50] = OTHER
    colours = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]], np.uint8)
    return LabelledPhoto(f"p{seed}", colours[labels], labels)


def _batch(photos: list[LabelledPhoto], elevations: list[np.ndarray], seed: int, size=(32, 64)):
    return training_batch(photos, elevations, size, np.random.default_rng(seed))


def test_views_have_their_size_and_depend_on_the_generator_alone() -> None:
    photos, unknown = [_photo(k) for k in range(4)], [np.full((60, 80), np.nan, np.float32)] * 4
    first = _batch(photos, unknown, 5)
    torch.manual_seed(1)
    again = _batch(photos, unknown, 5)
    assert [tuple(part.shape) for part in first] == [(4, 3, 32, 64), (4, 32, 64), (4, 32, 64)]
    assert first[0].min() >= 0 and first[0].max() <= 1
    assert first[1].isnan().all()
    for one, same in zip(first, again, strict=True):
        torch.testing.assert_close(one, same, rtol=0, atol=0, equal_nan=True)
    assert (first[0] != _batch(photos, unknown, 6)[0]).any()


def test_labels_and_elevations_stay_together() -> None:
    """Elevations that equal the labels still do in the view, but for things put in front."""
    photos = [_photo(k) for k in range(8)]
    told = [photo.labels.astype(np.float32) / 4 for photo in photos]
    turned, agreed = 0, []
    for seed in range(4):
        _, elevations, labels = _batch(photos, told, seed, (48, 64))
        known = ~elevations.isnan() & (labels != OTHER)
        agreed.append((elevations[known] * 4 == labels[known]).float().mean())
        assert elevations[labels == IGNORE].isnan().all()
        assert set(labels.unique().tolist()) <= {OTHER, FLOOR, WALL, CEILING, IGNORE}
        turned += int((labels == IGNORE).any())
    assert min(agreed) > 0.999
    assert turned > 0


def test_a_view_keeps_photo_and_labels_together() -> None:
    """Floors are green, before the colours of lamps and cameras: more so than walls."""
    photos, unknown = [_photo(k) for k in range(8)], [np.full((60, 80), np.nan, np.float32)] * 8
    found = []
    for seed in range(4):
        images, _, labels = _batch(photos, unknown, seed, (48, 64))
        for image, label in zip(images, labels, strict=True):
            green = image[1] - image[2]
            if (label == FLOOR).sum() > 40 and (label == WALL).sum() > 40:
                found.append(bool(green[label == FLOOR].median() > green[label == WALL].median()))
    assert len(found) > 15
    assert np.mean(found) > 0.75  # retextured floors and grey photos excepted


def test_recolouring_leaves_other_alone() -> None:
    photo = _photo(1)
    changed = recolour_labels(photo.image, photo.labels, np.random.default_rng(0))
    inside = (slice(22, 38), slice(32, 48))  # the tint is blurred by a pixel
    assert np.array_equal(changed[inside], photo.image[inside])
    assert not np.array_equal(changed, photo.image)


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
