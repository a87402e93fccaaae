import time
from dataclasses import replace
from itertools import pairwise
from math import atan2, cos, degrees, radians, sin

import pytest
from plan_drawing import FLATS, assert_found, body, drawn_flat, refusal
from shapely import unary_union
from shapely.geometry import box

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.parse import Source
from plan2scene_app.plan_formats.dxf import LayerKinds, house_of_dxf
from plan2scene_app.plan_formats.dxf_content import alphabet

ezdxf = pytest.importorskip("ezdxf")


def document(units=4):
    doc = ezdxf.new("R2010")
    doc.header["$INSUNITS"] = units
    return doc


def points(coords, scale=1000, shift=(0, 0)):
    return [(x * scale + shift[0], -z * scale + shift[1]) for x, z in coords]


def add_holes(doc, plan, **more):
    """A door is a block of leaf and swing, hinged on the wall's axis; a window lines across it."""
    block = doc.blocks.new("Door_90")
    block.add_line((0, 0), (0, 1))
    block.add_arc((0, 0), 1, 0, 90)
    block.add_line((1, 0.1), (1, -0.2))  # a jamb
    double = doc.blocks.new("Door_180")
    for x, turn in ((0, 0), (1, 90)):
        double.add_line((x, 0), (x, 0.5))
        double.add_arc((x, 0), 0.5, turn, turn + 90)
    space = doc.modelspace()
    for hole in plan.holes:
        start, end = points(hole.ends, **more)
        if hole.kind == "window":
            for side in (0.5, -0.5):
                out = side * plan.thickness * 1000
                normal = (hole.along[1], hole.along[0])
                line = [(x + out * normal[0], y + out * normal[1]) for x, y in (start, end)]
                space.add_line(*line, dxfattribs={"layer": "A-GLAZ"})
            space.add_line(start, end, dxfattribs={"layer": "A-GLAZ"})
        else:
            turn = degrees(atan2(end[1] - start[1], end[0] - start[0]))
            size = hole.width * 1000
            place = {"rotation": turn, "xscale": size, "yscale": size}
            name = "Door_90" if hole.width < 1.5 else "Door_180"
            space.add_blockref(name, start, dxfattribs=place)


def add_rooms(doc, plan, **more):
    space = doc.modelspace()
    for _, types, area in plan.rooms:
        ring = points(list(area.exterior.coords)[:-1], **more)
        space.add_lwpolyline(ring, close=True, dxfattribs={"layer": "A-AREA-ROOM"})
        centre = points([area.representative_point().coords[0]], **more)[0]
        space.add_mtext(" / ".join(types), dxfattribs={"layer": "TEXT"}).set_location(centre)
        space.add_text("12.5", dxfattribs={"layer": "TEXT"}).set_placement(centre)


def add_walls(doc, plan, way, **more):
    space, layer = doc.modelspace(), {"layer": "WAND"}
    if way == "faces":
        solid = unary_union([body(ends, plan.thickness, "square") for ends in plan.axes])
        holes = [body(h.ends, plan.thickness * 1.02, "flat") for h in plan.holes]
        solid = solid.difference(unary_union(holes))
        for part in getattr(solid, "geoms", [solid]):
            for ring in (part.exterior, *part.interiors):
                for pair in pairwise(points(ring.simplify(1e-6).coords, **more)):
                    space.add_line(*pair, dxfattribs=layer)
        return
    for ends in plan.axes:
        if way == "bodies":
            ring = points(list(body(ends, plan.thickness, "square").exterior.coords)[:-1], **more)
            space.add_lwpolyline(ring, close=True, dxfattribs=layer)
        elif way == "axes":
            space.add_line(*points(ends, **more), dxfattribs=layer)
        elif way == "multilines":
            size = {"scale_factor": plan.thickness * 1000, "justification": 1}
            space.add_mline(points(ends, **more), dxfattribs=layer | size)


def saved(doc, tmp_path, fmt="asc"):
    doc.saveas(tmp_path / "plan.dxf", fmt=fmt)
    return tmp_path / "plan.dxf"


@pytest.mark.parametrize("way", ["bodies", "none"])
@pytest.mark.parametrize("number", range(len(FLATS)))
def test_round_trip_with_rooms(tmp_path, way, number):
    plan, doc = drawn_flat(number), document()
    add_rooms(doc, plan)
    add_walls(doc, plan, way)
    add_holes(doc, plan)
    found = read_plan(saved(doc, tmp_path), "h1")
    assert_found(without_passages(plan), found, heights=False)


def without_passages(plan):
    """A DXF door block has a leaf: passages come back as doors."""
    holes = [replace(h, kind="door" if h.kind == "passage" else h.kind) for h in plan.holes]
    return replace(plan, holes=holes)


# The openings of 1 and 4 that take a whole wall leave no faces that tell where it was.
@pytest.mark.parametrize("number", [0, 2, 3, 5])
@pytest.mark.parametrize("blocks", [True, False])
def test_round_trip_of_faces_as_cad_programs_draw_them(tmp_path, number, blocks):
    """Doors are mirrored blocks or loose lines, names in tags, old walls on hidden layers."""
    plan, doc = drawn_flat(number), document()
    space, tag = doc.modelspace(), doc.blocks.new("tag")
    tag.add_lwpolyline([(-300, -200), (300, -200), (300, 200), (-300, 200)], close=True)
    add_walls(doc, plan, "faces" if blocks else "multilines")
    add_holes(doc, plan)
    getattr(doc.layers.add("WAND-OLD"), "off" if blocks else "freeze")()
    for _, types, area in plan.rooms:
        place = points(area.representative_point().coords)[0]
        insert = space.add_blockref("tag", place, dxfattribs={"layer": "A-AREA-IDEN"})
        insert.add_attrib("NAME", " / ".join(types), place)
        x0, z0, x1, _ = area.bounds
        old = points(body([(x0, z0 + 0.8), (x1, z0 + 0.8)], 0.2, "square").exterior.coords)
        space.add_lwpolyline(old, dxfattribs={"layer": "WAND-OLD"})
    for door in space.query("INSERT[name ? 'Door']"):
        for part in () if blocks else door.explode():
            part.dxf.layer = "A-DOOR"
    for insert in space.query("INSERT") if blocks else ():
        for entity in (insert, *insert.attribs):
            x, y, _ = entity.dxf.insert
            entity.dxf.extrusion, entity.dxf.insert = (0, 0, -1), (-x, y)
        insert.dxf.xscale, insert.dxf.rotation = -insert.dxf.xscale, -insert.dxf.rotation
    assert_found(without_passages(plan), read_plan(saved(doc, tmp_path), "h1"), heights=False)


def nested(doc, plan):
    """Walls are hatches, in a block in a turned block."""
    doc.blocks.new("plan")
    for line in list(doc.modelspace().query("LWPOLYLINE")):
        hatch = doc.blocks.get("plan").add_hatch(dxfattribs={"layer": "WAND"})
        hatch.paths.add_polyline_path([p[:2] for p in line.get_points()], is_closed=True)
        doc.modelspace().delete_entity(line)
    doc.blocks.new("sheet").add_blockref("plan", (5000, 0), dxfattribs={"rotation": 20})
    doc.modelspace().add_blockref("sheet", (0, 700))


def unlayered(doc, plan):
    """Single lines on layer 0, each door a leaf that stands open by 30 degrees and its arc."""
    space = doc.modelspace()
    space.delete_all_entities()
    for ends in plan.axes:
        space.add_line(*points(ends))
    for hole in plan.holes:
        start, end = points(hole.ends)
        if hole.kind == "door":
            turn = degrees(atan2(end[1] - start[1], end[0] - start[0]))
            space.add_arc(start, hole.width * 1000, turn, turn + 30)
            turn, size = radians(turn + 30), hole.width * 1000
            space.add_line(start, (start[0] + size * cos(turn), start[1] + size * sin(turn)))


def outlined(doc, plan):
    """Rooms, and a bathroom of 2 m2 beside them, on two layers."""
    doc.modelspace().delete_all_entities()
    for number, area in enumerate([*(area for *_, area in plan.rooms), box(-9, 0, -7, 1)]):
        way = {"layer": f"F12-{min(number, 1)}"}
        doc.modelspace().add_lwpolyline(points(area.exterior.coords), dxfattribs=way)


@pytest.mark.parametrize("change", [nested, unlayered, outlined])
def test_drawings_as_others_make_them(tmp_path, change):
    plan, doc = drawn_flat(2), document()
    add_walls(doc, plan, "bodies")
    change(doc, plan)
    found = read_plan(saved(doc, tmp_path, "bin" if change is outlined else "asc"), "h1")
    areas = sorted(room_polygon(room).area for room in found.rooms)
    drawn = [2.0] * (change is outlined) + [area.area for *_, area in plan.rooms]
    assert areas == pytest.approx(sorted(drawn), rel=0.03)
    doors = [o for wall in found.walls for o in wall.openings if o.kind == "door"]
    assert bool(doors) == (change is unlayered)


@pytest.mark.parametrize("units", [0, 1, 6])
def test_a_unit_that_does_not_suit_the_doors(tmp_path, units):
    plan, doc = drawn_flat(2), document(units)
    unlayered(doc, plan)
    found = read_plan(saved(doc, tmp_path), "h1")
    assert "the unit mm is used" in found.warnings[0]
    true = sum(area.area for _, _, area in plan.rooms)
    assert sum(room_polygon(r).area for r in found.rooms) == pytest.approx(true, rel=0.05)


def test_names_of_a_japanese_program(tmp_path):
    path = saved(ezdxf.new("R12"), tmp_path)
    assert alphabet(path) is None
    named = path.read_bytes()
    path.write_bytes(named + "999\n基準線と壁の窓\n".encode("cp932"))
    assert alphabet(path) == "cp932"
    with pytest.raises(InputError, match="INSUNITS"):
        read_plan(path, "h1")
    path.write_bytes(named + "999\nKüche, Flur, Gästebad\n".encode("cp1252"))
    assert alphabet(path) is None


def test_axes_far_from_the_origin(tmp_path):
    plan, doc = drawn_flat(2), document()
    add_walls(doc, plan, "axes", shift=(3.5e9, 5.4e9))
    place = points([plan.rooms[0][2].centroid.coords[0]], shift=(3.5e9, 5.4e9))[0]
    doc.modelspace().add_text("Kitchen").set_placement(place)
    found = read_plan(saved(doc, tmp_path), "h1")
    assert ["kitchen" in room.id for room in found.rooms].count(True) == 1
    assert len(found.rooms) == len(plan.rooms)
    assert {wall.depth for wall in found.walls} == {0.1}


def test_units_layers_and_names(tmp_path):
    doc = document(units=1)
    for x, name in ((0, "K"), (200, "WOHNZIMMER")):
        ring = [(x, 0), (x + 196, 0), (x + 196, 100), (x, 100)]
        doc.modelspace().add_lwpolyline(ring, close=True, dxfattribs={"layer": "X1"})
        doc.modelspace().add_text(name).set_placement((x + 50, 50))
    path = saved(doc, tmp_path)
    with pytest.raises(InputError, match="0 walls that close none; layers X1"):
        read_plan(path, "h1")
    house = house_of_dxf(path, "h1", layers={"rooms": "X?"})
    assert [room.id for room in house.rooms] == ["room", "wohnzimmer"]
    assert house.rooms[1].types == ("Reception",)
    assert room_polygon(house.rooms[0]).area == pytest.approx(1.96 * 2.54**2, rel=1e-6)
    halved = house_of_dxf(path, "h1", 0.01, {"rooms": "X?"})
    assert room_polygon(halved.rooms[0]).area == pytest.approx(1.96)


def test_what_is_not_in_the_model_space_is_named(tmp_path):
    doc = document()
    doc.add_xref_def("walls.dwg", "walls")
    with pytest.raises(InputError, match=r"found none; layout Layout1, xref walls\.dwg left out"):
        read_plan(saved(doc, tmp_path), "h1")


def test_no_pattern_takes_long():
    kinds = LayerKinds(Source("a.dxf", "h1"), {"walls": 140 * "*a" + "b,[", "rooms": "[[]x],a?c"})
    start = time.perf_counter()
    assert kinds.of_name(255 * "a") == "" and time.perf_counter() - start < 1
    assert kinds.of_name("[x]") == kinds.of_name("ABC") == "rooms"
    with pytest.raises(InputError, match="at most 300 letters of walls in dxf_layers"):
        LayerKinds(Source("a.dxf", "h1"), {"walls": 301 * "a"})


def test_curves_and_solids(tmp_path):
    """A spline closes a room, 3D faces and solids are no part of a plan."""
    doc = document(6)
    space = doc.modelspace()
    ring = [(0, 0, 5), (4, 0, 5), (4, 3, 5), (0, 3, 5), (0, 0, 5)]
    space.add_spline(ring, dxfattribs={"layer": "ROOM"})
    space.add_3dface([(0, 0, 0), (9, 0, 1), (9, 9, 2), (0, 9, 9)], dxfattribs={"layer": "WALL"})
    space.add_ellipse((0, 0), (1, 0), 0.5, dxfattribs={"layer": "FURNITURE"})
    assert 8 < room_polygon(read_plan(saved(doc, tmp_path), "h1").rooms[0]).area < 20


def test_blocks_in_blocks_are_bounded(tmp_path):
    doc = document(6)
    doc.blocks.new("door0").add_line((0, 0), (1, 0))
    for k in range(1, 40):
        for _ in range(2):
            doc.blocks.new(f"door{k}") if f"door{k}" not in doc.blocks else None
            doc.blocks.get(f"door{k}").add_blockref(f"door{k - 1}", (0, 0))
    doc.modelspace().add_blockref("door39", (0, 0))
    with pytest.raises(InputError, match="blocks at most 12 deep"):
        read_plan(saved(doc, tmp_path), "h1")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n", "a DXF drawing that can be read"),
        ("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n999\n0\nENDSEC\n0\nEOF\n", "a unit in the"),
        ("  0\nSECTION\n0\nEOF\n", "found"),
    ],
)
def test_bad_drawings_are_one_line(tmp_path, text, line):
    path = tmp_path / "plan.dxf"
    path.write_text(text)
    assert line in refusal(path)
