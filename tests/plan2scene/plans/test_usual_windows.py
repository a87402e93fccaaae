import json
from dataclasses import replace

import pytest
from sample_houses import rooms_in_a_row, walls_of
from shapely.geometry import LineString

from plan2scene.datasets.import_plan import import_plan
from plan2scene.house import House, Opening
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.plans.geometry import walls_of_rooms
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.usual_windows import USUAL_WINDOWS, with_usual_windows


def windows(house):
    walls = [(wall, opening) for wall in house.walls for opening in wall.openings]
    return [(w.room_ids, w, o) for w, o in walls if o.kind == "window"]


def row(**types):
    rooms = rooms_in_a_row(**types)
    return House("row", rooms, tuple(walls_of_rooms(rooms)))


def test_lived_in_rooms_get_one_in_the_middle_of_an_outer_wall():
    house = with_usual_windows(row(bed="Bedroom", hall="Corridor", bath="Bathroom", yard="Outdoor"))
    found = {ids[0]: (wall, opening) for ids, wall, opening in windows(house)}
    assert found.keys() == {"bed", "bath"}
    wall, opening = found["bed"]
    assert (opening.start + opening.end) / 2 == pytest.approx(wall.length / 2)
    assert opening.end - opening.start <= USUAL_WINDOWS.width[1]
    assert found["bath"][1].bottom > opening.bottom  # nobody looks in
    assert len({opening.id for _, _, opening in windows(house)}) == 2


def test_a_large_room_has_two_in_walls_that_run_two_ways_beside_its_door():
    room = replace(rooms_in_a_row(living="Reception")[0], rings=(((0, 0), (6, 0), (6, 5), (0, 5)),))
    door = Opening("door", "door", 0.3, 1.3, 0.0, 2.0)
    house = with_usual_windows(House("one", (room,), walls_of(room, {0: [door], 2: [door]})))
    ways = [LineString([wall.start, wall.end]).bounds for _, wall, _ in windows(house)]
    assert sorted((x1 > x0, z1 > z0) for x0, z0, x1, z1 in ways) == [(False, True), (True, False)]
    for _, wall, window in windows(house):
        assert all(o.end < window.start for o in wall.openings if o.kind == "door")


@pytest.mark.parametrize("types", [{"hall": "Corridor"}, {"yard": "Outdoor"}])
def test_other_rooms_get_none(types):
    house = row(**types)
    assert with_usual_windows(house) == house


def test_walls_within_the_house_and_houses_with_windows_get_none():
    left, right = rooms_in_a_row(a="Bedroom", b="Bedroom")
    deep = replace(left, rings=(((0, 0), (3, 0), (3, 4), (0, 4)),))
    beside = replace(right, rings=(((4, 0), (7, 0), (7, 4), (4, 4)),))  # a void of a metre
    glazed = with_usual_windows(House("two", (deep, beside), (*walls_of(deep), *walls_of(beside))))
    assert {wall.id for _, wall, _ in windows(glazed)} == {"a_w3", "b_w1"}
    assert with_usual_windows(glazed) == glazed
    near = replace(right, rings=(((4.8, 0), (7.8, 0), (7.8, 4), (4.8, 4)),))  # a narrow yard
    yard = House("yard", (deep, near), (*walls_of(deep), *walls_of(near)))
    assert {wall.id for _, wall, _ in windows(with_usual_windows(yard))} == {"a_w3", "b_w1"}


def test_a_drawing_keeps_them_in_its_scene_and_photos_are_not_compared_with_them(tmp_path):
    room = {"id": "a", "types": ["Bedroom"], "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]]}
    plan = {"format": "plan2scene-plan", "version": 1, "rooms": [room]}
    source, scene = tmp_path / "plan.json", tmp_path / "scene.json"
    source.write_text(json.dumps(plan))
    import_plan(source, scene, house_id="h")
    house = read_scene_json(scene, "h")
    assert [opening.guessed for _, _, opening in windows(house)] == [True]
    assert room_shapes(house)["a"].holes == ()
    source.write_text(json.dumps(plan | {"rooms": [room | {"height": 2.5}]}))
    assert not windows(import_plan(source, scene, house_id="h"))  # its author told the third axis
