from functools import partial

import cv2
import numpy as np
import pytest

from plan2scene.images import write_png
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.palette import FLOOR, OTHER, read_label_png, write_label_png
from plan2scene.photos.labels.watermark import reduced, shared_mark, watermarks
from plan2scene.photos.masks import make_masks

SIZE = (240, 360)


def letters():
    image = np.zeros(SIZE, np.uint8)
    cv2.putText(image, "AGENT", (200, 220), cv2.FONT_HERSHEY_SIMPLEX, 1.2, 255, 4)
    return image > 0


def rooms(count, *, marked):
    """Photos (h, w, 3) uint8 of boxes in many greys, with or without half transparent letters."""
    rng = np.random.default_rng(3)
    photos = []
    for _ in range(count):
        image = np.full((*SIZE, 3), rng.integers(60, 200), np.float64)
        for _ in range(40):
            x, y = rng.integers(0, SIZE[1]), rng.integers(0, SIZE[0])
            w, h = rng.integers(10, 120, 2)
            image[y : y + h, x : x + w] = rng.integers(20, 220, 3)
        if marked:
            image[letters()] = 0.5 * image[letters()] + 0.5 * 255
        photos.append(np.uint8(image))
    return photos


@pytest.mark.parametrize("count", [5, 9, 20])
def test_letters_over_all_photos_are_found(count):
    mark = shared_mark([reduced(photo) for photo in rooms(count, marked=True)])
    assert mark[letters()].mean() > 0.9 and mark.mean() < 3 * letters().mean()


def test_photos_of_about_one_size_share_a_mark_and_few_copies_and_one_view_none():
    photos = {f"{k}.png": reduced(p) for k, p in enumerate(rooms(6, marked=True))}
    for k in (1, 4):
        photos[f"{k}.png"] = cv2.resize(photos[f"{k}.png"], (SIZE[1] - k // 2, SIZE[0] + 1))
    marks = watermarks(photos)
    assert sorted(marks) == sorted(photos)
    assert all(mark[letters()].mean() > 0.9 for mark in marks.values())
    marked = rooms(6, marked=True)
    assert not shared_mark([reduced(photo) for photo in marked[:4]]).any()
    assert not shared_mark([reduced(marked[0])] * 6).any()
    copies = [reduced(photo) for photo in rooms(3, marked=True) for _ in range(8)]
    others = [reduced(photo) for photo in rooms(6, marked=False)[3:]]
    assert not shared_mark([*copies, *others]).any()


@pytest.mark.parametrize("count", [5, 6, 9, 20])
def test_photos_without_a_mark_have_none(count):
    photos = {f"{k}.png": reduced(p) for k, p in enumerate(rooms(count, marked=False))}
    assert watermarks(photos) == {}


def test_a_mark_is_on_no_floor(tmp_path):
    photos = {}
    (tmp_path / "given").mkdir()
    for k, photo in enumerate(rooms(6, marked=True)):
        photos[f"{k}.png"] = tmp_path / f"{k}.png"
        write_png(photos[f"{k}.png"], photo)
        write_label_png(tmp_path / "given" / f"{k}.png", np.full(SIZE, FLOOR, np.uint8))
    label = partial(labeller, "precomputed", precomputed_dir=tmp_path / "given")
    make_masks(photos, label, tmp_path / "masks", house_id="h")
    labels = read_label_png(tmp_path / "masks" / "3.png")
    assert (labels[letters()] == OTHER).mean() > 0.9 and (labels == FLOOR).mean() > 0.8
