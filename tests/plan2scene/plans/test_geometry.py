from plan2scene.house import Door, Opening, Room, Wall
from plan2scene.plans.geometry import find_doors, walls_of_rooms

SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


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
