"""Doors and windows."""

from dataclasses import replace

import numpy as np
import pytest
from box_room import box_house

from plan2scene.colour import is_wood, rgb_to_lab, srgb_to_linear
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.joinery import METAL_COLOUR

OAK = (166, 131, 83)
GREEN = (40, 120, 90)


@pytest.mark.parametrize("colour", [OAK, (120, 70, 45), (225, 188, 140)])
def test_browns_are_wood(colour):
    assert is_wood(rgb_to_lab(np.array(colour) / 255))


@pytest.mark.parametrize("colour", [(236, 232, 224), (60, 60, 62), (40, 90, 140), (200, 30, 40)])
def test_white_grey_blue_and_red_are_paint(colour):
    assert not is_wood(rgb_to_lab(np.array(colour) / 255))


def leaf_colours(colour):
    """Return the colours (n, 3) of a door's faces, and their areas (n,), but frame and handle."""
    house = replace(box_house(), door_colours=(("", colour),), trim_colours=(("", (1, 2, 3)),))
    (door,) = [part for part in assemble(house).parts if part.extras.get("kind") == "door"]
    colours = door.colours[door.mesh.faces].astype(float).mean(axis=1)
    flat = door.colours[door.mesh.faces]
    other = [(flat == c).all(axis=(1, 2)) for c in ((1, 2, 3), METAL_COLOUR)]
    return colours[~np.logical_or(*other)], door.mesh.area_faces[~np.logical_or(*other)]


def test_a_wooden_leaf_has_upright_grain_of_its_colour():
    colours, areas = leaf_colours(OAK)
    assert len(np.unique(colours, axis=0)) > 50
    mean = np.average(srgb_to_linear(colours / 255.0), axis=0, weights=areas)
    assert mean == pytest.approx(srgb_to_linear(np.array(OAK, np.uint8)), rel=0.04)


def test_a_painted_leaf_has_panels():
    colours, _ = leaf_colours(GREEN)
    assert len(np.unique(colours, axis=0)) == 2
