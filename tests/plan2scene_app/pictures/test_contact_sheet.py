from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from sample_houses import rooms_in_a_row
from views import camera_looking

from plan2scene.house import House
from plan2scene.images import png_bytes, write_png
from plan2scene.io import write_json, write_parquet
from plan2scene.photos.camera.lines import SEGMENTS, find_segments, write_segments
from plan2scene.photos.crops.candidates import planes_of_photo
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL, write_label_png
from plan2scene.photos.planes.planes import plane_row, write_planes
from plan2scene_app.contact_sheet import sheet as layout
from plan2scene_app.contact_sheet.panels import LAST_RESORT, REJECTED, SELECTED

SIZE = (240, 320)
CAMERA = camera_looking(SIZE, focal=256.0)
HOUSE = House("h1", rooms_in_a_row(r1="Bedroom"), ())


def room_labels():
    labels = np.full(SIZE, WALL, np.uint8)
    labels[170:] = FLOOR
    labels[:60] = CEILING
    return labels


def candidate(photo, surface, index, reason, crop_id):
    top, left = {"floor": 190, "wall": 90, "ceiling": 10}[surface], 20 + 24 * index
    corners = [left, top, left + 30, top, left + 30, top + 30, left, top + 30]
    place = {"photo": photo, "room_id": "r1", "surface": surface, "plane": 0, "index": index}
    verdict = {"reason": reason, "crop_id": crop_id}
    return place | verdict | {"metres": 0.5, "corners": [float(value) for value in corners]}


@pytest.fixture
def case(tmp_path):
    photos, masks = tmp_path / "photos", tmp_path / "masks"
    photos.mkdir()
    masks.mkdir()
    image = np.random.default_rng(0).integers(90, 160, (*SIZE, 3), dtype=np.uint8)
    write_png(photos / "a.png", image)
    (photos / "b.jpg").write_text("text")
    write_png(photos / "c.png", np.zeros((1, 1, 3), np.uint8))
    write_label_png(masks / "a.png", room_labels())
    write_json(masks / "cameras.json", {"a.png": CAMERA.to_json()})
    write_segments(masks / SEGMENTS, {"a.png": find_segments(image)})
    planes = planes_of_photo(room_labels(), CAMERA, None, [HOUSE.room("r1")])
    rows = [plane_row("a.png", item) for item in planes]
    write_planes(tmp_path / "planes.parquet", rows, dataset="d", house_id="h1")
    lines = ["photo b.jpg left out: no image", "photo c.png left out: file c.png: far too small"]
    write_json(masks / "warnings.json", lines)
    rows = [
        candidate("a.png", "wall", 0, "", "wall/a_0_crop0"),
        candidate("a.png", "wall", 1, "", "wall/a_0_crop1"),
        candidate("a.png", "ceiling", 0, "last resort: not sharp", "ceiling/a_0_crop0"),
        candidate("a.png", "wall", 2, "border, clutter", ""),
        candidate("a.png", "floor", 0, "oblique", ""),
        candidate("a.png", "floor", 1, "oblique", ""),
    ]
    write_parquet(tmp_path / "candidates.parquet", pd.DataFrame(rows), {})
    crop = png_bytes(np.full((128, 128, 3), 77, np.uint8))
    ids = [row["crop_id"] for row in rows if row["crop_id"]]
    frame = pd.DataFrame({"crop_id": ids, "png": [crop] * len(ids)})
    write_parquet(tmp_path / "crops.parquet", frame, {})
    return {
        "output": tmp_path / "sheet.png",
        "photos": {name: photos / name for name in ("a.png", "b.jpg", "c.png", "gone.jpg")},
        "rooms_of_photo": {"a.png": ["r1"]},
        "house": HOUSE,
        "files": layout.SheetFiles(
            *(tmp_path / f"{name}.parquet" for name in ("crops", "candidates", "planes")), masks
        ),
    }


def sheet_of(case):
    with Image.open(case["output"]) as image:
        return np.asarray(image.convert("RGB"))


def frames(sheet, row):
    top = layout.HEADER + row * layout.ROW + layout.TITLE + 2
    left = layout.GAP + layout.PANELS * (layout.PANEL[1] + layout.GAP)
    cells = [
        sheet[
            top + k // layout.COLUMNS * layout.CELL[0] + 1,
            left + k % layout.COLUMNS * layout.CELL[1] + layout.THUMB // 2,
        ]
        for k in range(3 * layout.COLUMNS)
    ]
    return [tuple(int(v) for v in cell) for cell in cells]


def test_each_photo_has_a_row_of_framed_windows_or_says_why_it_was_left_out(case):
    counts = layout.write_contact_sheet(**case)
    sheet = sheet_of(case)
    assert counts == {"photos": 4, "selected": 2, "last_resort": 1, "rejected": 3}
    assert sheet.shape == (layout.HEADER + 4 * layout.ROW, layout.WIDTH, 3)
    found = frames(sheet, 0)
    assert sorted(found[: layout.COLUMNS][:3]) == sorted([SELECTED, SELECTED, LAST_RESORT])
    assert found[layout.COLUMNS : layout.COLUMNS + 3] == [REJECTED] * 3
    assert SELECTED not in found[3:]
    assert not {SELECTED, LAST_RESORT, REJECTED} & set(frames(sheet, 1))
    for row in (1, 2, 3):
        top = layout.HEADER + row * layout.ROW
        part = sheet[top + layout.TITLE : top + layout.ROW]
        assert (np.abs(part.astype(int) - REJECTED).sum(axis=2) < 60).sum() > 100


def test_many_photos_make_a_bounded_sheet(case):
    case["photos"] = {f"p{k:03}.jpg": Path("none") / f"p{k:03}.jpg" for k in range(400)}
    assert layout.write_contact_sheet(**case)["photos"] == layout.MAX_PHOTOS
    assert sheet_of(case).shape[0] == layout.HEADER + layout.MAX_PHOTOS * layout.ROW


def test_no_photos_and_ready_crops(case):
    frame = pd.read_parquet(case["files"].candidates)
    frame["corners"] = [[float("nan")] * 8] * len(frame)
    write_parquet(case["files"].candidates, frame, {})
    case["files"] = replace(case["files"], masks=None)
    assert layout.write_contact_sheet(**case)["selected"] == 2
    write_parquet(case["files"].candidates, frame.iloc[:0], {})
    case["photos"] = {}
    assert not any(layout.write_contact_sheet(**case).values())
