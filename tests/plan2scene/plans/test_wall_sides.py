"""Wall faces: the inner side, openings as seen from it, the way along the outline, reveals."""

from itertools import pairwise

import numpy as np
import pytest

from plan2scene.house import Opening, Room, Wall
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import (
    arc_offset,
    inner_normal,
    openings_on,
    reveal_quads,
    wall_frame,
)

SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


def face(room, wall):
    return wall_frame(wall, inner_normal(wall, room_polygon(room)))


@pytest.mark.parametrize("ring", [SQUARE, SQUARE[::-1]])
@pytest.mark.parametrize("turned", [False, True])
def test_a_face_does_not_depend_on_the_order_of_points(ring, turned):
    room = Room("a", ("Bedroom",), (ring,), 2.5)
    window = Opening("o", "window", *((2.5, 3.0) if turned else (1.0, 1.5)), 0.8, 9.0)
    ends = ((0.0, 0.0), (4.0, 0.0))
    wall = Wall("w", ("a",), *(ends[::-1] if turned else ends), 2.5, openings=(window,))
    frame = face(room, wall)
    assert frame.normal == pytest.approx((0.0, 1.0))
    assert frame.plan(0.0) == pytest.approx((0.0, 0.0))  # facing -z, right is +x
    (hole,) = openings_on(wall, frame)
    assert (hole.left, hole.right, hole.bottom, hole.top) == pytest.approx((1.0, 1.5, 0.8, 2.5))


def test_inner_side_of_both_rooms_of_a_shared_wall():
    other = tuple((x, z - 3.0) for x, z in SQUARE)
    wall = Wall("w", ("a", "b"), (0.0, 0.0), (4.0, 0.0), 2.5)
    assert face(Room("a", (), (SQUARE,), 2.5), wall).normal == pytest.approx((0.0, 1.0))
    assert face(Room("b", (), (other,), 2.5), wall).normal == pytest.approx((0.0, -1.0))


def test_inner_side_of_a_slanted_wall_of_an_l_shaped_room():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 4.0), (0.0, 2.0))
    wall = Wall("w", ("a",), (2.0, 4.0), (0.0, 2.0), 2.5)
    normal = face(Room("a", (), (ring,), 2.5), wall).normal
    assert normal == pytest.approx((0.5**0.5, -(0.5**0.5)))


@pytest.mark.parametrize("turn", [1, -1])
def test_faces_follow_each_other_round_outline_and_hole(turn):
    well = ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))
    room = Room("a", (), (SQUARE[::turn], well[::turn]), 2.5)
    for ring in room.rings:
        walls = [Wall("w", ("a",), a, b, 2.5) for a, b in pairwise((*ring, ring[0]))]
        faces = sorted((face(room, wall) for wall in walls), key=lambda f: arc_offset(room, f))
        starts = [arc_offset(room, f) for f in faces]
        assert starts == pytest.approx([0.0, *np.cumsum([f.length for f in faces])[:-1]])
        for one, following in pairwise(faces):
            assert one.plan(one.length) == pytest.approx(following.plan(0.0))


def test_reveals_close_the_hole_and_look_into_it():
    room = Room("a", (), (SQUARE,), 2.5)
    door = Opening("o", "door", 1.0, 1.5, 0.5, 2.0)
    wall = Wall("w", ("a",), (0.0, 0.0), (4.0, 0.0), 2.5, openings=(door,))
    frame = face(room, wall)
    (hole,) = openings_on(wall, frame)
    back = frame.plan(np.array([hole.left, hole.right]), -0.2)
    centre = np.array([1.25, 1.25, -0.1])
    for quad in reveal_quads(frame, hole, back):
        inwards = np.cross(quad[1] - quad[0], quad[2] - quad[0])
        assert inwards @ (centre - quad[0]) > 0
        assert np.linalg.norm(inwards) == pytest.approx(0.2 * (0.5 if inwards[1] else 1.5))
