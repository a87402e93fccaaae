from dataclasses import replace

import numpy as np
import pytest
from box_room import HEIGHT, SIZE, VIEWS, WIDE, box_house, open_door_view, shot
from masks_folder import write_masks

from plan2scene.datasets.assignments import PhotoAssignment, read_assignment
from plan2scene.errors import InputError
from plan2scene.house import Opening, Wall
from plan2scene.io import read_json, write_json
from plan2scene.photos.labels import palette
from plan2scene.photos.locate.likelihood import agreement, log_table, make_profile
from plan2scene.photos.locate.locate_photos import (
    Shot,
    locate_photos,
    locate_shots,
    write_photo_rooms,
)
from plan2scene.photos.locate.locate_settings import LOCATE
from plan2scene.photos.locate.plan_view import look, room_shapes
from plan2scene.photos.locate.pose import Pose, pose_from_json, pose_to_json, read_poses, turned


@pytest.mark.parametrize(("heading_deg", "eye"), VIEWS)
def test_a_photo_is_found_where_it_was_taken(heading_deg, eye):
    house = box_house()
    photo, true = shot(house, heading_deg, eye)
    pose = locate_shots(house, {"a.jpg": photo}).poses["a.jpg"]
    assert pose.room_id == "room" and pose.believed
    np.testing.assert_allclose(pose.camera.matrix, true.matrix, atol=1e-6)
    np.testing.assert_allclose(pose.eye, eye, atol=0.08)


def test_an_empty_square_room_tells_no_heading():
    house = box_house(openings=False, wide=4.0, deep=4.0)
    photo, _ = shot(house, 30.0, (1.0, 1.5, 1.0))
    pose = locate_shots(house, {"a.jpg": photo}).poses["a.jpg"]
    assert not pose.believed
    entry = pose_to_json(photo.camera, pose)
    assert entry["room_id"] is None and entry["position"] is None
    assert entry["located"] == pytest.approx(pose.located, abs=1e-4)
    assert pose_from_json(entry) is None


def test_probabilities_round_trip(tmp_path):
    rng = np.random.default_rng(0)
    values = rng.dirichlet(np.ones(6), (4, 5)).transpose(2, 0, 1).astype(np.float32)
    palette.write_probability_png(tmp_path / "a.png", values)
    found = palette.read_probability_png(tmp_path / "a.png")
    np.testing.assert_allclose(found, values, atol=0.5 / 255)
    palette.write_probability_png(tmp_path / "b.png", values[:5])
    with pytest.raises(InputError, match="rows of 6 labels"):
        palette.read_probability_png(tmp_path / "b.png")


def test_what_furniture_hides_is_taken_from_amodal_labels():
    photo, _ = shot(box_house(), *VIEWS[0])
    seen, behind = np.zeros((2, 6, 4, 8), np.float32)
    seen[palette.FLOOR], seen[palette.OTHER] = 0.3, 0.7
    behind[palette.WALL], behind[palette.WINDOW] = 0.25, 0.75
    mixed = replace(photo, probabilities=seen, amodal=behind[:, ::2]).structure
    expected = {palette.FLOOR: 0.3, palette.WALL: 0.7 * 0.25, palette.WINDOW: 0.7 * 0.75}
    for label, plane in enumerate(mixed):
        np.testing.assert_allclose(plane, expected.get(label, 0.0), atol=1e-6)
    house = box_house()
    bare, true = shot(house, *VIEWS[0])
    behind = np.eye(6, dtype=np.float32)[bare.labels].transpose(2, 0, 1)
    hidden = np.where(np.arange(len(bare.labels))[:, None] > 20, palette.OTHER, bare.labels)
    seen = np.eye(6, dtype=np.float32)[hidden].transpose(2, 0, 1)
    photos = {
        "without.jpg": replace(bare, labels=hidden, probabilities=seen),
        "with.jpg": replace(bare, labels=hidden, probabilities=seen, amodal=behind),
    }
    np.testing.assert_array_equal(photos["without.jpg"].structure, seen)
    poses = {name: locate_shots(house, {name: one}).poses[name] for name, one in photos.items()}
    assert np.abs(poses["with.jpg"].eye - VIEWS[0][1]).max() < 0.2
    assert poses["with.jpg"].located > poses["without.jpg"].located
    assert (true.matrix[2] @ poses["with.jpg"].camera.matrix[2]) > 0.99


def test_cameras_json_round_trip(tmp_path):
    photo, _ = shot(box_house(), 230.0, (0.6, 1.5, 2.9))
    pose = Pose("room", (0.6, 1.5, 2.9), turned(photo.camera, 1.2), 0.83)
    write_json(tmp_path / "cameras.json", {"a.jpg": pose_to_json(photo.camera, pose)})
    assert read_poses(tmp_path / "cameras.json") == {"a.jpg": pose}
    with pytest.raises(InputError, match="located camera"):
        pose_from_json({**pose_to_json(photo.camera, pose), "position": [1, 2]})


def test_the_stage_writes_every_camera(tmp_path):
    house = box_house()
    photo, true = shot(house, 230.0, (0.6, 1.5, 2.9))
    cameras = dict.fromkeys(("a.jpg", "b.jpg"), photo.camera.to_json())
    masks = write_masks(tmp_path / "masks", dict.fromkeys("ab", photo.labels), cameras)
    output = tmp_path / "cameras.json"
    locate_photos(house, {"a.jpg": ["room"]}, masks, output)
    assert list(read_json(output)) == ["a.jpg", "b.jpg"]
    assert read_json(output)["b.jpg"]["located"] == 0.0
    found = read_poses(output)
    assert list(found) == ["a.jpg"]
    np.testing.assert_allclose(found["a.jpg"].camera.matrix, true.matrix, atol=1e-6)
    # Doors and windows of the mask count: it says more than one without them.
    plain = Shot(photo.camera, palette.without_openings(photo.labels), ("room",))
    assert found["a.jpg"].located > locate_shots(house, {"a.jpg": plain}).poses["a.jpg"].located


def test_the_room_of_a_photo_is_found_or_asked_for(tmp_path, caplog):
    house = box_house()
    photo, true = shot(house, 230.0, (0.6, 1.5, 2.9))
    known = photo.camera.to_json()
    cameras = {"a.jpg": known, "b.jpg": known | {"fallback": True}}
    labels = {"a": photo.labels, "b": np.full(SIZE, 2, np.uint8)}
    masks, output = write_masks(tmp_path / "masks", labels, cameras), tmp_path / "cameras.json"
    rooms, placed = tmp_path / "photo_rooms.json", tmp_path / "photos.csv"
    table = {"a.jpg": [], "b.jpg": [], "damaged.jpg": []}
    poses = locate_photos(house, table, masks, output).poses
    np.testing.assert_allclose(poses["a.jpg"].camera.matrix, true.matrix, atol=1e-6)
    assert write_photo_rooms(house, table, output, rooms, placed) == {"a.jpg": ["room"]}
    asked = "expected a room_id in the photo table where a photo's place in the plan is not clear"
    assert caplog.messages[-1] == f"house h: {asked}, found none for b.jpg; left out"
    given = {"b.jpg": ["store"], "a.jpg": []}
    both = {"b.jpg": ["store"], "a.jpg": ["room"]}
    assert write_photo_rooms(house, given, output, rooms, placed) == both
    assert read_json(rooms) == both
    many = {f"photo {number:03}.jpg": [] for number in range(99)}
    write_photo_rooms(house, many, None, rooms, placed)
    assert all(name in caplog.messages[-1] for name in many)
    write_photo_rooms(house, given, output, rooms, placed)
    sure = read_json(output)["a.jpg"]["rooms"]["room"]
    assert poses["a.jpg"].located < sure < 1.0
    header = "room_id,photo,probability,of_kind,guess"
    rows = [header, "store,b.jpg,,,", f"room,a.jpg,{sure:.2f},{sure:.2f},"]
    assert placed.read_text().splitlines() == rows
    # A guess is used for a room without a surer photo if it is of its kind, and is not told by
    # running with its table.
    entries = read_json(output)
    entries["a.jpg"]["rooms"] = {"room": 0.47, "store": 0.45, "": 0.08}
    write_json(output, entries)
    alone = {"b.jpg": ["store"]}
    assert write_photo_rooms(house, given, output, rooms, placed) == alone
    rows[2] = "room,a.jpg,0.47,0.47,room"
    assert placed.read_text().splitlines() == rows
    bedrooms = replace(house, rooms=tuple(replace(r, types=("Bedroom",)) for r in house.rooms))
    assert write_photo_rooms(bedrooms, given, output, rooms, placed) == both
    assert placed.read_text().splitlines()[2] == "room,a.jpg,0.47,0.92,room"
    entries["a.jpg"]["rooms"] = {"room": 0.45, "store": 0.47, "": 0.08}
    write_json(output, entries)
    assert write_photo_rooms(bedrooms, given, output, rooms, placed) == alone
    assert write_photo_rooms(house, given, output, rooms, placed) == alone
    rows[2] = "store,a.jpg,0.47,0.47,store"
    assert placed.read_text().splitlines() == rows
    assert read_assignment(placed, house) == (("store", "b.jpg"), ("", "a.jpg"))
    assert write_photo_rooms(house, {"b.jpg": []}, output, rooms, placed) == {}
    assert read_assignment(placed, house) == (PhotoAssignment("", "b.jpg"),)


def test_a_window_that_is_seen_through_an_open_door_counts():
    house, pose, labels, ends = open_door_view()
    far = WIDE + 2.1
    hole = Opening("far", "window", 0.4, 1.6, 1.0, 1.9)
    wall = Wall("far", ("store",), (far, 0.0), (far, 2.0), HEIGHT, openings=(hole,))
    seen = (np.abs(ends[..., 0] - far) < 1e-6) & (ends[..., 2] > 0.4) & (ends[..., 2] < 1.6)
    seen &= (ends[..., 1] > 1.0) & (ends[..., 1] < 1.9)
    assert seen.sum() > 50
    shown = np.where(seen, palette.WINDOW, labels).astype(np.uint8)
    with_window = replace(house, walls=(*house.walls, wall))

    def score(plan, mask):
        profile = make_profile(mask, pose.camera, log_table(openings=True), LOCATE.fine_blur, None)
        eyes = np.tile(np.array(pose.eye)[[0, 2]], (len(profile.azimuth), 1))
        sight = look(room_shapes(plan), "room", eyes, profile.azimuth)
        return float(agreement(profile, room_shapes(plan), "room", sight, pose.eye[1:2])[0, 0])

    assert score(with_window, shown) > score(house, shown)
    assert score(with_window, labels) < score(house, labels)
