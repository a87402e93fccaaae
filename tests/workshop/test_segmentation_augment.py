import dataclasses

import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL, WINDOW
from plan2scene_workshop.segmentation.augment import training_batch
from plan2scene_workshop.segmentation.data import LabelledPhoto

COLOURS = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]], np.uint8)


def _photo(seed=0, size=(60, 80)):
    labels = np.full(size, WALL, np.uint8)
    labels[:15], labels[45:] = CEILING, FLOOR
    labels[20:40, 30:50] = OTHER
    return LabelledPhoto(f"p{seed}", COLOURS[labels], labels)


def _batch(photos, elevations, seed, size=(32, 64)):
    return training_batch(photos, elevations, size, np.random.default_rng(seed))


def test_labels_elevations_and_geometry_stay_together():
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
        known = ~batch.elevations.isnan() & (labels != OTHER)
        agreed.append((batch.elevations[known] * 4 == labels[known]).float().mean())
        deep = (geometry[:, 3][known] == labels[known] + 1).float().mean()
        assert deep > 0.9  # half the resolution: all but borders
        assert (geometry.permute(0, 2, 3, 1)[labels == IGNORE] == 0).all()
        sides |= set(geometry[:, 0].unique().tolist())
        assert set(labels.unique().tolist()) <= {OTHER, FLOOR, WALL, CEILING, IGNORE}
        assert batch.openings.tolist() == [True, False] * 4
        turned += int((labels == IGNORE).any())
    assert min(agreed) > 0.999 and turned > 0
    assert sides == {-1.0, 0.0, 1.0}  # mirrored views see a normal to the right as one to the left


def test_amodal_labels_are_learned_and_only_openings_put_in_front_change_them():
    """Without what is put in front, they are the floor everywhere that the photo is."""
    photo = _photo()
    amodal = np.full_like(photo.labels, FLOOR)
    photos = [dataclasses.replace(photo, amodal=amodal)] * 7
    window = dataclasses.replace(photo, labels=np.full_like(photo.labels, WINDOW), amodal=amodal)
    told = [np.zeros(photo.labels.shape, np.float32)] * 8
    learned = [_batch([*photos, window], told, seed).labels for seed in range(12)]
    for labels in learned:
        assert set(labels.unique().tolist()) <= {FLOOR, WINDOW, IGNORE}
        assert WINDOW not in labels[1:]  # a view takes things from the view before it
    assert any((labels[0] == WINDOW).any() for labels in learned)
