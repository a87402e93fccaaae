import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.pictures.preview import render_preview


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
    np.testing.assert_array_equal(picture, render_preview(gap_house, textures, side=300))
