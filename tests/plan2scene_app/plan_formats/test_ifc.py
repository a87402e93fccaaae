from dataclasses import replace

import pytest
from places import ROOT
from plan_drawing import FLATS, assert_found, assert_storeys, body, drawn_flat, refusal

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene_app.exports.ifc4 import write_ifc

ifcopenshell = pytest.importorskip("ifcopenshell")
GUID = pytest.importorskip("ifcopenshell.guid")


class Writer:
    def __init__(self):
        self.file = ifcopenshell.file(schema="IFC4")
        f = self.file
        milli = f.createIfcSIUnit(None, "LENGTHUNIT", "MILLI", "METRE")
        self.origin = f.createIfcAxis2Placement3D(self.point(0, 0, 0))
        context = f.createIfcGeometricRepresentationContext(None, "Model", 3, 1e-5, self.origin)
        self.body = f.createIfcGeometricRepresentationSubContext(
            "Body", "Model", None, None, None, None, context, None, "MODEL_VIEW", None
        )
        units = f.createIfcUnitAssignment([milli])
        told = {"RepresentationContexts": [context], "UnitsInContext": units}
        self.project = self.root("IfcProject", **told)
        self.place = f.createIfcLocalPlacement(None, self.origin)

    def point(self, *values):
        return self.file.createIfcCartesianPoint([float(v) * 1000 for v in values])

    def root(self, kind, **facts):
        return self.file.create_entity(kind, GlobalId=GUID.new(), **facts)

    def product(self, kind, area, low, high, **facts):
        f = self.file
        points = [self.point(x, -z) for x, z in list(area.exterior.coords)[:-1]]
        line = f.createIfcPolyline([*points, points[0]])
        profile = f.createIfcArbitraryClosedProfileDef("AREA", None, line)
        position = f.createIfcAxis2Placement3D(self.point(0, 0, low))
        up = f.createIfcDirection([0.0, 0.0, 1.0])
        solid = f.createIfcExtrudedAreaSolid(profile, position, up, float(high - low) * 1000)
        shape = f.createIfcShapeRepresentation(self.body, "Body", "SweptSolid", [solid])
        shapes = f.createIfcProductDefinitionShape(None, None, [shape])
        return self.root(kind, ObjectPlacement=self.place, Representation=shapes, **facts)

    def storey(self, plan, name, base=0.0, spaces=True, walls=True, contained=False):
        storey = self.root("IfcBuildingStorey", Name=name, Elevation=base * 1000)
        self.root("IfcRelAggregates", RelatingObject=self.project, RelatedObjects=[storey])
        rooms = [
            self.product("IfcSpace", area, base, base + plan.height, LongName=" / ".join(types))
            for _, types, area in (plan.rooms if spaces else ())
        ]
        if rooms and not contained:
            self.root("IfcRelAggregates", RelatingObject=storey, RelatedObjects=rooms)
        elements = list(rooms) if contained else []
        bodies = []
        for ends in plan.axes if walls else ():
            area = body(ends, plan.thickness, "square")
            wall = self.product("IfcWall", area, base, base + plan.height)
            elements.append(wall)
            bodies.append((area, wall))
        for hole in plan.holes if walls else ():
            area = body(hole.ends, 2 * plan.thickness, "flat")
            wall = max(bodies, key=lambda pair: pair[0].intersection(area).area)[1]
            low, high = base + hole.bottom, base + hole.top
            opening = self.product("IfcOpeningElement", area, low, high)
            cut = {"RelatingBuildingElement": wall, "RelatedOpeningElement": opening}
            self.root("IfcRelVoidsElement", **cut)
            if hole.kind != "passage":
                leaf = self.root(f"Ifc{hole.kind.title()}", ObjectPlacement=self.place)
                fit = {"RelatingOpeningElement": opening, "RelatedBuildingElement": leaf}
                self.root("IfcRelFillsElement", **fit)
                elements.append(leaf)
        if elements:
            within = {"RelatedElements": elements, "RelatingStructure": storey}
            self.root("IfcRelContainedInSpatialStructure", **within)

    def saved(self, tmp_path):
        self.file.write(str(tmp_path / "plan.ifc"))
        return tmp_path / "plan.ifc"


@pytest.mark.parametrize("number", range(len(FLATS)))
def test_round_trip(tmp_path, number):
    plan, writer = drawn_flat(number), Writer()
    writer.storey(plan, "ground", base=3.0)
    if number == 0:  # at its place on the earth
        corner = writer.point(352e3, 5.8e6, 1400)
        writer.place.RelativePlacement = writer.file.createIfcAxis2Placement3D(corner)
    found = read_plan(writer.saved(tmp_path), "h1")
    assert_found(plan, found)
    assert {round(wall.depth, 4) for wall in found.walls} == {plan.thickness}


def test_a_model_whose_storey_contains_its_spaces_or_has_none(tmp_path):
    """Against the standard, and done: the relation is of walls and doors."""
    plan = drawn_flat(2)
    for spaces in (True, False):
        writer = Writer()
        writer.storey(plan, "ground", contained=spaces, spaces=spaces)
        found = read_plan(writer.saved(tmp_path), "h1")
        assert_found(plan, found, types=spaces)
        assert found.levels == () and not (spaces and found.warnings)


@pytest.mark.parametrize(
    ("schema", "line"), [("IFC2X_FINAL", "IfcWall in the model"), ("IFC9", "schema: IFC9")]
)
def test_an_old_schema_is_read_as_the_next_one(tmp_path, schema, line):
    path = tmp_path / "plan.ifc"
    path.write_text(ifcopenshell.file(schema="IFC2X3").to_string().replace("IFC2X3", schema))
    with pytest.raises(InputError, match=line):
        read_plan(path, "h1")


@pytest.mark.parametrize(
    ("names", "ids"), [(("Ground", "Up"), ("ground", "up")), (2 * ("Level",), ("level", "level_2"))]
)
def test_two_storeys_come_back(tmp_path, names, ids):
    plans, writer = (drawn_flat(2), drawn_flat(0)), Writer()
    for plan, name, base in zip(plans, names, (0.0, 3.0), strict=True):
        writer.storey(plan, name, base=base)
    found = read_plan(writer.saved(tmp_path), "h1")
    assert_storeys(plans, found, list(zip(ids, (0.0, 3.0), strict=True)))


def test_foundations_are_no_storey(tmp_path):
    plan, writer = drawn_flat(2), Writer()
    writer.storey(replace(plan, holes=[]), "T/FDN", base=-1.2, spaces=False)
    writer.storey(plan, "Ground")
    found = read_plan(writer.saved(tmp_path), "h1")
    assert_found(plan, found)
    assert found.levels == ()
    (line,) = [line for line in found.warnings if "T/FDN" in line]
    assert line.endswith("found walls alone, left out")


def test_our_own_export_comes_back_with_its_stairs(tmp_path):
    house = read_plan(ROOT / "resources/examples/two_storeys/plan.json", "two")
    write_ifc(house, {}, tmp_path)
    found = read_plan(tmp_path / "house.ifc", "two")
    assert [level.elevation for level in found.levels] == pytest.approx([0.0, 2.8])
    assert len(found.rooms) == len(house.rooms)
    (stairs,) = found.stairs
    assert (*stairs.start, *stairs.end) == pytest.approx((0.45, 4.6, 0.45, 1.0), abs=1e-3)
    assert stairs.width == pytest.approx(0.9, abs=1e-3) and None not in stairs.room_ids


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("ISO-10303-21;\nHEADER;\n", "that can be read, found one without its last lines"),
        ("ISO-10303-21;\nEND-ISO-10303-21;", "an IFC model that can be read"),
        (None, "IfcSpace or IfcWall in the model, found none"),
    ],
)
def test_bad_models_are_one_line(tmp_path, text, line):
    path = Writer().saved(tmp_path)
    if text is not None:
        path.write_text(text)
    assert line in refusal(path)


def test_a_direction_of_huge_numbers_is_refused(tmp_path):
    writer = Writer()
    writer.storey(drawn_flat(2), "ground")
    writer.file.by_type("IfcDirection")[0].DirectionRatios = [1e20, 0.0, 1.0]
    with pytest.raises(InputError, match="directions of numbers within 1e"):
        read_plan(writer.saved(tmp_path), "h1")
