import numpy as np
import pytest
from views import camera_looking

from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.rectification import plane_axes, rectify
from plan2scene.photos.planes.walls import PLANES

SIZE = (300, 400)


def camera_of(heading_deg=0.0, pitch_deg=0.0, focal=360.0):
    return camera_looking(SIZE, heading_deg=heading_deg, pitch_deg=pitch_deg, focal=focal)


def gradient(camera, normal, offset):
    """A photo of a plane: red the plane's x, green its y (right, down) at 40 levels a metre."""
    plane = Plane("wall" if normal[1] == 0 else "floor", 0, normal, offset, np.ones(SIZE, bool), "")
    if normal[1] < 0:
        plane = Plane("ceiling", 0, normal, offset, plane.mask, "")
    rays = camera.rays_at(*np.indices(SIZE))
    towards = rays @ np.array(normal)
    seen = towards < -0.05
    reach = np.where(seen, offset / np.where(seen, towards, -1.0), 0.0)
    points = (rays * reach[..., None]) @ plane_axes(plane)[:2].T
    image = np.zeros((*SIZE, 3), np.uint8)
    image[..., :2] = np.clip(128 + 20 * points, 0, 255)
    return image, Plane(plane.surface, 0, normal, offset, seen, "")


CASES = [
    ((0.0, 0.0, -1.0), -2.5, 15.0, 5.0),
    ((-1.0, 0.0, 0.0), -2.0, 40.0, 5.0),
    ((1.0, 0.0, 0.0), -2.0, -40.0, 0.0),
    ((0.0, 1.0, 0.0), -1.5, 20.0, 25.0),
    ((0.0, -1.0, 0.0), -1.1, 20.0, -25.0),
]


@pytest.mark.parametrize(("normal", "offset", "heading", "pitch"), CASES)
def test_rectified_pixels_lie_where_the_plane_says(normal, offset, heading, pitch):
    # `heading` turns the camera so that world +x comes into view for positive angles.
    camera = camera_of(-heading, pitch)
    image, plane = gradient(camera, normal, offset)
    rectified = rectify(image, camera, plane, min_density=40.0)
    rows, columns = np.nonzero(rectified.mask)
    step = rectified.metres_per_pixel
    x = rectified.origin[0] + (columns + 0.5) * step
    y = rectified.origin[1] + (rows + 0.5) * step
    value = rectified.image[rows, columns].astype(float)
    inside = (np.abs(x) < 6) & (np.abs(y) < 6)
    assert inside.sum() > 1000
    np.testing.assert_allclose(value[inside, 0], 128 + 20 * x[inside], atol=2.5)
    np.testing.assert_allclose(value[inside, 1], 128 + 20 * y[inside], atol=2.5)


def test_flat_and_far_parts_and_skirting_are_cut_away():
    camera = camera_of(0.0, 10.0)
    image, plane = gradient(camera, (0.0, 1.0, 0.0), -1.5)
    rectified = rectify(image, camera, plane)
    rows, _ = np.nonzero(rectified.mask)
    far = rectified.origin[1] + (rows.max() + 1) * rectified.metres_per_pixel
    assert far < 1.5 / np.tan(np.radians(15.0)) + 0.05
    dense = rectify(image, camera, plane, min_density=70.0)
    rows, _ = np.nonzero(dense.mask)
    assert dense.origin[1] + rows.max() * dense.metres_per_pixel < far - 0.5
    assert rectify(image, camera, plane, min_density=1e5) is None
    assert max(rectified.mask.shape) <= PLANES.max_side_px + 1
    camera = camera_of()
    wall = Plane("wall", 0, (0.0, 0.0, -1.0), -4.0, np.ones(SIZE, bool), "", camera_height_m=1.2)
    rectified = rectify(np.zeros((*SIZE, 3), np.uint8), camera, wall)
    rows, _ = np.nonzero(rectified.mask)
    lowest = rectified.origin[1] + (rows.max() + 1) * rectified.metres_per_pixel
    assert lowest == pytest.approx(1.2 - 0.12, abs=0.03)
