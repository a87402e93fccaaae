import json

import pytest
from places import PLAN
from plan_drawing import refusal

from plan2scene.datasets.import_plan import import_plan
from plan2scene.house import Door
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.validate import validate_house


def plan(**changes):
    """Two 4 x 3 m rooms, one above the other, with a door between and a window."""
    value = {
        "format": "plan2scene-plan",
        "version": 1,
        "rooms": [
            {"id": "a", "types": ["Bedroom"], "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]]},
            {"id": "b", "types": ["Kitchen"], "polygon": [[1, 3], [5, 3], [5, 6], [1, 6]]},
        ],
        "openings": [
            {"id": "d", "kind": "door", "from": [2, 3], "to": [3, 3], "bottom": 0, "top": 2},
            {"kind": "window", "from": [0.1, 1], "to": [0.1, 2], "bottom": 1, "top": 2},
        ],
    }
    value.update(changes)
    return value


def read(tmp_path, document):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(document))
    return read_plan(path, "h1")


def fault(tmp_path, document):
    (tmp_path / "plan.json").write_text(json.dumps(document))
    return refusal(tmp_path / "plan.json")


def test_walls_are_split_where_rooms_meet_and_openings_lie_on_them(tmp_path):
    house = read(tmp_path, plan())
    assert validate_house(house) == [] and len(house.walls) == 9
    shared = [wall for wall in house.walls if len(wall.room_ids) == 2]
    assert [(wall.room_ids, wall.length) for wall in shared] == [(("a", "b"), 3.0)]
    for room in house.rooms:
        bounds = sum(wall.length for wall in house.walls_of(room.id))
        assert bounds == pytest.approx(room_polygon(room).length)
    assert {wall.depth for wall in house.walls} == {0.1}
    assert {room.height for room in house.rooms} == {2.8}
    found = {o.id: (o.kind, w.room_ids) for w in house.walls for o in w.openings}
    assert found == {"d": ("door", ("a", "b")), "opening_1": ("window", ("a",))}
    assert house.doors == (Door("a", "d", "b"),)
    opening = next(o for w in house.walls for o in w.openings if o.id == "opening_1")
    assert sorted((opening.start, opening.end)) == pytest.approx([1.0, 2.0])


def test_doors_through_a_gap_and_to_the_outside(tmp_path):
    document = plan()
    document["rooms"][1]["polygon"] = [[1, 3.12], [5, 3.12], [5, 6], [1, 6]]
    house = read(tmp_path, document)
    assert [w.room_ids for w in house.walls for o in w.openings if o.id == "d"] == [("a",), ("b",)]
    assert house.doors == (Door("a", "d", "b"),)
    document = plan()
    document["openings"][0].update({"from": [4, 1], "to": [4, 2]})
    assert read(tmp_path, document).doors == (Door("a", "d", None),)


def test_house_of_one_room_with_a_shaft(tmp_path):
    room = {**plan()["rooms"][0], "holes": [[[1, 1], [2, 1], [2, 2]]]}
    house = read(tmp_path, plan(rooms=[room], openings=[]))
    assert room_polygon(house.rooms[0]).area == pytest.approx(11.5)
    assert len(house.walls) == 7 and house.adjacency() == ()


def test_openings_beside_and_beyond_walls_and_lacking_heights_are_told(tmp_path):
    document = plan()
    document["openings"][1].update({"from": [0.3, 1], "to": [0.3, 2]})
    expected = "a wall within 0.2 m of opening opening_1"
    assert fault(tmp_path, document) == f": expected {expected}, found the nearest at 0.30 m"
    document = plan()
    document["rooms"][0]["height"] = 2.5
    document["openings"][0].update({"from": [3.5, 3], "to": [4.2, 3]})
    height, cut = (house := read(tmp_path, document)).warnings
    assert height.endswith("a height of every room, or of none, found none of b; 2.8 m used")
    assert cut.endswith("of 3.000 m, found -0.200 to 0.500 m, cut")
    opening = next(o for wall in house.walls for o in wall.openings if o.id == "d")
    assert (opening.start, opening.end) == pytest.approx((0.0, 0.5))


@pytest.mark.parametrize(
    ("place", "change", "line"),
    [
        ("", {"scale": 2}, ": expected only the keys format, version, name, wall_depth, heights, "),
        ("", {"rooms": None}, ": expected a list at rooms, found nothing"),
        ("rooms", {"types": ["Ballroom"]}, ", room a: expected a room type (Reception, Bedroom"),
        ("rooms", {"colour": "red"}, ", room a: expected only the keys id, name, types, polygon, "),
        ("rooms", {"polygon": [[0, 0], [1, 0], [1e9, 1]]}, ", room a: expected a coordinate withi"),
        ("rooms", {"height": -1}, ", room a: expected more than 0 at rooms[0].height, found -1"),
        ("rooms", {"id": "a/b"}, ", room a/b: expected only letters"),
        ("openings", {"from": [2, 8], "to": [2, 8]}, ": expected a wall within 0.2 m of opening d"),
    ],
)
def test_faults(tmp_path, place, change, line):
    document = plan()
    (document[place][0] if place else document).update(change)
    assert fault(tmp_path, document).startswith(line)


def test_example(tmp_path):
    house = import_plan(PLAN, tmp_path / "scene.json", house_id="example")
    assert house.warnings == () and validate_house(house) == [] and len(house.rooms) == 5
    assert sum(len(wall.openings) for wall in house.walls) == 8
    beside = [" ".join(pair) for pair in house.adjacency()]
    assert beside == ["balcony living", "bathroom hall", "bedroom hall", "hall living"]
    assert read_scene_json(tmp_path / "scene.json", "example") == house
