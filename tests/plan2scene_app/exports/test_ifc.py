import numpy as np
import pytest
import shapely

from plan2scene_app.exports.ifc4 import write_ifc

ifcopenshell = pytest.importorskip("ifcopenshell")


@pytest.fixture
def model(gap_house, tmp_path):
    write_ifc(gap_house, {}, tmp_path)
    return ifcopenshell.open(str(tmp_path / "house.ifc"))


def solids(entity):
    return entity.Representation.Representations[0].Items


def footprint(solid):
    points = [point.Coordinates for point in solid.SweptArea.OuterCurve.Points]
    return shapely.Polygon([(x, -y) for x, y in points])


def test_spaces_are_the_rooms(model, gap_house):
    spaces = {space.Name: space for space in model.by_type("IfcSpace")}
    assert spaces.keys() == {"a", "b"}
    for room in gap_house.rooms:
        (solid,) = solids(spaces[room.id])
        assert footprint(solid).symmetric_difference(shapely.Polygon(room.rings[0])).area < 1e-4
        assert solid.Depth == pytest.approx(room.height)
    assert spaces["a"].LongName == "Bedroom"


def test_valid_against_the_schema(model):
    from ifcopenshell import validate

    logger = validate.json_logger()
    validate.validate(model, logger)
    assert logger.statements == []
    units = {unit.UnitType: unit.Name for unit in model.by_type("IfcSIUnit")}
    assert units["LENGTHUNIT"] == "METRE"
    (storey,) = model.by_type("IfcBuildingStorey")
    contained = {e for rel in storey.ContainsElements for e in rel.RelatedElements}
    assert (set(model.by_type("IfcWall")) | set(model.by_type("IfcDoor"))) <= contained


def test_the_door_fills_an_opening_of_the_wall(model):
    (door,) = model.by_type("IfcDoor")
    opening = door.FillsVoids[0].RelatingOpeningElement
    wall = opening.VoidsElements[0].RelatingBuildingElement
    assert wall.Name == "a_w1"
    assert door.OverallWidth == pytest.approx(0.8) and door.OverallHeight == pytest.approx(2.0)
    across = np.ptp(np.asarray(footprint(solids(opening)[0]).exterior.coords), axis=0)
    assert across[1] == pytest.approx(0.8, abs=1e-3)
    # The wall's own body is whole: openings are cut from it by whoever reads.
    assert footprint(solids(wall)[0]).contains(shapely.Point(3.02, 1.4))
