"""The rasteriser against formulas, and previews of small houses."""

import numpy as np
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh import TileTexture
from plan2scene.mesh.parts import PartBuilder
from plan2scene.mesh.preview import render_preview
from plan2scene.mesh.raster import attributes, look_at, mipmaps, sample, soup_of, visible


def square(y, colour):
    builder = PartBuilder()
    corners = np.array([[0, y, 0], [0, y, 1], [1, y, 1], [1, y, 0]], dtype=float)
    builder.quad(corners, colour)
    return builder.build(f"square {y}")


def test_straight_down_shows_plan_with_x_right_and_z_down():
    camera = look_at(np.array([0, 9.0, 0]), np.zeros(3), 10.0, (101, 101), perspective=False)
    x, y, depth = camera.project(np.array([2.0, 1.0, 3.0]))
    assert (x, y, depth) == pytest.approx((70.0, 80.0, 8.0))


def test_nearest_triangle_wins_and_back_faces_are_culled():
    soup = soup_of([square(0.0, (255, 0, 0)), square(1.0, (0, 255, 0))], {})
    keep = np.ones(4, dtype=bool)
    eye, target = np.array([0.5, 5.0, 0.5]), np.array([0.5, 0.0, 0.5])
    camera = look_at(eye, target, 50.0, (60, 60), perspective=False)
    ids, depth = visible(soup, camera, keep)
    assert set(np.unique(ids)) == {-1, 2, 3}
    assert (ids >= 0).sum() == pytest.approx(50 * 50, rel=0.05)
    assert depth[30, 30] == pytest.approx(4.0)
    below = look_at(-eye, target - [1, 0, 1], 50.0, (60, 60), perspective=False)
    assert (visible(soup, below, keep)[0] == -1).all()


@pytest.mark.parametrize("perspective", [False, True])
def test_points_of_pixels_project_back(perspective):
    soup = soup_of([square(0.3, (255, 0, 0))], {})
    eye = np.array([1.4, 3.0, 2.0])
    camera = look_at(eye, np.array([0.5, 0.3, 0.5]), 90.0, (80, 90), perspective=perspective)
    ids, _ = visible(soup, camera, np.ones(2, dtype=bool))
    pixels, _, points, _ = attributes(soup, camera, ids)
    rows, columns = np.divmod(pixels, 90)
    assert len(pixels) > 100
    np.testing.assert_allclose(points[:, 1], 0.3, atol=1e-4)
    projected = camera.project(points.astype(np.float64))
    np.testing.assert_allclose(projected[:, 0], columns, atol=0.02)
    np.testing.assert_allclose(projected[:, 1], rows, atol=0.02)


def test_sampling_repeats_and_blurs_with_distance():
    image = np.zeros((8, 8, 3), dtype=np.uint8)
    image[:, :4] = 255
    levels = mipmaps(image)
    uv = np.array([[0.25, 0.5], [1.25, -3.5], [0.75, 0.1], [-0.25, 0.1]])
    near = sample(levels, uv, np.full(4, 1.0))
    np.testing.assert_allclose(near[:, 0], [1, 1, 0, 0], atol=1e-3)
    far = sample(levels, uv, np.full(4, 1e6))
    np.testing.assert_allclose(far, 0.5, atol=1e-3)


def test_preview_shows_each_floor_where_it_is(gap_house, paint):
    textures = paint(gap_house)
    for room_id, colour in (("a", (20, 160, 40)), ("b", (170, 30, 30))):
        image = np.full((8, 8, 3), colour, dtype=np.uint8)
        textures[SurfaceKey(room_id, "floor")] = TileTexture(png_bytes(image), 1.0)
    picture = render_preview(gap_house, textures, side=300)
    assert picture.shape == (300, 600, 3)
    plan = picture[:, :300].astype(int)
    left, right = plan[95:120, 50:110], plan[95:120, 190:250]
    assert (left[..., 1] > left[..., 0] + 40).mean() > 0.95  # room a, green
    assert (right[..., 0] > right[..., 1] + 40).mean() > 0.95  # room b, red
    oblique = picture[:, 300:].astype(int)
    assert (oblique[..., 1] > oblique[..., 0] + 30).sum() > 500
    assert (oblique[..., 0] > oblique[..., 1] + 30).sum() > 500
    again = render_preview(gap_house, textures, side=300)
    np.testing.assert_array_equal(picture, again)
