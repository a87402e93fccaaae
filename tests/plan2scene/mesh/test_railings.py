"""Balconies: open above, a railing where no room and no opening is."""

from dataclasses import replace

import pytest

from plan2scene.mesh.assembly import build_parts
from plan2scene_app.exports.solids import house_solids


@pytest.fixture
def balcony_house(gap_house):
    """The two rooms with a door between them, the second one a balcony."""
    inside, outside = gap_house.rooms
    return replace(gap_house, rooms=(inside, replace(outside, types=("Balcony",))))


def test_a_balcony_has_no_ceiling_and_railings_on_its_free_sides(balcony_house):
    parts = {part.name: part for part in build_parts(balcony_house)}
    assert "a/ceiling" in parts and "b/ceiling" not in parts
    assert {name for name in parts if "railing" in name} == {f"b/railing/b_w{k}" for k in (0, 1, 2)}
    assert "b/wall/b_w3" in parts  # the house's wall, with the door
    assert not any(name.startswith(("b/wall/b_w0", "structure/wall/b_w0")) for name in parts)
    for k in (0, 1, 2):
        mesh = parts[f"b/railing/b_w{k}"].mesh
        assert mesh.bounds[1, 1] == pytest.approx(1.05)
        assert mesh.volume > 0
    low, high = parts["b/railing/b_w1"].mesh.bounds[:, [0, 2]]
    assert high[1] - low[1] == pytest.approx(4.0, abs=1e-4)
    assert low[0] >= 6.0 - 1e-4 and high[0] < 6.1  # on the wall's line, outwards


def test_a_wall_with_an_opening_stays(l_house):
    terrace = replace(l_house, rooms=(replace(l_house.rooms[0], types=("Terrace",)),))
    names = {part.name for part in build_parts(terrace)}
    assert {"hall/wall/hall_w0", "hall/wall/hall_w1", "hall/railing/hall_w2"} <= names


def test_rooms_that_are_only_partly_outdoors_have_a_ceiling(balcony_house):
    room = replace(balcony_house.rooms[1], types=("Balcony", "Kitchen"))
    names = {
        p.name for p in build_parts(replace(balcony_house, rooms=(balcony_house.rooms[0], room)))
    }
    assert "b/ceiling" in names and not any("railing" in name for name in names)


def test_railings_are_solids_without_a_roof(balcony_house):
    solids = house_solids(balcony_house)
    rails = [solid for solid in solids if solid.category == "railing"]
    assert len(rails) == 3
    assert all(piece.is_watertight for solid in rails for piece in solid.pieces)
    assert "b/ceiling" not in {solid.name for solid in solids}
