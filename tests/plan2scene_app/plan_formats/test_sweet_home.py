import zipfile
from itertools import pairwise
from math import atan2, pi
from xml.sax.saxutils import quoteattr

import pytest
from plan_drawing import FLATS, assert_found, assert_storeys, drawn_flat, refusal

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.validate import validate_house
from plan2scene_app.plan_formats import containers


def element(tag, children=(), **attributes):
    text = " ".join(f"{key}={quoteattr(str(value))}" for key, value in attributes.items())
    return f"<{tag} {text}>{''.join(children)}</{tag}>"


def home_xml(plan, *, rooms=True, level=None):
    on = {} if level is None else {"level": level}
    parts = []
    for hole in plan.holes:
        model = {"door": "door", "window": "window85x123", "passage": "doorFrame"}[hole.kind]
        (x, y), height = hole.centre, hole.top - hole.bottom
        place = dict(x=x, y=y, width=hole.width, depth=plan.thickness, height=height)
        place = {key: 100 * value for key, value in (place | {"elevation": hole.bottom}).items()}
        place["angle"] = atan2(hole.along[1], hole.along[0])
        sash = ["<sash xAxis='0' yAxis='0' width='1' startAngle='0' endAngle='1'/>"]
        inside = sash if hole.kind == "door" else []
        place |= {"catalogId": f"eTeks#{model}", "name": model}
        parts.append(element("doorOrWindow", inside, **place, **on))
    for number, (a, b) in enumerate(plan.axes):
        sizes = {"thickness": plan.thickness * 100, "height": plan.height * 100}
        parts.append(wall(*(v * 100 for v in (*a, *b)), id=f"wall{number}", **sizes, **on))
    for _, types, polygon in plan.rooms if rooms else ():
        points = [element("point", x=x * 100, y=z * 100) for x, z in polygon.exterior.coords]
        parts.append(element("room", points, name=" / ".join(types), **on))
    return "".join(parts)


def write(path, content, entry="Home.xml"):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(entry, content)
    return path


def home(tmp_path, *parts):
    text = element("home", parts, version="6400", name="x.sh3d", wallHeight="250.0")
    return write(tmp_path / "plan.sh3d", f"<?xml version='1.0'?>\n{text}")


def wall(x0, y0, x1, y1, **more):
    return element("wall", xStart=x0, yStart=y0, xEnd=x1, yEnd=y1, **{"thickness": 20, **more})


ENDS = [(0, 0, 400, 0), (400, 0, 400, 300), (400, 300, 0, 300), (0, 300, 0, 0)]
SQUARE = [wall(*ends) for ends in ENDS]


@pytest.mark.parametrize("number", range(len(FLATS)))
@pytest.mark.parametrize("rooms", [True, False])
def test_round_trip(tmp_path, number, rooms):
    plan = drawn_flat(number)
    found = read_plan(home(tmp_path, home_xml(plan, rooms=rooms)), "h1")
    assert_found(plan, found, types=rooms)
    assert len(validate_house(found)) == (0 if rooms else len(plan.rooms))
    assert {round(wall.depth, 4) for wall in found.walls} == {plan.thickness}


def test_walls_close_a_room_between_their_faces_though_an_end_is_loose_or_one_is_curved(tmp_path):
    house = read_plan(home(tmp_path, *SQUARE), "h1")
    (room,) = house.rooms
    assert room_polygon(room).bounds == pytest.approx((0.1, 0.1, 3.9, 2.9))
    assert room.height == 2.5 and {w.depth for w in house.walls} == {0.2}
    house = read_plan(home(tmp_path, *SQUARE, wall(200, 10, 200, 290, thickness=10)), "h1")
    assert [round(room_polygon(r).area, 3) for r in house.rooms] == [5.18, 5.18]
    curved = wall(400, 300, 0, 300, arcExtent=pi)
    house = read_plan(home(tmp_path, *SQUARE[:2], curved, SQUARE[3]), "h1")
    assert room_polygon(house.rooms[0]).area == pytest.approx(3.8 * 2.9 + pi * 1.9**2 / 2, rel=0.02)


def test_a_gap_in_line_is_a_passage_and_a_doubt(tmp_path):
    outside = [wall(400, 0, 150, 0), wall(50, 0, 0, 0), *SQUARE[1:]]
    inside = [wall(200, 0, 200, 100), wall(200, 200, 200, 300), wall(600, 0, 600, 1900)]
    house = read_plan(home(tmp_path, *outside, *inside), "h1")
    assert [round(room_polygon(r).area, 2) for r in house.rooms] == [5.04, 5.04]
    widths = [o.end - o.start for w in house.walls for o in w.openings]
    assert widths == pytest.approx(3 * [1.0])  # the inner one in a wall of either room
    assert "2 of 1.00 to 1.00 m, read as passages" in house.warnings[0]
    assert "2 rooms; 1 of 10 walls border none" in " ".join(house.warnings)


def test_rooms_of_an_impossible_size_are_refused(tmp_path):
    square = [(0, 0), (50_000, 0), (50_000, 15_000), (0, 15_000), (0, 0)]
    walls = [wall(*a, *b) for a, b in pairwise(square)]
    with pytest.raises(InputError, match="at most 50,000 m2 of a storey"):
        read_plan(home(tmp_path, *walls), "h1")


LEVELS = [("l0", "Ground", 0), ("l1", "Upper", 260)]


def test_two_levels_come_back(tmp_path):
    levels = [element("level", id=i, name=n, elevation=e, height=240) for i, n, e in LEVELS]
    plans = (drawn_flat(0), drawn_flat(2))
    parts = [home_xml(plan, level=level) for plan, (level, *_) in zip(plans, LEVELS, strict=True)]
    found = read_plan(home(tmp_path, *levels, *parts), "h1")
    assert_storeys(plans, found, [("ground", 0.0), ("upper", 2.6)])


def test_a_staircase_joins_two_levels_and_a_layer_is_no_level(tmp_path):
    layers = [*LEVELS, ("l2", "Wiring", 260), ("l3", "Roof", 520)]
    levels = [element("level", id=i, name=n, elevation=e, height=240) for i, n, e in layers]
    squares = [wall(*ends, level=level) for level in ("l0", "l1") for ends in ENDS]
    wiring = wall(100, 100, 200, 100, level="l2")
    place = {"x": 150, "y": 40, "width": 240, "depth": 60, "height": 250, "angle": 0}
    piece = element("pieceOfFurniture", name="Staircase", level="l0", **place)
    found = read_plan(home(tmp_path, *levels, *squares, wiring, piece), "h1")
    assert [level.id for level in found.levels] == ["ground", "upper"]
    (flight,) = found.stairs
    assert (flight.length, flight.width) == pytest.approx((2.4, 0.6))
    assert flight.room_ids == ("room", "room_2")
    assert found.adjacency() == (("room", "room_2"),)


def test_rooms_and_walls_of_two_layers_are_one_floor(tmp_path):
    levels = [element("level", id=i, name=n, elevation=0, height=250) for i, n, _ in LEVELS]
    points = [element("point", x=a, y=b) for a, b in [(20, 20), (380, 20), (380, 280), (20, 280)]]
    drawn = element("room", points, name="Kitchen", level="l0")
    point = element("room", points[:2], name="Nothing", level="l0")
    squares = [wall(*ends, level="l1") for ends in ENDS]
    door = {"x": 100, "y": 0, "width": 90, "depth": 20, "height": 210}
    piece = element("doorOrWindow", name="Door", level="l1", **door)
    found = read_plan(home(tmp_path, *levels, drawn, point, *squares, piece), "h1")
    assert (found.levels, [room.id for room in found.rooms]) == ((), ["kitchen"])
    assert [o.kind for w in found.walls for o in w.openings] == ["door"]
    assert sum("at least 3 points, found one of fewer" in line for line in found.warnings) == 1


def test_rooms_side_by_side_without_a_wall_are_open(tmp_path):
    def room(x, name):
        corners = [(x, 0), (x + 300, 0), (x + 300, 300), (x, 300)]
        return element("room", [element("point", x=a, y=b) for a, b in corners], name=name)

    wall_ = wall(0, 0, 600, 0)
    house = read_plan(home(tmp_path, room(0, "Küche"), room(300, "Wohnzimmer"), wall_), "h1")
    assert [r.types for r in house.rooms] == [("Kitchen",), ("Reception",)]
    assert [r.id for r in house.rooms] == ["kuche", "wohnzimmer"]
    assert house.adjacency() == (("kuche", "wohnzimmer"),)


def test_furniture_is_kept_as_boxes_and_the_hidden_is_not(tmp_path):
    sofa = {"name": "Sofa", "x": 200, "y": 100, "width": 200, "depth": 80, "height": 80}
    pieces = [
        element("pieceOfFurniture", **sofa, angle=pi / 2),
        element("pieceOfFurniture", **sofa, visible="false"),
        element("furnitureGroup", [element("light", **sofa)]),
    ]
    house = read_plan(home(tmp_path, *SQUARE, *pieces), "h1")
    assert [icon.type for icon in house.icons] == ["Sofa", "Sofa"]
    assert (*house.icons[0].p1, *house.icons[0].p2) == pytest.approx((1.6, 0.0, 2.4, 2.0))


@pytest.mark.parametrize(
    ("content", "line"),
    [
        ("<home", "expected XML, found a syntax error"),
        ("<house/>", "expected <home> in Home.xml, found <house>"),
        ("<home/>", "expected rooms, or walls that close some, found none"),
        (element("home", [wall(0, 0, "nan", 1)]), "a finite number for xEnd of wall, found nan"),
        (element("home", [wall(0, 0, "1e9", 1)]), "xEnd of wall within 1000 m"),
        (element("home", [wall(0, 0, "x", 1)]), "a number for xEnd of wall, found 'x'"),
        (element("home", [wall(0, 0, 5, 1)] * 6000), "at most 5000 walls, found more"),
        (
            "<!DOCTYPE h [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;'>]><home name='&b;'/>",
            "XML without entities or outside references",
        ),
        ("<home>" + "<a/>" * 20_000 + "</home>", "at most 10000 XML elements"),
    ],
)
def test_bad_homes_are_one_line(tmp_path, monkeypatch, content, line):
    monkeypatch.setattr(containers, "MAX_XML_ELEMENTS", 10_000)
    assert line in refusal(write(tmp_path / "plan.sh3d", content))


def test_a_zip_bomb_is_never_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(containers, "MAX_XML_BYTES", 1_000_000)
    path = write(tmp_path / "plan.sh3d", b" " * 5_000_000)
    assert path.stat().st_size < 10_000
    with pytest.raises(InputError, match=r"at most 1000000 bytes of Home\.xml, found more"):
        read_plan(path, "h1")


def test_an_old_file_says_what_to_do(tmp_path):
    path = write(tmp_path / "plan.sh3d", b"\xac\xed", "Home")
    with pytest.raises(InputError, match=r"5\.3 or later and save it\), found a Java object"):
        read_plan(path, "h1")
