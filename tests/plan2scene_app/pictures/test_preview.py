"""The renderer against formulas, and previews of small houses."""

import numpy as np
import pytest

from plan2scene.camera import Camera
from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.parts import PartBuilder
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.pictures.preview import render_preview
from plan2scene_app.pictures.renderer import Triangles


def square(y, colour):
    builder = PartBuilder()
    corners = np.array([[0, y, 0], [0, y, 1], [1, y, 1], [1, y, 0]], dtype=float)
    builder.quad(corners, colour)
    return builder.build(f"square {y}")


def test_a_floor_that_runs_on_behind_the_camera_is_drawn_before_it():
    floor = PartBuilder()
    floor.quad(np.array([[-50, 0, -50], [-50, 0, 50], [50, 0, 50], [50, 0, -50]], float), (9, 9, 9))
    triangles = Triangles.of([floor.build("floor")], {})
    camera = Camera.look_at(np.array([0, 1.5, 0]), np.array([0, 1.5, 5.0]), 40.0, (61, 80))
    shown = triangles.visible(camera, np.ones(2, dtype=bool))
    rows = shown.pixels // 80
    assert np.unique(rows) == pytest.approx(np.arange(32, 61))  # below the horizon, row 30
    np.testing.assert_allclose(shown.depth, 1.5 * 40.0 / (rows - 30.0), rtol=1e-4)


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
