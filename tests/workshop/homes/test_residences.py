import hashlib
import json
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from plan2scene.images import read_image
from plan2scene.io import read_json
from plan2scene.photos.labels.palette import read_label_png
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.validate import validate_house
from plan2scene.seeds import generator
from plan2scene_app.workflow.drops import read_unobserved
from plan2scene_app.workflow.house_table import read_table
from plan2scene_workshop.homes import residences
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.rendering import RenderedPhoto

OPTIONS = residences.ResidenceOptions(height=24, width=32, tile_px=32)


def fake_render(house, materials, accents, views, seed, *, height, width, **_):
    assert set(materials) == set(house.surface_keys())
    for view in views:
        rng = generator(seed, view.seed)
        image = rng.integers(0, 255, (height, width, 3)).astype(np.uint8)
        labels = rng.integers(0, 4, (height, width)).astype(np.uint8)
        planes = np.where(labels == 0, 255, labels).astype(np.uint8)
        camera = {"room_id": view.room_id, "planes": [], "rotation": view.rotation().tolist()}
        yield RenderedPhoto(view, image, labels, planes, camera)


@pytest.fixture(autouse=True, scope="module")
def _small_and_unrendered():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(residences, "render_house", fake_render)
        patch.setattr(residences, "assign_materials", partial(assign_materials, size_px=32))
        yield


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    root = tmp_path_factory.mktemp("residence")
    return root, residences.write_residence(root, "home_1", "val", 3, options=OPTIONS)


def digest(folder):
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def test_a_house_has_plan_photos_and_truth(written):
    root, house = written
    again = read_scene_json(root / "archs_no_objects/val/home_1.scene.json", "home_1")
    assert validate_house(again) == []
    assert again.rooms == house.rooms and again.adjacency() == house.adjacency()
    table = (root / "photo_assignments/val/home_1.photoroom.csv").read_text().splitlines()
    rows = [line.split(",") for line in table]
    assert rows[0] == ["room_id", "photo"] and 4 <= len(rows) - 1 <= 8
    truth = root / "truth/val/home_1"
    cameras = read_json(truth / "cameras.json")
    assert list(cameras) == [photo for _, photo in rows[1:]]
    for room, photo in rows[1:]:
        assert cameras[photo]["room_id"] == room
        assert read_image(root / "photos" / photo).shape == (24, 32, 3)
        assert read_label_png(truth / "masks" / f"{Path(photo).stem}.png").max() <= 3
        assert (truth / "planes" / f"{Path(photo).stem}.png").is_file()
    materials = json.loads((truth / "materials.json").read_text())
    assert set(materials) == {f"{k.room_id}/{k.surface}" for k in house.surface_keys()}
    for key in house.surface_keys():
        assert read_image(truth / "materials" / f"{key.filename}.png").shape == (32, 32, 3)
        assert materials[f"{key.room_id}/{key.surface}"]["size_m"] > 0.1


def test_same_seed_same_bytes_and_stale_photos_go(written, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos/home_1_77.jpg").write_bytes(b"old")
    residences.write_residence(tmp_path, "home_1", "val", 3, options=OPTIONS)
    assert digest(tmp_path) == digest(written[0])


def test_index_lists_houses_and_hides_nested_shares(tmp_path):
    root = tmp_path
    names = residences.residence_names("home", {"train": 1, "val": 1, "test": 0})
    assert names == {"home_train_000": "train", "home_val_000": "val"}
    for house, split in names.items():
        residences.write_residence(root, house, split, 3, options=OPTIONS)
    assert residences.write_dataset_index(root, names, 3) == []
    assert list(read_table(root / "houses.tsv").houses) == list(names)
    assert (root / "data_lists/train.txt").read_text() == "home_train_000\n"
    hidden = read_unobserved(root / "unobserved_photos.json")
    photos = {file.name for file in (root / "photos").iterdir()}
    assert hidden["0.0"] == [] and set(hidden["1.0"]) == photos
    assert all(a < b for a, b in pairwise([set(hidden[f"{k / 10:.1f}"]) for k in range(0, 11, 2)]))
    assert len(hidden["0.6"]) == pytest.approx(0.6 * len(photos), abs=3)
