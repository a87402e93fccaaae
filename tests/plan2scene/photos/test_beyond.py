"""What lies beyond a door frame, or farther than the room is long, is not the room's."""

import numpy as np
from box_room import DEEP, HEIGHT, WIDE, open_door_view

from plan2scene.photos.camera.calibration import canonical
from plan2scene.photos.planes.planes import split_planes
from plan2scene.photos.planes.walls import WallLine, room_reach, within_room


def test_through_a_door_nothing_is_the_rooms():
    _, pose, labels, ends = open_door_view()
    camera = pose.camera.with_rotation(canonical(pose.camera.matrix))
    planes = split_planes(
        labels, camera, room_height_m=HEIGHT, room_extent_m=(WIDE, DEEP), camera_height_m=1.5
    )
    floor = next(plane for plane in planes if plane.surface == "floor")
    behind = ends[..., 0] > WIDE + 0.3
    assert (behind & (labels == 1)).sum() > 100
    assert (floor.mask & behind).sum() == 0
    own = (labels == 1) & (ends[..., 0] < WIDE)
    assert (floor.mask & own).sum() > 0.97 * own.sum()


def test_a_door_is_a_farther_wall_between_two_parts_of_a_nearer():
    azimuth = np.radians(np.linspace(-30, 30, 61))
    direction = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    lines = [WallLine((0.0, 1.0), 3.0, True), WallLine((0.0, 1.0), 5.0, True)]
    path = np.where(np.abs(np.degrees(azimuth)) < 8, 1, 0)
    reach, through = room_reach(lines, path, direction)
    np.testing.assert_allclose(reach, 3.0 / direction[:, 1])
    np.testing.assert_array_equal(through, path == 1)
    at_the_side = np.where(np.degrees(azimuth) < 8, 1, -1)
    reach, through = room_reach(lines, at_the_side, direction)
    assert not through.any()
    assert np.isinf(reach[at_the_side < 0]).all()


def test_floor_farther_than_the_room_is_long_is_left_out():
    _, pose, labels, ends = open_door_view()
    no_door = np.full(labels.shape, np.inf)
    floor = (labels == 1) & (ends[..., 1] < 1e-6)
    away = np.hypot(ends[..., 0] - pose.position[0], ends[..., 2] - pose.position[2])
    near = within_room(floor, pose.camera, pose.position[1], no_door, 3.0)
    np.testing.assert_array_equal(near, floor & (away < 3.0 * 1.1))
    np.testing.assert_array_equal(
        within_room(floor, pose.camera, pose.position[1], no_door, 0.1), floor
    )
