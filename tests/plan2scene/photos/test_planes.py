import numpy as np
import pytest
from box_room import DEEP, HEIGHT, WIDE, open_door_view
from views import camera_looking

from plan2scene.photos.camera.calibration import canonical
from plan2scene.photos.labels.palette import CEILING, FLOOR, OTHER, WALL
from plan2scene.photos.planes.planes import split_planes

SIZE = (360, 480)
LOW = np.array([-1.8, 0.0, -2.0])
HIGH = np.array([2.2, 2.5, 2.6])


def box_view(heading_deg, pitch_deg, eye, fov_deg=75.0):
    """Labels, wall sides (axis * 2 + positive) and camera of a view into a box."""
    focal = SIZE[1] / 2 / np.tan(np.radians(fov_deg) / 2)
    camera = camera_looking(SIZE, heading_deg=heading_deg, pitch_deg=pitch_deg, focal=focal)
    rays = camera.rays_at(*np.indices(SIZE))
    with np.errstate(divide="ignore"):
        reach = np.where(rays > 0, (HIGH - eye) / rays, (LOW - eye) / rays)
    axis = reach.argmin(axis=-1)
    positive = np.take_along_axis(rays, axis[..., None], axis=-1)[..., 0] > 0
    side = np.where(axis == 1, -1, axis * 2 + positive)
    labels = np.full(SIZE, WALL, np.uint8)
    labels[(axis == 1) & ~positive] = FLOOR
    labels[(axis == 1) & positive] = CEILING
    return labels, side, camera


def side_of(plane):
    """The wall side of a plane, coded as in `box_view`."""
    axis = int(np.argmax(np.abs(plane.normal)))
    return axis * 2 + (plane.normal[axis] < 0)


def distance_to(side, eye):
    axis, positive = divmod(side, 2)
    return HIGH[axis] - eye[axis] if positive else eye[axis] - LOW[axis]


@pytest.mark.parametrize(("heading", "pitch"), [(25, 8), (-40, 3), (80, 12), (0, 5)])
def test_walls_of_a_box(heading, pitch):
    eye = np.array([0.2, 1.5, -0.9])
    labels, side, camera = box_view(heading, pitch, eye)
    planes = split_planes(labels, camera, camera_height_m=1.5, room_height_m=2.5)
    walls = [plane for plane in planes if plane.surface == "wall"]
    clear = {s for s in range(6) if (side == s).mean() > 0.015}
    present = {s for s in range(6) if (side == s).mean() > 0.002}
    assert clear <= {side_of(plane) for plane in walls} <= present
    assert [plane.index for plane in walls] == list(range(len(walls)))
    for plane in walls:
        truth = side == side_of(plane)
        overlap = (truth & plane.mask).sum() / (truth | plane.mask).sum()
        assert overlap > (0.93 if truth.mean() > 0.015 else 0.3)
        assert -plane.offset == pytest.approx(distance_to(side_of(plane), eye), rel=0.03)
        assert plane.scale_source in ("camera_height", "room_height")


def test_floor_and_ceiling():
    labels, _, camera = box_view(10.0, -3.0, np.array([0.2, 1.4, -1.4]))
    planes = {p.surface: p for p in split_planes(labels, camera, room_height_m=2.5)}
    assert planes["floor"].normal == (0.0, 1.0, 0.0)
    assert planes["ceiling"].normal == (0.0, -1.0, 0.0)
    np.testing.assert_array_equal(planes["floor"].mask, labels == FLOOR)
    assert planes["floor"].scale_source == "room_height"
    assert planes["floor"].offset == pytest.approx(-1.4, abs=0.03)
    assert planes["ceiling"].offset == pytest.approx(-1.1, abs=0.03)


@pytest.mark.parametrize("extent", [(4.0, 4.6), (4.6, 4.0)])
def test_opposite_walls_give_the_scale_where_the_plan_tells_their_distance(extent):
    labels, _, camera = box_view(0.0, 12.0, np.array([0.2, 1.2, -1.2]), fov_deg=95.0)
    labels[labels == CEILING] = OTHER
    floor = split_planes(labels, camera, camera_height_m=1.5, room_extent_m=extent)[0]
    assert floor.scale_source == "room_extent"
    assert floor.camera_height_m == pytest.approx(1.2, rel=0.05)
    # The prior already fits a room of 1.25 times the size: nothing to correct.
    larger = (1.25 * extent[0], 1.25 * extent[1])
    floor = split_planes(labels, camera, camera_height_m=1.5, room_extent_m=larger)[0]
    assert floor.camera_height_m == pytest.approx(1.5, rel=0.05)


def test_furniture_along_the_foot_hides_no_corner():
    labels, side, camera = box_view(25.0, 5.0, np.array([0.2, 1.5, -0.9]))
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    clutter = (y > 230) & (y < 300) & (x > 120) & (x < 330)
    labels[clutter] = OTHER
    for plane in split_planes(labels, camera, room_height_m=2.5):
        if plane.surface == "wall":
            truth = (side == side_of(plane)) & ~clutter
            assert (truth & plane.mask).sum() / (truth | plane.mask).sum() > 0.9


def test_through_a_door_nothing_is_the_rooms():
    _, pose, labels, ends = open_door_view()
    camera = pose.camera.with_rotation(canonical(pose.camera.matrix))
    sizes = dict(room_height_m=HEIGHT, room_extent_m=(WIDE, DEEP))
    planes = split_planes(labels, camera, **sizes, camera_height_m=1.5)
    floor = next(plane for plane in planes if plane.surface == "floor")
    behind = ends[..., 0] > WIDE + 0.3
    assert (behind & (labels == 1)).sum() > 100 and (floor.mask & behind).sum() == 0
    own = (labels == 1) & (ends[..., 0] < WIDE)
    assert (floor.mask & own).sum() > 0.97 * own.sum()
