from dataclasses import replace

import numpy as np
import pytest
from box_room import box_house
from sample_houses import parts_of, walls_of

from plan2scene.colour import is_wood, rgb_to_lab, srgb_to_linear
from plan2scene.house import Door, House, Opening, Room
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.joinery import FRAME_COLOUR, METAL_COLOUR, PANEL_SHADE

OAK = (166, 131, 83)
GREEN = (40, 120, 90)


@pytest.mark.parametrize(
    ("wood", "colours"),
    [
        (True, [OAK, (120, 70, 45), (225, 188, 140)]),
        (False, [(236, 232, 224), (60, 60, 62), (40, 90, 140), (200, 30, 40)]),
    ],
)
def test_browns_are_wood_and_white_grey_blue_and_red_are_paint(wood, colours):
    assert [is_wood(rgb_to_lab(np.array(c) / 255)) for c in colours] == [wood] * len(colours)


def leaf_colours(colour):
    """Return the colours (n, 3) of a door's faces, and their areas (n,), but frame and handle."""
    house = replace(box_house(), door_colours=(("", colour),), trim_colours=(("", (1, 2, 3)),))
    (door,) = [part for part in assemble(house).parts if part.extras.get("kind") == "door"]
    colours = door.colours[door.mesh.faces].astype(float).mean(axis=1)
    flat = door.colours[door.mesh.faces]
    other = [(flat == c).all(axis=(1, 2)) for c in ((1, 2, 3), METAL_COLOUR)]
    return colours[~np.logical_or(*other)], door.mesh.area_faces[~np.logical_or(*other)]


def test_a_wooden_leaf_has_upright_grain_of_its_colour_and_a_painted_one_panels():
    colours, areas = leaf_colours(OAK)
    assert len(np.unique(colours, axis=0)) > 50
    mean = np.average(srgb_to_linear(colours / 255.0), axis=0, weights=areas)
    assert mean == pytest.approx(srgb_to_linear(np.array(OAK, np.uint8)), rel=0.04)
    colours, _ = leaf_colours(GREEN)
    assert len(np.unique(colours, axis=0)) == 2


def outer_door(wide, types=("Unknown",), name="Garage", **changes):
    """Return the parts of a house of one room with a door so wide to the outside."""
    house = box_house(wide=3.2)
    walls = list(house.walls)
    hole = replace(walls[2].openings[0], kind="door", start=0.3, end=0.3 + wide, bottom=0.0)
    walls[2] = replace(walls[2], openings=(hole,))
    room = replace(house.rooms[0], types=types, name=name)
    return parts_of(House("h", (room,), tuple(walls), (), **changes))


@pytest.mark.parametrize(
    ("types", "name", "wide", "glass"),
    [
        (("Terrace",), "Pavilion", 2.4, True),
        (("Corridor",), "Hall", 2.4, True),
        (("Corridor",), "Hall", 1.6, False),  # a front door
        (("Unknown",), "Garage", 2.4, False),
    ],
)
def test_a_wide_door_to_the_outside_is_glass_but_a_garages(types, name, wide, glass):
    assert ("room/door/wide/glass" in outer_door(wide, types, name)) == glass


def test_a_garage_door_has_sections_and_no_handle():
    door = outer_door(2.6, door_colours=(("", GREEN),))["room/door/wide"]
    dark = tuple(round(PANEL_SHADE * value) for value in GREEN)
    assert {tuple(c) for c in door.colours[:, :3].tolist()} == {FRAME_COLOUR, GREEN, dark}
    flat = (door.colours[door.mesh.faces][..., :3] == GREEN).all(axis=(1, 2))
    heights = np.unique(door.mesh.vertices[door.mesh.faces[flat]][..., 1].round(3))
    assert len(heights) == 2 * 4  # four sections of 53 cm


def leaf_points(ring, start):
    """Return the points (n, 2) of a door's leaf in a closet, x and z, without those at the wall.

    The closet (corners `ring`) lies beside a hall at x = 3.1; the door begins at z = `start`.
    """
    closet = Room("a", ("Closet",), (ring,), 2.5)
    hall = Room("b", ("Corridor",), (((3.1, 0.0), (6.0, 0.0), (6.0, 4.0), (3.1, 4.0)),), 2.5)
    end = start + 0.8
    walls = (
        *walls_of(closet, openings={1: [Opening("ab", "door", start, end, 0.0, 2.0)]}),
        *walls_of(hall, openings={3: [Opening("ba", "door", 4.0 - end, 4.0 - start, 0.0, 2.0)]}),
    )
    doors = (Door("a", "ab", "b"), Door("b", "ba", "a"))
    ends = parts_of(House("h", (closet, hall), walls, doors))["a/door/ab"].mesh.vertices[:, [0, 2]]
    return ends[ends[:, 0] < 2.9]


@pytest.mark.parametrize(("back", "reach"), [(1.0, (2.3, 2.4)), (2.5, (2.5, 2.7))])
def test_a_leaf_stands_wide_open_but_not_in_a_wall(back, reach):
    points = leaf_points(((back, 0.0), (3.0, 0.0), (3.0, 4.0), (back, 4.0)), 1.6)
    assert reach[0] < points[:, 0].min() < reach[1]


@pytest.mark.parametrize("deep_first", [True, False])
def test_a_leaf_has_its_hinge_where_the_room_is_deeper(deep_first):
    first, last = (1.6, 2.7) if deep_first else (2.7, 1.6)
    points = leaf_points(((first, 0.0), (3.0, 0.0), (3.0, 1.2), (last, 1.2)), 0.2)
    assert (points[:, 1].mean() < 0.6) == deep_first
