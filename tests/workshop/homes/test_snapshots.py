from functools import partial
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from plan2scene.images import read_image
from plan2scene.io import read_json
from plan2scene.photos.labels.palette import read_label_png
from plan2scene_app.workflow.house_table import read_table
from plan2scene_workshop.homes import snapshots
from plan2scene_workshop.homes.residences import write_dataset_index
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.rendering.snapshots import Snapshot
from plan2scene_workshop.rendering.sources import Sources

pytest.importorskip("drjit", exc_type=ImportError)


def fake_shots(house, room_id, *_, long_side, amodal, **__):
    size = (3 * long_side // 4, long_side)
    for k in range(2):
        rng = np.random.default_rng(len(room_id) + k)
        yield Snapshot(
            SimpleNamespace(room_id=room_id),
            rng.integers(0, 255, (*size, 3)).astype(np.uint8),
            rng.integers(0, 6, size).astype(np.uint8),
            rng.integers(1, 255, (*size, 3)).astype(np.uint8),
            rng.integers(0, 9000, size).astype(np.uint16),
            {"room_id": room_id, "planes": []},
            np.full(size, 2, np.uint8) if amodal else None,
        )


@pytest.mark.parametrize("targets", [True, False])
def test_a_house_of_snapshots_is_a_data_set(tmp_path, monkeypatch, targets):
    monkeypatch.setattr(snapshots, "shoot_room", fake_shots)
    monkeypatch.setattr(snapshots, "load_mitsuba", lambda variant: None)
    monkeypatch.setattr(snapshots, "assign_materials", partial(assign_materials, size_px=32))
    options = snapshots.SnapshotOptions(views=2, long_side=32, targets=targets, amodal=targets)
    earlier = tmp_path / "photos" / "h_1_99.jpg"
    earlier.parent.mkdir()
    earlier.write_bytes(b"of a run with more photos")
    house = snapshots.write_snapshots(tmp_path, "h_1", "train", 5, options, sources=Sources())
    write_dataset_index(tmp_path, {"h_1": "train"}, 0)
    assert not earlier.exists()
    truth = tmp_path / "truth" / "train" / "h_1"
    cameras = read_json(truth / "cameras.json")
    assert sorted(read_table(tmp_path / "houses.tsv")["h_1"].photos) == sorted(cameras)
    rooms = {camera["room_id"] for camera in cameras.values()}
    assert len(cameras) >= 2 and rooms <= {room.id for room in house.rooms}
    folders = {"masks", "amodal", "normals", "depth"} if targets else {"masks"}
    assert {path.name for path in truth.iterdir() if path.is_dir()} == folders
    for name in cameras:
        stem = Path(name).stem
        assert read_image(tmp_path / "photos" / name).shape == (24, 32, 3)
        mask = cv2.imread(str(truth / "masks" / f"{stem}.png"), cv2.IMREAD_UNCHANGED)
        assert mask.shape[:2] == (24, 32)
        if targets:
            assert (read_label_png(truth / "amodal" / f"{stem}.png") == 2).all()
            depth = cv2.imread(str(truth / "depth" / f"{stem}.png"), cv2.IMREAD_UNCHANGED)
            assert depth.dtype == np.uint16 and 4000 < depth.max() < 9000
