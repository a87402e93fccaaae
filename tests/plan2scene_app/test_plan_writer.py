from dataclasses import replace

import pytest
from places import ROOT
from sample_houses import with_openings

from plan2scene.house import IconBox
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.validate import house_faults
from plan2scene_app.plan_writer import house_to_plan

DEMO = sorted((ROOT / "resources" / "demo").glob("archs_no_objects/*/*.scene.json"))


def openings(house):
    return {
        o.id: (o.kind, round(o.end - o.start, 3), o.bottom, o.top)
        for wall in house.walls
        for o in wall.openings
    }


@pytest.mark.parametrize("name", ["l_house", "ring_house", "shared_house"])
def test_small_houses_come_back(name, request):
    icon = IconBox("toilet", (0.5, 0.1), (0.9, 0.8))
    house = replace(request.getfixturevalue(name), icons=(icon,))
    again = house_of_plan(house_to_plan(house), house.id)
    assert again.rooms == house.rooms and openings(again) == openings(house)
    assert again.doors == house.doors and again.icons == house.icons


def test_guessed_openings_stay_guesses(l_house):
    plan = house_to_plan(with_openings(l_house, lambda o: o.kind == "window", guessed=True))
    assert [opening["id"] for opening in plan["openings"]] == ["front"]


@pytest.mark.parametrize("own_ids", [False, True])
def test_a_door_in_both_walls_of_a_gap_is_one_between_them(gap_house, own_ids):
    walls = tuple(
        replace(w, openings=tuple(replace(o, id=w.id if own_ids else "d") for o in w.openings))
        for w in gap_house.walls
    )
    plan = house_to_plan(replace(gap_house, walls=walls))
    assert [(o["from"][0], o["to"][0]) for o in plan["openings"]] == [(3.05, 3.05)]
    again = house_of_plan(plan, "gap")
    assert again.adjacency() == (("a", "b"),)
    assert sum(len(wall.openings) for wall in again.walls) == 2


@pytest.mark.parametrize("path", DEMO[:3], ids=lambda path: path.name[:13])
def test_houses_of_the_demo_come_back(path):
    house = read_plan(path, "home")
    again = house_of_plan(house_to_plan(house), "home")
    assert list(house_faults(again)) == []
    for room in house.rooms:
        assert again.room(room.id).types == room.types
        area = room_polygon(room).area
        assert room_polygon(again.room(room.id)).area == pytest.approx(area, rel=1e-3)
    assert again.adjacency() == house.adjacency()
    assert openings(again).keys() == openings(house).keys()
