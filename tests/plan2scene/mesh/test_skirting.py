"""Skirting boards: along every wall's foot, none where one walks through."""

import pytest

from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.structure import SKIRTING


def board(house, name):
    return {part.name: part for part in build_parts(house)}[f"{name}/skirting"].mesh


def test_length_is_the_walls_less_the_door(l_house):
    mesh = board(l_house, "hall")
    low, high = mesh.bounds
    assert (low[1], high[1]) == (0.0, pytest.approx(SKIRTING.height))
    # Boxes overlap in the corners, so the volume is of the lengths, not of a union.
    length = 2 * (5.0 + 4.0) - (0.9 + 2 * SKIRTING.frame)
    assert mesh.volume == pytest.approx(length * SKIRTING.height * SKIRTING.depth, rel=1e-3)


def test_it_stands_inside_its_room(l_house):
    low, high = board(l_house, "hall").bounds
    assert low[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert high[[0, 2]] == pytest.approx([5.0, 4.0], abs=1e-6)


def test_no_board_crosses_a_door(gap_house):
    mesh = board(gap_house, "a")
    ray = mesh.ray.intersects_any([[2.5, SKIRTING.height / 2, 1.4]], [[1.0, 0.0, 0.0]])
    assert not ray.any()
    assert mesh.ray.intersects_any([[2.5, SKIRTING.height / 2, 3.0]], [[1.0, 0.0, 0.0]]).all()


def test_bathrooms_have_none(gap_house):
    assert "b/skirting" not in {part.name for part in build_parts(gap_house)}
