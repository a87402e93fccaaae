import json
from itertools import pairwise

import numpy as np
import pytest
from plan_drawing import FLATS, LISTS, assert_found, assert_storeys, drawn_flat, refusal

from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon

LABELS = {"Reception": "livingRoom", "Corridor": "hallway"}


def surface(kind, start, end, bottom, top, story=0):
    """Return an upright rectangle as RoomPlan has it: 16 numbers, column by column."""
    start, end = np.array(start), np.array(end)
    width = float(np.linalg.norm(end - start))
    along = (end - start) / width
    middle = (start + end) / 2
    x, z = along
    matrix = [x, 0, z, 0, 0, 1, 0, 0, -z, 0, x, 0, middle[0], (bottom + top) / 2, middle[1], 1]
    found = {"identifier": f"{kind}{start}", "category": {kind: {}}, "story": story}
    found["transform"] = [float(v) for v in matrix]
    return found | {"dimensions": [width, top - bottom, 0]}


def room(types, area, plan, story=0, base=-1.2, floors=True):
    points = list(area.exterior.coords)
    walls = [surface("wall", a, b, base, base + plan.height, story) for a, b in pairwise(points)]
    floor = {"category": {"floor": {}}, "dimensions": [1, 1, 0], "story": story}
    floor["transform"] = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, base, 0, 1]
    floor["polygonCorners"] = [[x, z, 0] for x, z in points[:-1]]
    centre = area.representative_point()
    place = {"center": [centre.x, 0, centre.y]}
    found = {"walls": walls, "floors": [floor] if floors else [], "story": story}
    found["sections"] = [{"label": LABELS.get(t, t.lower())} | place for t in types]
    found |= {key: [] for key in LISTS.values()}
    for key, hole in plan.holes_of(area):
        item = surface(hole.kind, *hole.ends, base + hole.bottom, base + hole.top, story)
        found[key].append(item)
    return found


def rooms_of(plan, **more):
    return [room(types, area, plan, **more) for _, types, area in plan.rooms]


def written(tmp_path, document):
    path = tmp_path / "scan.json"
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize("number", range(len(FLATS)))
def test_round_trip(tmp_path, number):
    plan = drawn_flat(number)
    found = read_plan(written(tmp_path, {"rooms": rooms_of(plan)}), "h1")
    assert_found(plan, found)
    assert {round(room.height, 4) for room in found.rooms} == {plan.height}


@pytest.mark.parametrize("floors", [True, False])
def test_one_room_alone(tmp_path, floors):
    plan = drawn_flat(2)
    _, types, area = plan.rooms[0]
    document = room(types, area, plan, floors=floors)
    sofa = surface("sofa", (1, 1), (3, 1), 0, 0.8)
    sofa["dimensions"][2] = 1.0
    found = read_plan(written(tmp_path, {**document, "objects": [sofa]}), "h1")
    assert room_polygon(found.rooms[0]).area == pytest.approx(area.area, rel=0.005)
    (icon,) = found.icons
    assert icon.type == "sofa" and (*icon.p1, *icon.p2) == pytest.approx((1, 0.5, 3, 1.5))


def test_one_floor_for_several_rooms_is_divided_by_the_walls(tmp_path):
    plan = drawn_flat(2)
    parts = rooms_of(plan)
    whole = {**parts[0], "floors": [parts[0]["floors"][0]]}
    for key in ("walls", "doors", "windows", "openings", "sections"):
        whole[key] = [item for part in parts for item in part[key]]
    found = read_plan(written(tmp_path, whole), "h1")
    assert_found(plan, found)
    assert any("1 for 4, closed from walls" in line for line in found.warnings)


def test_two_storeys_come_back(tmp_path):
    large, small = drawn_flat(2), drawn_flat(0)
    rooms = [*rooms_of(small, base=-1.2), *rooms_of(large, story=1, base=2.0)]
    found = read_plan(written(tmp_path, {"rooms": rooms}), "h1")
    assert_storeys((small, large), found, [("storey_0", 0.0), ("storey_1", 3.2)])


def test_stairs_join_the_storeys(tmp_path):
    plan = drawn_flat(2)
    _, _, area = max(plan.rooms, key=lambda room: room[2].area)
    x, z = area.representative_point().coords[0]
    rooms = [*rooms_of(plan, base=0.0), *rooms_of(plan, story=1, base=2.8)]
    matrix = [0.0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, x, 1.4, z, 1]  # its width along z
    stairs = {"category": {"stairs": {}}, "dimensions": [1.2, 2.8, 0.8], "transform": matrix}
    rooms[0]["objects"] = [stairs]
    found = read_plan(written(tmp_path, {"rooms": rooms}), "h1")
    (flight,) = found.stairs
    assert flight.length == pytest.approx(1.2) and flight.width == pytest.approx(0.8)
    assert found.icons == () and None not in flight.room_ids
    assert [found.level_of(room).id for room in flight.room_ids] == ["storey_0", "storey_1"]


WALL = surface("wall", (0, 0), (4, 0), 0, 2.5)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"transform": [0] * 15}, "16 numbers of transform and 3 of dimensions for a wall"),
        ({"transform": [0] * 15 + ["x"]}, "a number for transform of a wall, found 'x'"),
        ({"dimensions": [1e9, 1, 1]}, "dimensions of a wall within 1000 m"),
        ({}, "expected rooms, or walls that close some, found 1 walls that close none"),
    ],
)
def test_bad_scans_are_one_line(tmp_path, change, line):
    assert line in refusal(written(tmp_path, {"walls": [{**WALL, **change}]}))
