import shutil
from dataclasses import replace

import cv2
import numpy as np
import pandas as pd
import pytest
from views import camera_looking

from plan2scene.errors import InputError
from plan2scene.house import House, Room
from plan2scene.images import image_from_bytes, medoid_index, write_png
from plan2scene.io import read_json, read_parquet, write_json
from plan2scene.photos.camera.lines import SEGMENTS, find_segments, write_segments
from plan2scene.photos.crops import extract_crops as stage
from plan2scene.photos.crops.filter import judge_of
from plan2scene.photos.crops.sampling import (
    ENOUGH,
    Candidate,
    Crop,
    CropSettings,
    Reason,
    Verdict,
    sample_candidates,
)
from plan2scene.photos.crops.selection import CANDIDATE_COLUMNS, COLUMNS, MOST, write_tables
from plan2scene.photos.labels.palette import write_label_png
from plan2scene.photos.planes.planes import PhotoPlane, Plane, plane_of_row, plane_row, read_planes

SIZE = (480, 640)


def looking(pitch_deg=20.0, focal=520.0, turn_deg=0.0):
    return camera_looking(SIZE, heading_deg=turn_deg, pitch_deg=pitch_deg, focal=focal)


def checkered_floor(camera, height=1.5, cell=0.25):
    rays = camera.rays_at(*np.indices(SIZE))
    down = rays[..., 1] < -0.05
    point = rays * np.where(down, -height / np.where(down, rays[..., 1], -1.0), 0.0)[..., None]
    odd = (np.floor(point[..., 0] / cell) + np.floor(point[..., 2] / cell)).astype(int) % 2
    image = np.where(down, np.where(odd, 70, 200), 128).astype(np.uint8)
    plane = Plane("floor", 0, (0.0, 1.0, 0.0), -height, down, "camera_height")
    return np.repeat(image[..., None], 3, axis=2), plane


def test_crops_are_metric_and_square_on():
    camera = looking(turn_deg=31.0)
    image, plane = checkered_floor(camera, cell=0.25)
    metre = CropSettings(sizes_m=(1.0,))
    drawn = sample_candidates(image, camera, plane, np.random.default_rng(0), metre)
    assert len(drawn) == 10
    for crop in (candidate.crop for candidate in drawn):
        assert crop.size_m == pytest.approx(1.0, abs=0.01)
        x0, z0, _, _ = crop.window
        step = crop.size_m / 128
        x = x0 + (np.arange(128) + 0.5) * step
        z = z0 + (np.arange(128) + 0.5) * step
        odd = (np.floor(x / 0.25)[None, :] + np.floor(z / 0.25)[:, None]) % 2
        expected = np.where(odd, 70, 200)
        wrong = np.abs(crop.image[..., 0].astype(int) - expected) > 65
        assert wrong.mean() < 0.08  # blurred borders only


def test_smaller_windows_of_a_wall_show_what_is_between_its_pictures():
    camera = looking(pitch_deg=0.0)
    rays = camera.rays_at(*np.indices(SIZE))
    ahead = rays[SIZE[0] // 2, SIZE[1] // 2].round(6)
    point = rays * (2.0 / (rays @ ahead))[..., None]
    right, up = point @ np.cross(ahead, (0.0, 1.0, 0.0)), point[..., 1]
    pictures = (right % 0.3 < 0.14) & (up % 0.3 < 0.14) & (right < 0.3)
    image = np.where(pictures[..., None], (40, 60, 160), (200, 140, 70))
    image = (image + np.random.default_rng(0).normal(0, 2, (*SIZE, 1))).astype(np.uint8)
    seen = (np.abs(right) < 1.0) & (np.abs(up) < 0.7)
    plane = Plane("wall", 0, tuple(-ahead), -2.0, seen, "plan")
    judge = judge_of("wall", inside=True)
    drawn = sample_candidates(image, camera, plane, np.random.default_rng(0), judge=judge)
    good = [candidate.crop for candidate in drawn if candidate.verdict.good]
    assert good
    assert max(crop.size_m for crop in good) < 0.8


def test_smaller_windows_where_large_ones_do_not_fit():
    camera = looking()
    image, plane = checkered_floor(camera)
    mask = np.zeros(SIZE, bool)
    mask[380:470, 260:380] = True
    small = Plane("floor", 0, plane.normal, plane.offset, mask, "x")
    drawn = sample_candidates(image, camera, small, np.random.default_rng(0))
    assert drawn
    assert drawn[0].crop.size_m < 0.4
    speck = np.zeros(SIZE, bool)
    speck[400:412, 300:312] = True
    tiny = Plane("floor", 0, plane.normal, plane.offset, speck, "x")
    assert sample_candidates(image, camera, tiny, np.random.default_rng(0)) == []


@pytest.fixture
def house():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    rooms = tuple(Room(name, ("Bedroom",), (ring,), 2.6) for name in ("room1", "room2"))
    return House("h1", rooms, ())


@pytest.fixture
def inputs(tmp_path):
    camera = looking()
    image, plane = checkered_floor(camera)
    write_png(tmp_path / "a.png", image)
    write_label_png(tmp_path / "masks" / "a.png", plane.mask.astype(np.uint8))
    write_json(tmp_path / "masks" / "cameras.json", {"a.png": camera.to_json()})
    write_segments(tmp_path / "masks" / SEGMENTS, {"a.png": find_segments(image)})
    return tmp_path


FILES = [f"{name}.parquet" for name in ("crops", "candidates", "planes", "colours")]
FILES.append("light.json")


def files_in(folder):
    return stage.CropFiles(*(folder / name for name in FILES))


def run(house, inputs, rooms_of_photo, **more):
    photos = {photo: inputs / photo for photo in rooms_of_photo}
    made = stage.crops_of_house(house, rooms_of_photo, photos, inputs / "masks", seed=3, **more)
    return stage.write_crops(made, files_in(inputs), dataset="d", house_id=house.id)


def test_stage_rows_and_planes_round_trip(house, inputs):
    run(house, inputs, {"a.png": ["room1", "room2"], "gone.png": ["room1"]})
    frame, metadata = read_parquet(inputs / "crops.parquet")
    assert metadata["house"] == "h1"
    assert list(frame.columns) == list(COLUMNS) and len(frame) == 20
    assert set(frame.photo) == {"a.png"}
    assert frame.groupby(["room_id", "surface"]).medoid.sum().tolist() == [1, 1]
    first = frame.iloc[0]
    assert first.crop_id == "floor/a_0_crop0"
    assert image_from_bytes(first.png).shape == (128, 128, 3)
    assert first.window[2] - first.window[0] == pytest.approx(first.metres)
    images = [image_from_bytes(png) for png in frame[frame.room_id == "room1"].png]
    assert frame[frame.room_id == "room1"].medoid.to_numpy().argmax() == medoid_index(images)
    run(house, inputs, {"a.png": ["room1", "room2"]})
    ((row,),) = read_planes(inputs / "planes.parquet").values()
    item = plane_of_row(row, SIZE)
    truth = checkered_floor(looking())[1]
    assert item.rooms == ("room1", "room2")
    assert item.plane.normal == truth.normal and item.plane.offset == truth.offset
    assert item.plane.mask.any() and not (item.plane.mask & ~truth.mask).any()
    assert not item.in_plan


def test_threads_change_nothing(house, inputs):
    masks = inputs / "masks"
    cameras = read_json(masks / "cameras.json")
    for other in ("b", "c"):
        shutil.copy(inputs / "a.png", inputs / f"{other}.png")
        shutil.copy(masks / "a.png", masks / f"{other}.png")
        cameras[f"{other}.png"] = cameras["a.png"]
    write_json(masks / "cameras.json", cameras)
    rooms = {f"{name}.png": ["room1"] for name in "abc"}
    made = []
    for threads in (1, 3):
        run(house, inputs, rooms, threads=threads)
        made.append([(inputs / name).read_bytes() for name in FILES])
    assert made[0] == made[1]


def test_candidates_have_corners_on_the_photo(house, inputs):
    run(house, inputs, {"a.png": ["room1"]})
    crops, _ = read_parquet(inputs / "crops.parquet")
    table, metadata = read_parquet(inputs / "candidates.parquet")
    assert metadata["house"] == "h1" and list(table.columns) == list(CANDIDATE_COLUMNS)
    kept = table[table.crop_id != ""]
    assert kept.crop_id.tolist() == crops.crop_id.tolist() and (kept.reason == "").all()
    camera, image = looking(), cv2.imread(str(inputs / "a.png"))
    row = kept.iloc[0]
    x0, z0, x1, z1 = row.window
    ring = np.array([[x0, -1.5, z0], [x1, -1.5, z0], [x1, -1.5, z1], [x0, -1.5, z1]])
    corners = np.array(row.corners).reshape(4, 2)
    np.testing.assert_allclose(corners, camera.project(ring), atol=1e-6)
    png = image_from_bytes(crops.png.iloc[0])
    for (x, y), (r, c) in zip(corners, ((0, 0), (0, 127), (127, 127), (127, 0)), strict=True):
        inner = corners.mean(axis=0) * 0.1 + np.array([x, y]) * 0.9
        near = image[round(inner[1]), round(inner[0]), 0].astype(int)
        assert abs(near - png[abs(r - 6), abs(c - 6), 0].astype(int)) < 70


def test_a_surface_of_many_photos_has_a_share_of_each(tmp_path):
    blank, window = np.zeros((128, 128, 3), np.uint8), (0.0, 0.0, 1.0, 1.0)
    verdicts = [Verdict()] * 10 + [Verdict.of([Reason.BLURRED], 0.5)]
    candidates = [
        Candidate(Crop(k, window, 1.0, 1.0, 90.0, blank), verdict, "floor", 0, photo, ("hall",))
        for photo in (f"{n:02d}.png" for n in range(2 * MOST // 10))
        for k, verdict in enumerate(verdicts)
    ]
    files = tmp_path / "crops.parquet", tmp_path / "candidates.parquet"
    crops = write_tables(candidates, *files, dataset="d", house_id="h")
    assert len(crops) == MOST and set(crops.groupby("photo").size()) == {5}
    table, _ = read_parquet(files[1])
    assert table.reason.value_counts().to_dict() == {"": MOST, ENOUGH: MOST, "not sharp": 12}


def test_rooms_of_other_heights_get_their_own_crops(inputs):
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
    heights = {"low": 2.2, "tall": 3.6, "same": 2.2}
    rooms = tuple(Room(name, ("Bedroom",), (ring,), h) for name, h in heights.items())
    labels = np.full(SIZE, 2, np.uint8)
    labels[checkered_floor(looking())[1].mask] = 1
    labels[:60] = 3
    write_label_png(inputs / "masks" / "a.png", labels)
    frame = run(House("h1", rooms, ()), inputs, {"a.png": list(heights)})
    ids = {name: set(frame[frame.room_id == name].crop_id) for name in heights}
    assert ids["low"] == ids["same"]
    assert ids["low"]
    assert not ids["low"] & ids["tall"]
    assert frame.groupby("crop_id").png.nunique().eq(1).all()


def test_a_floor_through_a_door_is_left_out_where_another_photo_shows_the_rooms_own(house, inputs):
    slate = np.full((*SIZE, 3), (120, 130, 120), np.uint8)
    both, floor = slate.copy(), checkered_floor(looking())[1].mask
    both[:, :380], floor[:, 380:420] = (130, 85, 45), False  # wood, more of it, left of a jamb
    for name, image in (("a", both), ("b", slate)):
        write_png(inputs / f"{name}.png", image)
        write_label_png(inputs / "masks" / f"{name}.png", floor.astype(np.uint8))
    camera = looking().to_json()
    write_json(inputs / "masks" / "cameras.json", {"a.png": camera, "b.png": camera})
    left = []
    for other in ("room2", "room1"):
        run(house, inputs, {"a.png": ["room1"], "b.png": [other]})
        (row,) = read_planes(inputs / "planes.parquet")["a.png"]
        left.append(plane_of_row(row, SIZE).plane.mask[:, :380].any())
    assert left == [True, False]
    crops, _ = read_parquet(inputs / "crops.parquet")
    assert all(image_from_bytes(png)[..., 2].mean() > 100 for png in crops.png)


def test_masks_survive_as_polygons():
    rng = np.random.default_rng(0)
    mask = cv2.GaussianBlur(rng.random(SIZE), (0, 0), 9) > 0.5  # pieces with holes
    plane = Plane("wall", 3, (0.0, 0.0, -1.0), -2.0, mask, "plan", 1.4)
    item = PhotoPlane(("a", "b"), plane, own=False, walls=("w1", "w2"))
    read = plane_of_row(plane_row("p.jpg", item), SIZE)
    assert (read.plane.mask == mask).all() and replace(read, plane=plane) == item


def test_house_without_photos_has_an_empty_table(house, inputs):
    run(house, inputs, {})
    frame, _ = read_parquet(inputs / "crops.parquet")
    assert len(frame) == 0 and list(frame.columns) == list(COLUMNS)
    assert frame["metres"].dtype == np.float64 and frame["medoid"].dtype == bool


def test_a_photo_of_another_size_than_its_mask(house, inputs):
    write_png(inputs / "a.png", np.zeros((40, 44, 3), np.uint8))
    with pytest.raises(InputError, match="size 44x40"):
        run(house, inputs, {"a.png": ["room1"]})


def test_precomputed_crops(house, tmp_path):
    rng = np.random.default_rng(0)
    for name in ("floor/x_1_0_crop2", "wall/x_1_7_crop0", "wall/other_0_crop0"):
        write_png(tmp_path / f"{name}.png", rng.integers(0, 255, (128, 128, 3)).astype(np.uint8))
    out = files_in(tmp_path)
    made = stage.read_precomputed_crops(house, {"x_1.jpg": ["room1"]}, tmp_path)
    frame = stage.write_crops(made, out, dataset="d", house_id="h1")
    assert frame.crop_id.tolist() == ["floor/x_1_0_crop2", "wall/x_1_7_crop0"]
    assert frame.plane.tolist() == [0, 7] and frame.metres.isna().all()
    assert frame.medoid.all()
    pd.testing.assert_series_equal(read_parquet(out.crops)[0].crop_id, frame.crop_id)
    write_png(tmp_path / "floor/x_1_0_crop3.png", np.zeros((64, 64, 3), np.uint8))
    with pytest.raises(InputError, match="128x128"):
        stage.read_precomputed_crops(house, {"x_1.jpg": ["room1"]}, tmp_path)
