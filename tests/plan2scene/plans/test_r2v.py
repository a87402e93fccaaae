from pathlib import Path

import pytest

from plan2scene.errors import InputError
from plan2scene.house import Door, IconBox
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.validate import validate_house

SHARED = Path(__file__).parents[4] / "shared" / "samples" / "r2v"

#: Two rooms side by side (100 x 80 px and 60 x 80 px), a balcony below the second. Ends are
#: rough: 2 px off, one wall crosses another and sticks out.
ANNOTATION = """
10 10 110 11 wall 1 1
110 10 170 10 wall 1 1
10 12 10 90 wall 1 1
170 10 170 90 wall 1 1
10 90 111 90 wall 1 1
110 8 110 94 wall 1 1
112 90 170 90 wall 1 1
110 92 110 120 wall 1 1
110 120 170 120 wall 1 1
170 90 170 120 wall 1 1
110 40 110 60 door 1 1
30 10 50 10 door 1 1
10 30 10 60 door 1 1
130 91 150 91 door 1 1
12 33 20 55 entrance 1 1
40 40 70 50 bedroom 1 1
120 30 150 40 washing_room 1 1
130 100 150 108 balcony 1 1
150 60 165 80 bathtub 1 1
400 400 410 410 closet 1 1
"""
OUTPUT = """200 200
7
0 0 100 0 0 1
100 0 100 80 3 1
0 80 100 80 1 0
0 0 0 80 1 0
100 0 160 0 0 3
160 0 160 80 0 3
100 80 160 80 3 0
100 30 100 50 door 1 1
"""


def read(tmp_path, text, metres_per_pixel=0.05, tabs=True):
    path = tmp_path / "plan.txt"
    path.write_text(text.replace(" ", "\t") if tabs else text)
    return read_plan(path, "h1", metres_per_pixel)


def test_annotation(tmp_path):
    house = read(tmp_path, ANNOTATION)
    assert [room.types for room in house.rooms] == [("Bedroom",), ("Bathroom",), ("Balcony",)]
    areas = [room_polygon(room).area for room in house.rooms]
    assert areas == pytest.approx([20.0, 12.0, 4.5], rel=0.05)
    assert len(house.walls) == 10
    assert {o.id: (o.kind, o.bottom, o.top) for w in house.walls for o in w.openings} == {
        "hole_0": ("door", 0.0, 2.5),
        "hole_1": ("window", 1.0, 2.0),
        "hole_2": ("door", 0.0, 2.5),
        "hole_3": ("door", 0.0, 2.5),
    }
    assert set(house.doors) == {
        Door("room_0", "hole_0", "room_1"),
        Door("room_0", "hole_2", None),
        Door("room_1", "hole_3", "room_2"),
    }
    assert [wall.room_ids for wall in house.walls if wall.height == 1.4] == [("room_2",)] * 3
    assert house.icons == (IconBox("bathtub", (7.5, 3.0), (8.25, 4.0)),)
    assert any("closet outside" in line for line in house.warnings)
    assert all(room.height == 2.8 for room in house.rooms)


def test_output_labels_by_the_side_of_the_walls(tmp_path):
    house = read(tmp_path, OUTPUT)
    assert [room.types for room in house.rooms] == [("Reception",), ("Bedroom",)]
    assert [room_polygon(r).area for r in house.rooms] == pytest.approx([20.0, 12.0])
    assert house.doors == (Door("room_0", "hole_0", "room_1"),) and house.warnings == ()
    assert read(tmp_path, OUTPUT.replace("0 0 100 0 0 1", "100 0 0 0 1 0")) == house
    text = ANNOTATION + "60 60 80 66 kitchen 1 1\n80 60 100 66 dining_room 1 1\n"
    assert read(tmp_path, text).rooms[0].types == ("Bedroom", "Kitchen", "Reception")


def test_loose_wall_and_stray_door_are_warnings(tmp_path):
    house = read(tmp_path, (ANNOTATION + "30 50 60 50 wall 1 1\n300 300 320 300 door 1 1\n"))
    lines = "\n".join(house.warnings)
    assert "found 1.50 m of walls that don't, left out" in lines and "opening hole_4" in lines
    assert len(house.walls) == 10


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("1 1 2 2 wall\n1 1 2", "expected x1 y1 x2 y2 label in line 2, found 3 fields"),
        ("nan 1 2 2 wall 1 1", "expected pixel coordinates within 100000 in line 1, found 'nan'"),
        ("1 1 9 9 door 1 1", "expected walls, found none"),
        ("1 1 9 9 wall 1 1", "expected walls that close 1 to 1000 rooms, found 0 rooms"),
        ("256 256\n5\n0 0 1 1 0 1", "expected the number of walls (1 to 1) in line 2, found 5"),
        ("256 256\n1\n0 0 1 1 0 11", "expected a room index of 0 to 10 in line 3, found 11"),
        ("256 256\n1\n0 0 1 1 0", "expected x1 y1 x2 y2 a b in line 3, found 5 fields"),
    ],
)
def test_bad_text(tmp_path, text, line):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(f"file {tmp_path / 'plan.txt'}, house h1: {line}")


@pytest.mark.parametrize("scale", [None, 0.0, -1.0, 2.0, float("nan")])
def test_scale_must_be_given(tmp_path, scale):
    with pytest.raises(InputError, match="house h1: expected metres_per_pixel above 0"):
        read(tmp_path, OUTPUT, scale)


@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="no samples beside the repository")
def test_network_output_agrees_with_the_reference_converter():
    house = read_plan(SHARED / "sample_r2v_output.txt", "sample", 0.05)
    reference = read_scene_json(SHARED / "sample_input.scene.json", "sample")
    assert len(house.rooms) == len(reference.rooms) == 5
    assert len(house.walls) == len(reference.walls) == 20
    assert sum(2 if door.room_b else 1 for door in house.doors) == 11
    types = sorted(room.types for room in house.rooms)
    assert types == sorted(room.types for room in reference.rooms)
    for room in house.rooms:
        # The reference cuts pixels down to integers: up to 0.05 m at each side.
        twin = max(
            reference.rooms, key=lambda r: room_polygon(r).intersection(room_polygon(room)).area
        )
        assert twin.types == room.types
        assert room_polygon(room).symmetric_difference(room_polygon(twin)).area < 0.5
    kinds = sorted(o.kind for w in house.walls for o in w.openings)
    assert kinds == sorted(o.kind for w in reference.walls for o in w.openings)
    shared = [sorted(len(wall.room_ids) for wall in h.walls) for h in (house, reference)]
    assert shared[0] == shared[1] and len(house.icons) == 6
    validate_house(house)
