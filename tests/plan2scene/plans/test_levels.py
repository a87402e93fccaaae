import json

import pytest
from places import STOREYS

from plan2scene.house import USUAL, Level
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.plans.validate import house_faults, validate_house
from plan2scene_app.heights.ceilings import with_ceilings
from plan2scene_app.plan_writer import house_to_plan


@pytest.fixture
def plan():
    return json.loads(STOREYS.read_text())


def entry(plan, kind, name):
    return next(e for e in plan[kind] if e["id"] == name)


def test_the_example_is_a_sound_house():
    house = read_plan(STOREYS, "two")
    assert list(house_faults(house)) == [] and validate_house(house) == []
    assert house.levels == (
        Level("ground", "Ground floor", 0.0, 2.5),
        Level("upper", "Upper floor", 2.8, 2.5),
    )
    assert {room.height for room in house.rooms} == {2.5}
    assert house.level_of("study").elevation == 2.8


def test_other_ceilings_leave_the_slabs_as_thick_as_they_were():
    house = with_ceilings(read_plan(STOREYS, "two"), 2.0)
    assert [(level.elevation, level.height) for level in house.levels] == [(0.0, 2.0), (2.3, 2.0)]
    assert {room.height for room in house.rooms} | {wall.height for wall in house.walls} == {2.0}
    assert max(hole.top for wall in house.walls for hole in wall.openings) == 2.0
    full = [wall.full(hole) for wall in house.walls for hole in wall.openings]
    assert any(full)
    higher = with_ceilings(house, 3.0)  # what reached the ceiling still does
    assert full == [wall.full(hole) for wall in higher.walls for hole in wall.openings]
    assert list(house_faults(house)) == []


def test_a_plan_without_heights_is_marked_until_some_are_told(plan, tmp_path):
    assert house_of_plan(plan, "two").heights == ""
    for item in (*plan["rooms"], *plan["levels"]):
        item.pop("height", None)
    house = house_of_plan(plan, "two")
    assert house.heights == USUAL and {room.height for room in house.rooms} == {2.8}
    # The mark goes through scene.json and the editor's document, which names every height.
    write_scene_json(house, tmp_path / "scene.json")
    again = read_scene_json(tmp_path / "scene.json", "two")
    assert again.heights == USUAL
    assert house_of_plan(house_to_plan(again), "two").heights == USUAL
    plan["levels"][0]["height"] = 2.6
    assert house_of_plan(plan, "two").heights == ""


def test_rooms_of_two_levels_share_neither_walls_nor_doors():
    house = read_plan(STOREYS, "two")
    levels = {room.id: room.level for room in house.rooms}
    assert all(len({levels[r] for r in wall.room_ids}) == 1 for wall in house.walls)
    across = [pair for pair in house.adjacency() if levels[pair[0]] != levels[pair[1]]]
    assert across == [("hall", "landing")]  # by the stairs alone


def test_plan_and_scene_come_back(plan, tmp_path):
    house = house_of_plan(plan, "two")
    assert house_of_plan(house_to_plan(house), "two") == house
    write_scene_json(house, tmp_path / "scene.json")
    scene = read_scene_json(tmp_path / "scene.json", "two")
    assert (scene.rooms, scene.levels, scene.stairs) == (house.rooms, house.levels, house.stairs)
    assert scene.walls == house.walls and scene.adjacency() == house.adjacency()
    assert scene.warnings == ()


def test_levels_come_in_any_order_and_give_heights(plan):
    plan["levels"].reverse()
    plan["levels"][1]["height"] = 2.4
    house = house_of_plan(plan, "two")
    assert [level.id for level in house.levels] == ["ground", "upper"]
    assert house.room("living").height == 2.4


def test_stairs_that_lead_nowhere_are_listed(plan):
    extra = {"id": "to_roof", "from": [0.5, 5.8], "to": [2.3, 5.8], "width": 0.3, "level": "upper"}
    plan["stairs"].append(extra)
    lines = validate_house(house_of_plan(plan, "two"))
    assert lines[0] == (
        "house two, room landing: expected a level above stairs to_roof, "
        "found none; they end at the ceiling"
    )
    assert "steps of stairs to_roof at least 0.15 m deep" in lines[1]
    entry(plan, "rooms", "landing")["polygon"][0] = [0, 1.5]
    entry(plan, "rooms", "landing")["polygon"][1] = [2.4, 1.5]
    plan["stairs"].pop()
    entry(plan, "stairs", "stairs").update({"to": [0.45, -0.4]})
    plan["openings"] = [e for e in plan["openings"] if e["id"] != "landing_north"]
    house = house_of_plan(plan, "two")
    assert house.stairs[0].room_ids == ("hall", None)
    assert "expected a room of level upper at the head of stairs stairs" in validate_house(house)[0]


def test_a_door_that_leads_into_the_air_is_listed(plan):
    entry(plan, "openings", "bedroom_east").update({"kind": "door", "bottom": 0})
    assert validate_house(house_of_plan(plan, "two")) == [
        "house two, room bedroom: expected a room or balcony behind door bedroom_east of level "
        "upper, found none"
    ]
    balcony = {"id": "balcony", "types": ["Balcony"], "level": "upper"}
    plan["rooms"].append({**balcony, "polygon": [[8, 0.5], [9, 0.5], [9, 3], [8, 3]]})
    assert validate_house(house_of_plan(plan, "two")) == []


def test_floors_a_storey_apart_in_a_scene_without_levels_are_two(plan, tmp_path):
    write_scene_json(house_of_plan(plan, "two"), tmp_path / "scene.json")
    document = json.loads((tmp_path / "scene.json").read_text())
    arch = document["scene"]["arch"]
    del arch["levels"], arch["stairs"]
    for room in arch["rooms"]:
        del room["level"]
    (tmp_path / "scene.json").write_text(json.dumps(document))
    again = read_scene_json(tmp_path / "scene.json", "two")
    assert [level.elevation for level in again.levels] == [0.0, 2.8]
    upper = {room.id for room in again.storeys()[1][1].rooms}
    assert upper == {"landing", "bedroom", "bathroom", "study"}
    assert again.warnings == ()
