from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.io import read_json
from plan2scene.photos.labels import palette as masks
from plan2scene.photos.labels.labeller import Labelled, Labeller, labeller
from plan2scene.photos.masks import make_masks
from plan2scene.photos.photo_files import read_photo
from plan2scene_app.workflow.planning import lacks_rooms


def _photo(height=60, width=80):
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), dtype=np.uint8)


def _labels(height=60, width=80):
    labels = np.full((height, width), masks.WALL, np.uint8)
    labels[: height // 4] = masks.CEILING
    labels[-height // 3 :] = masks.FLOOR
    labels[20:30, 20:30] = masks.OTHER
    return labels


def test_values_of_a_palette_or_grey_png_are_labels(tmp_path):
    labels = _labels()
    marked = labels.copy()
    marked[0, 0] = masks.IGNORE
    masks.write_label_png(tmp_path / "written.png", marked)
    assert np.array_equal(masks.read_label_png(tmp_path / "written.png"), marked)
    with Image.open(tmp_path / "written.png") as image:
        assert image.mode == "P"
        assert np.asarray(image.convert("RGB"))[5, 5].tolist() == list(masks.PALETTE[3])
    own = Image.fromarray(labels, mode="P")
    own.putpalette([255, 0, 255, 9, 9, 9, 0, 0, 0, 1, 2, 3, 5, 5, 5])
    own.save(tmp_path / "own.png")
    Image.fromarray(labels).save(tmp_path / "grey.png")
    for name in ("own.png", "grey.png"):
        assert np.array_equal(masks.read_label_png(tmp_path / name), labels)


def test_read_label_png_refuses_what_is_no_mask(tmp_path):
    (tmp_path / "text.png").write_text("no image")
    write_png(tmp_path / "colour.png", _photo())
    write_png(tmp_path / "grey.png", np.full((4, 4), 6, np.uint8))
    Image.new("L", (9000, 6000)).save(tmp_path / "huge.png")
    found = {"gone": "no such file", "text": "found text", "colour": "mode RGB"}
    value = r"labels 0 to 5 \(or 255\), found value 6"
    for name, words in {**found, "grey": value, "huge": "found 9000x6000"}.items():
        with pytest.raises(InputError, match=rf"{name}\.png.*{words}"):
            masks.read_label_png(tmp_path / f"{name}.png")


def test_large_photos_and_their_masks_are_reduced_together(tmp_path):
    labels = np.zeros((1800, 3200), np.uint8)
    labels[900:, :] = masks.FLOOR
    labels[:, 1600:] = masks.WALL
    colours = np.array([[10, 20, 30], [200, 100, 50], [90, 180, 240]], np.uint8)
    write_png(tmp_path / "room.png", colours[labels])
    photo = read_photo(tmp_path / "room.png")
    assert photo.shape == (900, 1600, 3)
    masks.write_label_png(tmp_path / "masks" / "room.png", labels)
    found = masks.labels_from_folder(tmp_path / "masks", "room.png", (900, 1600))
    assert np.array_equal(colours[found], photo)
    masks.write_label_png(tmp_path / "masks" / "room.png", found)
    again = masks.labels_from_folder(tmp_path / "masks", "room.png", (900, 1600))
    assert np.array_equal(again, found)
    with pytest.raises(InputError, match=r"1600x900, found 1800x3200"):
        masks.write_label_png(tmp_path / "masks" / "room.png", labels.T)
        masks.labels_from_folder(tmp_path / "masks", "room.png", (900, 1600))


def test_unknown_sources_missing_folders_and_two_photos_with_one_stem_are_refused(tmp_path):
    with pytest.raises(InputError, match="embedded, imagenet, precomputed, pretrained"):
        labeller("guess", house_id="h")
    with pytest.raises(InputError, match=r"house h.*masks"):
        labeller("precomputed", precomputed_dir=tmp_path / "none", house_id="h")
    with pytest.raises(InputError, match="model"):
        labeller("embedded")
    photos = {name: tmp_path / name for name in ("a.png", "a.jpg")}
    with pytest.raises(InputError, match=r"a\.jpg and a\.png"):
        make_masks(photos, partial(labeller, "embedded"), tmp_path / "out", house_id="h")
    assert not (tmp_path / "out").exists()


def test_what_only_tells_rooms_is_made_where_one_is_sought(tmp_path):
    photo = np.kron(_photo(), np.ones((5, 5, 1), np.uint8))
    (tmp_path / "labels").mkdir()
    for number, name in enumerate(("a", "b")):
        write_png(tmp_path / f"{name}.png", np.roll(photo, 20 * number, axis=(0, 1)))
        masks.write_label_png(tmp_path / "labels" / f"{name}.png", _labels(300, 400))
    photos = {name: tmp_path / name for name in ("a.png", "b.png")}
    label = partial(labeller, "precomputed", precomputed_dir=tmp_path / "labels", house_id="h")
    made = []
    for find_rooms in ("embedded", None):
        make_masks(photos, label, tmp_path / "out", house_id="h", find_rooms=find_rooms)
        files = ("cameras.json", "kinds.json", "likeness.json")
        made.append([read_json(tmp_path / "out" / file) for file in files])
    sought, told = made
    assert told == [sought[0], {"source": "", "photos": {}}, []]
    assert sought[1]["source"] == "embedded"
    assert [pair[:2] for pair in sought[2]] == [["a.png", "b.png"]]


def test_what_looks_taken_from_outside_shows_a_room_by_its_floor(tmp_path):
    (tmp_path / "labels").mkdir()
    for name, labels in (("room", _labels(300, 400)), ("garden", np.zeros((300, 400), np.uint8))):
        write_png(tmp_path / f"{name}.png", np.kron(_photo(), np.ones((5, 5, 1), np.uint8)))
        masks.write_label_png(tmp_path / "labels" / f"{name}.png", labels)
    photos = {name: tmp_path / name for name in ("room.png", "garden.png")}
    kinds = np.eye(len(masks.KINDS))[0]
    ready = labeller("precomputed", precomputed_dir=tmp_path / "labels", house_id="h")
    ready = replace(ready, kinds=lambda image: kinds, outside=lambda image: True)
    make_masks(photos, lambda: ready, tmp_path / "out", house_id="h")
    found = read_json(tmp_path / "out" / "kinds.json")["photos"]
    assert found == {"room.png": kinds.tolist(), "garden.png": [0.0] * len(masks.KINDS)}


def test_probabilities_of_visible_and_amodal_labels_are_written_apart(tmp_path):
    write_png(tmp_path / "a.png", np.kron(_photo(), np.ones((5, 5, 1), np.uint8)))
    seen, behind = (np.zeros((6, 6, 8), np.float32) for _ in range(2))
    seen[masks.OTHER], behind[masks.WALL] = 1, 1
    ready = Labeller(lambda *_: Labelled(_labels(300, 400), seen, behind))
    make_masks({"a.png": tmp_path / "a.png"}, lambda: ready, tmp_path / "out", house_id="h")
    for folder, expected in ((masks.PROBABILITIES, seen), (masks.AMODAL, behind)):
        found = masks.read_probability_png(tmp_path / "out" / folder / "a.png")
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    ("rows", "lacks"), [("hall,a.jpg\n", False), ("hall,a.jpg\n,b.jpg\n", True), ('"', False)]
)
def test_a_photo_table_tells_whether_it_leaves_a_room_out(tmp_path, rows, lacks):
    (tmp_path / "photos.csv").write_text(f"room_id,photo\n{rows}")
    assert lacks_rooms(tmp_path / "photos.csv") is lacks


def test_masks_that_tell_openings_are_read_with_and_without_them(tmp_path):
    labels = _labels()
    labels[40:44] = masks.DOOR
    labels[20:30, 20:30] = masks.WINDOW
    path = tmp_path / "a.png"
    masks.write_label_png(path, labels)
    assert np.array_equal(masks.read_label_png(path, openings=True), labels)
    assert np.array_equal(masks.read_label_png(path), masks.without_openings(labels))
    assert masks.labels_from_folder(tmp_path, "a.jpg", (60, 80)).max() == masks.CEILING
