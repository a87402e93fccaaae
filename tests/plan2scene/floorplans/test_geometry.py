import pytest

from plan2scene.floorplans.geometry import find_doors, inner_normal, walls_of_rooms
from plan2scene.house import Door, Opening, Room, Wall

SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


@pytest.mark.parametrize("ring", [SQUARE, SQUARE[::-1]])
@pytest.mark.parametrize("turned", [False, True])
def test_inner_side_does_not_depend_on_the_order_of_points(ring, turned):
    room = Room("a", ("Bedroom",), (ring,), 2.5)
    ends = ((0.0, 0.0), (4.0, 0.0))
    wall = Wall("w", ("a",), *(ends[::-1] if turned else ends), 2.5)
    assert inner_normal(room, wall) == pytest.approx((0.0, 1.0))


def test_inner_side_of_both_rooms_of_a_shared_wall():
    other = tuple((x, z - 3.0) for x, z in SQUARE)
    wall = Wall("w", ("a", "b"), (0.0, 0.0), (4.0, 0.0), 2.5)
    assert inner_normal(Room("a", (), (SQUARE,), 2.5), wall) == pytest.approx((0.0, 1.0))
    assert inner_normal(Room("b", (), (other,), 2.5), wall) == pytest.approx((0.0, -1.0))


def test_inner_side_of_a_slanted_wall_of_an_l_shaped_room():
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 4.0), (0.0, 2.0))
    room = Room("a", (), (ring,), 2.5)
    wall = Wall("w", ("a",), (2.0, 4.0), (0.0, 2.0), 2.5)
    assert inner_normal(room, wall) == pytest.approx((0.5**0.5, -(0.5**0.5)))


def test_rooms_apart_keep_their_own_walls():
    far = tuple((x + 4.1, z) for x, z in SQUARE)
    rooms = [Room("a", (), (SQUARE,), 2.5), Room("b", (), (far,), 2.5)]
    assert [wall.room_ids for wall in walls_of_rooms(rooms)] == [("a",)] * 4 + [("b",)] * 4


def test_shared_wall_is_as_high_as_the_higher_room():
    beside = tuple((x + 4.0, z) for x, z in SQUARE)
    rooms = [Room("a", (), (SQUARE,), 2.5), Room("b", (), (beside,), 3.0)]
    walls = walls_of_rooms(rooms, depth=0.2)
    assert [wall.height for wall in walls if len(wall.room_ids) == 2] == [3.0]
    assert len(walls) == 7


def test_doors_of_each_rooms_own_wall():
    beside = tuple((x + 4.1, z) for x, z in SQUARE)
    rooms = [Room("a", (), (SQUARE,), 2.5), Room("b", (), (beside,), 2.5)]
    holes = [Opening(name, "door", 1.0, 2.0, 0.0, 2.0) for name in ("o", "p")]
    walls = [
        Wall("w", ("a",), (4.0, 0.0), (4.0, 3.0), 2.5, openings=(holes[0],)),
        Wall("v", ("b",), (4.1, 0.0), (4.1, 3.0), 2.5, openings=(holes[1],)),
        Wall(
            "u", ("a",), (0.0, 0.0), (0.0, 3.0), 2.5, openings=(Opening("q", "door", 1, 2, 0, 2),)
        ),
        Wall(
            "t", ("a",), (0.0, 0.0), (4.0, 0.0), 2.5, openings=(Opening("r", "window", 1, 2, 1, 2),)
        ),
    ]
    assert find_doors(rooms, walls) == (
        Door("a", "o", "b"),
        Door("b", "p", "a"),
        Door("a", "q", None),
    )
