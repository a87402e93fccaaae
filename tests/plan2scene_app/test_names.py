import json
import re
from dataclasses import replace

import pytest

from plan2scene.datasets.assignments import read_assignment
from plan2scene.errors import InputError
from plan2scene.house import Room
from plan2scene.plans.formats import read_plan
from plan2scene.plans.parse import Source
from plan2scene.plans.scene_json import house_of_scene
from plan2scene.plans.scene_writer import house_to_scene
from plan2scene_app.doubts.page import PlacedPhoto, doubt_lines
from plan2scene_app.drawing import room_labels
from plan2scene_app.exports.ifc4 import write_ifc
from plan2scene_app.exports.plan_sheet import write_plan
from plan2scene_app.ids import free_id
from plan2scene_app.plan_formats.drawing import Drawing, DrawnRoom, house_of_drawing
from plan2scene_app.plan_writer import house_to_plan

NAMES = ("חדר מגורים", "Kök & matplats", "居間", "Спальня", "living")


@pytest.fixture
def house():
    rooms = []
    for k, name in enumerate(NAMES):
        ring = ((4.0 * k, 0.0), (4.0 * k + 4, 0.0), (4.0 * k + 4, 3.0), (4.0 * k, 3.0))
        rooms.append(DrawnRoom(name, (ring,)))
    return house_of_drawing(Source("f", "home"), Drawing(rooms))


def test_ids_differ_and_names_stay(house, tmp_path):
    assert [r.id for r in house.rooms] == ["room", "kok_matplats", "room_2", "room_3", "living"]
    taken = set()
    made = [free_id(name, taken) for name in ("Спальня", "Кухня 2", "_", "Ванная A", "Køl 1", "a")]
    assert made == ["room", "room_2", "room_3", "a", "kol_1", "a_2"]
    scene = json.loads(json.dumps(house_to_scene(house)))
    (tmp_path / "plan.json").write_text(json.dumps(house_to_plan(house)), encoding="utf-8")
    again = (house_of_scene(scene, "home"), read_plan(tmp_path / "plan.json", "home"))
    for each in (house, *again):
        assert tuple(room.title for room in each.rooms) == NAMES
    table = tmp_path / "photos.csv"
    table.write_text("room_id,photo\nспальня,a.jpg\nKÖK &  matplats,b.jpg\nroom_2,c.jpg\n", "utf-8")
    rows = read_assignment(table, house)
    assert [row.room_id for row in rows] == ["room_3", "kok_matplats", "room_2"]
    two = replace(house, rooms=(*house.rooms, replace(house.rooms[3], id="other")))
    table.write_text("room_id,photo\nспальня,a.jpg\n", "utf-8")
    with pytest.raises(InputError, match=r"of one room \(room_3 or other\), .*of 2 rooms"):
        read_assignment(table, two)
    shown = room_labels(two)
    assert [shown[room] for room in ("living", "room_3", "other")] == [
        "living",
        "Спальня (room_3)",
        "Спальня (other)",
    ]
    assert read_assignment(table, two, traced=True) == (("", "a.jpg"),)


@pytest.mark.parametrize(
    ("own", "title"),
    [("living", "living"), ("utility_room", "utility room"), ("wc", "wc")]
    + [(own, "Bedroom") for own in ("bedroom_1", "room", "room_0_dfec", "a")],
)
def test_an_id_that_is_a_word_is_shown_where_a_room_has_no_name(own, title):
    assert Room(own, ("Bedroom",), (), 2.5).title == title


def test_names_are_shown(house, tmp_path):
    write_plan(house, {}, tmp_path)
    shown = set(re.findall(r">([^<>]+)<", (tmp_path / "plan.svg").read_text("utf-8")))
    assert {name.replace("&", "&amp;") for name in NAMES} <= shown
    write_ifc(house, {}, tmp_path)
    text = (tmp_path / "house.ifc").read_text()
    assert all(f"{ord(letter):04X}" in text for letter in "ח間С") and "k & matplats" in text
    lines = list(doubt_lines(house, [PlacedPhoto("a.jpg", "room_3", 0.5)], [], []))
    assert lines[0] == "Спальня? 50% sure: a.jpg"
    assert "no photo shows חדר מגורים, Kök & matplats" in lines[1]
