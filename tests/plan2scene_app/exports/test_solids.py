from dataclasses import replace

import numpy as np
import pytest
import shapely
from sample_houses import with_openings
from scipy.spatial.transform import Rotation

from plan2scene_app.exports.solids import LEAST_WALL, SLAB, house_solids


@pytest.fixture(params=("l_house", "ring_house", "shared_house", "gap_house"))
def house(request):
    return request.getfixturevalue(request.param)


def area(piece):
    return shapely.MultiPoint(piece.vertices[:, [0, 2]]).convex_hull


def test_pieces_are_closed_and_convex_and_a_hatch_has_no_pane(house, gap_house):
    solids = house_solids(house)
    assert len({solid.name for solid in solids}) == len(solids)
    for piece in (piece for solid in solids for piece in solid.pieces):
        assert piece.is_watertight and piece.is_convex and piece.volume > 0
    hatch = with_openings(replace(gap_house, doors=()), kind="window", bottom=1.0)
    assert {solid.category for solid in house_solids(hatch)}.isdisjoint({"window", "door"})


def test_slabs_are_the_rooms(house):
    solids = {solid.name: solid for solid in house_solids(house)}
    for room in house.rooms:
        outline = shapely.Polygon(room.rings[0], room.rings[1:])
        for surface, low in (("floor", -SLAB), ("ceiling", room.height)):
            solid = solids[f"{room.id}/{surface}"]
            assert solid.category == surface
            assert sum(p.volume for p in solid.pieces) == pytest.approx(outline.area * SLAB)
            assert min(piece.bounds[0, 1] for piece in solid.pieces) == pytest.approx(low)


@pytest.mark.parametrize(("name", "walls"), [("gap_house", 0.1), ("shared_house", LEAST_WALL)])
def test_a_door_is_a_hole_with_a_floor_and_a_leaf(request, name, walls):
    solids = house_solids(request.getfixturevalue(name))
    way = shapely.Point(3.0 + walls / 2 if name == "gap_house" else 3.0, 1.4)
    heads = [
        piece.bounds[0, 1]
        for solid in solids
        if solid.category == "wall"
        for piece in solid.pieces
        if area(piece).contains(way)
    ]
    assert min(heads) == pytest.approx(2.0)
    floors = [s for s in solids if s.category == "floor" for p in s.pieces if area(p).contains(way)]
    assert floors or name == "shared_house"
    (leaf,) = [solid for solid in solids if solid.category == "door"]
    assert set(leaf.room_ids) == {"a", "b"} and 0.6 < np.ptp(leaf.pieces[0].bounds[:, 2]) < 0.8


@pytest.mark.parametrize("name", ["gap_house", "l_house"])
def test_a_leaf_opens_into_its_room(request, name):
    house = request.getfixturevalue(name)
    (leaf,) = [solid for solid in house_solids(house) if solid.category == "door"]
    hinge = leaf.hinge
    axis = np.array([hinge.x, 0.0, hinge.z])
    turn = Rotation.from_euler("y", 90 * hinge.opens, degrees=True)
    moved = turn.apply(leaf.pieces[0].vertices - axis) + axis
    inside = shapely.Polygon(house.room(leaf.room_ids[0]).rings[0]).buffer(0.06)
    assert inside.contains(shapely.MultiPoint(moved[:, [0, 2]]).convex_hull)
