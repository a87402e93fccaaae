import numpy as np
from box_room import DOOR_EYE as EYE
from box_room import WIDE, open_door_view

from plan2scene.photos.labels.palette import DOOR, IGNORE, OTHER
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.seen_doors import seen_doors
from plan2scene.photos.locate.seen_planes import seen_planes, shows_its_room


def test_every_pixel_lies_on_its_plane_and_in_its_room_whose_walls_are_named():
    house, pose, labels, ends = open_door_view()
    found = seen_planes(labels, pose, room_shapes(house))
    kinds = {(item.rooms[0], item.plane.surface) for item in found}
    assert {("room", "floor"), ("room", "wall"), ("store", "floor"), ("store", "wall")} <= kinds
    for item in found:
        points = ends[item.plane.mask]
        off = (points - EYE) @ np.array(item.plane.normal) - item.plane.offset
        np.testing.assert_allclose(off, 0.0, atol=1e-6)
        assert ((points[:, 0] > WIDE + 0.05) == (item.rooms[0] == "store")).all()
        assert item.plane.scale_source == "plan"
    ends = {wall.id: np.array([wall.start, wall.end]) for wall in house.walls}
    named = [item for item in found if item.walls]
    assert named and {item.rooms[0] for item in named} == {"room"}
    assert len(named) == sum(f.rooms[0] == "room" and f.plane.surface == "wall" for f in found)
    for item in named:
        normal = np.array(item.plane.normal)[[0, 2]]
        for wall in item.walls:
            off = (ends[wall] - EYE[[0, 2]]) @ normal - item.plane.offset
            np.testing.assert_allclose(off, 0.0, atol=0.2)


def test_what_a_shut_door_hides_is_not_seen_and_a_photo_shows_its_room():
    house, pose, labels, ends = open_door_view()
    labels[ends[..., 0] > WIDE + 0.05] = DOOR
    assert {item.rooms[0] for item in seen_planes(labels, pose, room_shapes(house))} == {"room"}
    house, pose, labels, _ = open_door_view()
    assert seen_planes(labels[::-1].copy(), pose, room_shapes(house)) == []
    shapes = room_shapes(house)
    assert shows_its_room(labels, pose, shapes)
    behind = np.where(ends[..., 0] > WIDE + 0.05, labels, IGNORE).astype(np.uint8)
    assert seen_planes(behind, pose, shapes) and not shows_its_room(behind, pose, shapes)


def test_a_leaf_is_seen_where_a_door_is_likely_and_shut():
    house, pose, labels, ends = open_door_view()
    behind = ends[..., 0] > WIDE + 0.05
    shut = np.where(behind, OTHER, labels)
    doors, shapes = behind.astype(float), room_shapes(house)
    ((opening, pixels),) = seen_doors(shut, 0.5 * doors, pose, shapes)
    assert opening in {o.id for wall in house.walls for o in wall.openings}
    assert behind[tuple(pixels.T)].all()
    assert list(seen_doors(labels, doors, pose, shapes)) == []  # open: the store's floor
    assert list(seen_doors(shut, 0.02 * doors, pose, shapes)) == []  # furniture

    opened = labels.copy()
    start = int(np.argwhere(behind)[:, 1].min())
    leaf = np.s_[20:-20, start - 30 : start - 5]
    opened[leaf] = OTHER
    likely = np.zeros(labels.shape)
    likely[leaf] = 0.9
    ((beside, pixels),) = seen_doors(opened, likely, pose, shapes)
    assert beside == opening and (opened[tuple(pixels.T)] == OTHER).all()
    ((unknown, _),) = seen_doors(opened, likely, None, {})
    assert unknown == ""
