import json

import numpy as np
import pytest
from plan_drawing import FLATS, LISTS, assert_found, drawn_flat, refusal

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan

UNIT = 1.7  # metres of a plan coordinate


def coordinates(points):
    return [[x / UNIT, -z / UNIT] for x, z in points]


def holes_of(plan, area):
    found = {key: [] for key in LISTS.values()}
    for key, hole in plan.holes_of(area):
        found[key] += coordinates(end.tolist() for end in hole.ends)
    return found


def redraw(plan):
    found = {}
    for k, (_, types, area) in enumerate(plan.rooms):
        room = {"vertices": coordinates(list(area.exterior.coords)[:-1])}
        room["pins"] = [{"label": " / ".join(types)}]
        found[f"room_{k}"] = room | holes_of(plan, area)
    return found


def merger(plan):
    """Each room in the frame of its own panorama: turned, and the camera 1 high."""
    found = {}
    for k, (_, types, area) in enumerate(plan.rooms):
        angle, scale, move = 30.0 * k, 0.8, np.array([k, 2.0])
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))

        back = np.array([[c, -s], [s, c]]) / scale

        def local(points, back=back, move=move):
            return [((np.array(p) - move) @ back).tolist() for p in points]

        layout = {"vertices": local(coordinates(list(area.exterior.coords)[:-1]))}
        for key, points in holes_of(plan, area).items():
            triples = []
            for i in range(0, len(points), 2):
                triples += [*local(points[i : i + 2]), [-1.0, 0.5]]
            layout[key] = triples
        place = {"rotation": angle, "scale": scale, "translation": [*move]}
        pano = dict(label=" / ".join(types), layout_raw=layout, floor_plan_transformation=place)
        pano |= {"is_primary": True, "ceiling_height": plan.height / UNIT / scale}
        found[f"complete_{k}"] = {"partial_0": {"pano_0": pano}}
    return found


def written(tmp_path, scale=UNIT, **parts):
    path = tmp_path / "zind_data.json"
    document = {name: {"floor_01": part} for name, part in parts.items()}
    document["scale_meters_per_coordinate"] = {"floor_01": scale}
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize("number", range(len(FLATS)))
@pytest.mark.parametrize("part", [redraw, merger])
def test_round_trip(tmp_path, number, part):
    plan = drawn_flat(number)
    found = read_plan(written(tmp_path, **{part.__name__: part(plan)}), "h1")
    assert_found(plan, found, heights=False)
    if part is merger:
        assert {round(room.height, 3) for room in found.rooms} == {round(plan.height, 3)}


def test_the_scale_may_be_given(tmp_path):
    plan = drawn_flat(2)
    path = written(tmp_path, scale=None, redraw=redraw(plan))
    with pytest.raises(InputError, match="scale_meters_per_coordinate of floor_01, or metres_per"):
        read_plan(path, "h1")
    assert_found(plan, read_plan(path, "h1", UNIT), heights=False)


def test_the_storey_with_most_floor_is_read(tmp_path):
    """Each floor lies in coordinates of its own: nothing tells how one is above the other."""
    large, small = drawn_flat(2), drawn_flat(0)
    path = tmp_path / "zind_data.json"
    floors = {"floor_01": redraw(small), "floor_02": redraw(large)}
    scales = dict.fromkeys(floors, UNIT)
    path.write_text(json.dumps({"redraw": floors, "scale_meters_per_coordinate": scales}))
    found = read_plan(path, "h1")
    assert_found(large, found, heights=False)
    assert found.levels == ()
    assert any("2; floor_02 read, left out floor_01" in line for line in found.warnings)


@pytest.mark.parametrize(
    ("room", "line"),
    [
        ({"vertices": [[0, 0], [1, 0]]}, "an outline of at least 3 points"),
        ({"vertices": [[0, 0], [1, 0], [1]]}, "points of 2 numbers, found 1"),
        ({"vertices": [[0, 0], [1, 0], [1, "a"]]}, "a number for a coordinate"),
        (7, "an object for a room"),
    ],
)
def test_bad_layouts_are_one_line(tmp_path, room, line):
    assert line in refusal(written(tmp_path, redraw={"room_0": room}))
