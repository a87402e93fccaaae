"""Which room's surface each pixel of a located photo shows, checked by where its ray ends."""

import numpy as np
from box_room import DEEP, HEIGHT, SIZE, WIDE, box_house, rendered
from views import camera_looking

from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.locate.likelihood import DOOR
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.locate.seen_planes import seen_planes

EYE = np.array([1.2, 1.5, 1.2])


def view():
    """A look at the open door: (house, pose, labels, end of each ray in the room or behind)."""
    house = box_house()
    camera = camera_looking(SIZE, heading_deg=-86.0, pitch_deg=12.0, focal=150.0)
    labels = rendered(house, camera, EYE)
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    rays = camera.rays(np.stack([x, y], axis=-1))
    ends = EYE + rays * reach_in(rays, (0.0, 0.0), (WIDE, DEEP))[..., None]
    through = labels == DOOR
    behind = EYE + rays * reach_in(rays, (WIDE + 0.1, 0.0), (WIDE + 2.1, 2.0))[..., None]
    ends[through] = behind[through]
    labels[through] = WALL
    labels[through & (ends[..., 1] < 1e-6)] = FLOOR
    labels[through & (ends[..., 1] > HEIGHT - 1e-6)] = CEILING
    return house, Pose("room", tuple(EYE.tolist()), camera, 0.9), labels, ends


def reach_in(rays, low, high):
    """Metres along unit rays from `EYE` to where they leave a box over a plan rectangle."""
    low, high = np.array([low[0], 0.0, low[1]]), np.array([high[0], HEIGHT, high[1]])
    with np.errstate(divide="ignore"):
        return np.where(rays > 0, (high - EYE) / rays, (low - EYE) / rays).min(axis=-1)


def test_every_pixel_lies_on_its_plane_and_in_its_room():
    house, pose, labels, ends = view()
    found = seen_planes(labels, pose, room_shapes(house))
    kinds = {(item.room_id, item.plane.surface) for item in found}
    assert {("room", "floor"), ("room", "wall"), ("store", "floor"), ("store", "wall")} <= kinds
    for item in found:
        points = ends[item.plane.mask]
        off = (points - EYE) @ np.array(item.plane.normal) - item.plane.offset
        np.testing.assert_allclose(off, 0.0, atol=1e-6)
        assert ((points[:, 0] > WIDE + 0.05) == (item.room_id == "store")).all()
        assert item.plane.scale_source == "plan"


def test_planes_of_a_surface_have_numbers_of_their_own():
    house, pose, labels, _ = view()
    found = seen_planes(labels, pose, room_shapes(house))
    numbers = [(item.plane.surface, item.plane.index) for item in found]
    assert len(set(numbers)) == len(numbers)
    assert [item.room_id for item in found if item.plane.surface == "floor"] == ["room", "store"]


def test_no_pixel_has_two_planes_and_most_have_one():
    house, pose, labels, _ = view()
    total = sum(
        item.plane.mask.astype(int) for item in seen_planes(labels, pose, room_shapes(house))
    )
    assert total.max() == 1
    surfaces = (labels == FLOOR) | (labels == WALL) | (labels == CEILING)
    assert (total[surfaces] > 0).mean() > 0.85


def test_a_shut_door_is_no_surface():
    house, pose, labels, ends = view()
    labels[ends[..., 0] > WIDE + 0.05] = DOOR
    assert {item.room_id for item in seen_planes(labels, pose, room_shapes(house))} == {"room"}
