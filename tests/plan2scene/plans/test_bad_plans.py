import json

import pytest

from plan2scene.datasets.import_plan import import_plan
from plan2scene.errors import InputError
from plan2scene.house import Door, House, Opening, Room, Wall
from plan2scene.plans.validate import house_faults, validate_house

SQUARE = [[0, 0, 0], [4, 0, 0], [4, 0, 3], [0, 0, 3]]
CROSSED = [[0, 0, 0], [4, 0, 3], [4, 0, 0], [0, 0, 3]]


def scene(points=SQUARE, types=("Bedroom",), hole=None, **changes):
    wall = {"id": "w", "type": "Wall", "roomId": "a", "points": SQUARE[:2], "height": 2.5}
    if hole:
        wall["holes"] = [{"id": "o", "type": "Window", "box": hole}]
    floor = {"id": "f", "type": "Floor", "roomId": "a", "points": [points]}
    arch = {
        "elements": [floor, {**floor, "id": "c", "type": "Ceiling", "offset": [0, 2.5, 0]}, wall],
        "rooms": [{"id": "a", "types": list(types)}],
        "rdr": [],
    }
    arch.update(changes)
    return json.dumps({"arch": arch})


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (scene(types=["Ballroom"]), ", room a: expected a room type (Reception, "),
        (scene(CROSSED), ", room a: expected an outline that doesn't cross itself"),
        (scene(hole={"min": [5, 1], "max": [6, 2]}), ", room a: expected hole o on wall w, along "),
        (scene([[0, 0, 0], [40000, 0, 0], [0, 0, 3]]), ", room a: expected a coordinate of an "),
        (scene(rdr=[["a", "o", "cellar"]]), ": expected rooms of this plan at door o"),
        (scene(rooms=[{"id": "a", "types": ["Bedroom"]}] * 2), ", room a: expected room ids that "),
        (scene().replace("2.5", "NaN"), ": expected finite numbers, found NaN"),
        (scene().replace("2.5", "1e999"), ", room a: expected a finite number for a coordinate"),
        ("[" * 100_000, ": expected JSON, found nesting too deep"),
        ("{", ": expected JSON, found a syntax error"),
        ("{}", ": expected a list of elements, as in scene.json, found none"),
        ('{"scene": {"unit": 0.001, "arch": {}}}', ": expected unit 1 (metres), found 0.001"),
    ],
)
def test_line_of_a_fault(tmp_path, text, line):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        import_plan(path, tmp_path / "scene.json", house_id="h1")
    message = str(caught.value)
    assert "\n" not in message and message.startswith(f"file {path}, house h1{line}")
    assert not (tmp_path / "scene.json").exists()


def house(**changes):
    room = Room("a", ("Bedroom",), (((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)),), 2.5)
    wall = Wall("w", ("a",), (0.0, 0.0), (4.0, 0.0), 2.5)
    return House(**{"id": "h1", "rooms": (room,), "walls": (wall,), **changes})


def opening(**changes):
    values = {"id": "o", "kind": "door", "start": 1.0, "end": 2.0, "bottom": 0.0, "top": 2.0}
    return Opening(**{**values, **changes})


def wall_with(**changes):
    return Wall("w", ("a",), (0.0, 0.0), (4.0, 0.0), 2.5, openings=(opening(**changes),))


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"id": "../h"}, "expected a house name of letters"),
        ({"rooms": house().rooms * 2}, "expected each room id once, found a 2 times"),
        ({"rooms": ()}, "expected 1 to 1000 rooms, found 0"),
        ({"walls": (wall_with(end=5.0),)}, "found 1.000 to 5.000 m"),
        ({"walls": (wall_with(top=3.0),)}, "up within 0 to 2.500 m, found 0.000 to 3.000 m"),
        ({"walls": (wall_with(top=0.0),)}, "with its top above its bottom, found 0 to 0 m"),
        ({"walls": (wall_with(kind="gate"),)}, "found 'o', 'gate'"),
        ({"walls": (wall_with(start=float("nan")),)}, "with a width, found nan to 2 m"),
        ({"walls": house().walls * 2}, "expected each wall id once, found w 2 times"),
        (
            {"walls": (Wall("w", ("b",), (0.0, 0.0), (1.0, 0.0), 2.5),)},
            "expected one or two rooms of this plan at wall w, found b",
        ),
        ({"doors": (Door("a", "o", "b"),)}, "expected rooms of this plan at door o, found b"),
    ],
)
def test_validate_house(changes, line):
    assert validate_house(house()) == []
    with pytest.raises(InputError) as caught:
        validate_house(house(**changes), file="plan.json")
    assert str(caught.value).startswith("file plan.json, house ")
    assert line in str(caught.value)


def test_every_fault_is_listed():
    bad = house(walls=(wall_with(end=5.0, top=3.0),), doors=(Door("a", "o", "b"),))
    assert len(list(house_faults(bad))) == 3


def test_overlap_and_stray_walls_are_warnings():
    ring = ((3.0, 0.0), (7.0, 0.0), (7.0, 3.0), (3.0, 3.0))
    rooms = (*house().rooms, Room("b", ("Closet",), (ring,), 2.5))
    far = Wall("v", ("b",), (3.0, 9.0), (7.0, 9.0), 2.5)
    assert validate_house(house(rooms=rooms, walls=(*house().walls, far)), file="p") == [
        "file p, house h1, room a: expected rooms that don't overlap, "
        "found 3.00 m2 shared with room b",
        "file p, house h1, room b: expected wall v on the room's outline, found 6.00 m from it",
    ]
