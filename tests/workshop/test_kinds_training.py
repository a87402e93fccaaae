from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from plan2scene.images import read_image
from plan2scene.photos.labels import kinds
from plan2scene.photos.labels.palette import KINDS
from plan2scene.photos.labels.segmentation import load_segmenter
from plan2scene.photos.locate.which_room import KIND_OF
from plan2scene.weights import MODELS
from plan2scene_workshop.homes import snapshots
from plan2scene_workshop.homes.residences import write_dataset_index
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.kinds.training import KindsSettings, photos_of_split, train_kinds
from plan2scene_workshop.rendering.sources import Sources

pytest.importorskip("drjit", exc_type=ImportError)
SEGMENTATION = MODELS / "segmentation.safetensors"


def coloured_shots(house, room_id, *_, long_side, listed, **__):
    assert listed
    kind = KINDS.index(KIND_OF.get(house.room(room_id).types[0], KINDS[0]))
    image = np.full((long_side, long_side, 3), 60, np.uint8)
    image[..., kind % 3] += np.uint8(190 - 90 * (kind // 3))
    labels = np.zeros(image.shape[:2], np.uint8)
    yield SimpleNamespace(image=image, labels=labels, camera={"room_id": room_id}, amodal=None)


def test_training_on_listed_homes_tells_their_rooms(tmp_path, monkeypatch):
    monkeypatch.setattr(kinds, "SIDE", 64)
    monkeypatch.setattr(snapshots, "shoot_room", coloured_shots)
    monkeypatch.setattr(snapshots, "load_mitsuba", lambda variant: None)
    monkeypatch.setattr(snapshots, "assign_materials", partial(assign_materials, size_px=32))
    options = snapshots.SnapshotOptions(views=1, long_side=64, targets=False, listed=True)
    homes = {"k_1": "train", "k_2": "val"}
    for k, (name, split) in enumerate(homes.items()):
        snapshots.write_snapshots(tmp_path, name, split, k, options, sources=Sources())
    write_dataset_index(tmp_path, homes, 0)
    model, card = tmp_path / "kinds.safetensors", tmp_path / "kinds.md"
    train_kinds(tmp_path, SEGMENTATION, model, card, settings=KindsSettings(), seed=0)
    classifier = kinds.load_kinds(model, load_segmenter(SEGMENTATION))
    seen, held_out = (list(photos_of_split(tmp_path, split)) for split in ("train", "val"))
    for path, room_kinds in seen:
        assert KINDS[classifier(read_image(path)).argmax()] in room_kinds
    assert f"| held-out renderings | {len(held_out)} |" in card.read_text()
