import numpy as np

from plan2scene.images import write_png
from plan2scene.mesh.assembly import assemble
from plan2scene.photos.locate.pose import Pose
from plan2scene_app.pictures.lit_picture import painter_of
from plan2scene_app.pictures.photo_views import SIZE, photo_view, render_photo_views
from plan2scene_app.pictures.renderer import look_at


def test_a_located_photo_stands_beside_the_house_from_its_place(gap_house, paint, tmp_path):
    write_png(tmp_path / "seen.png", np.full((480, 640, 3), (10, 200, 30), np.uint8))
    camera = look_at(np.zeros(3), np.array([1.0, 0, 0]), 400.0, (480, 640))
    pose = Pose("a", (1.0, 1.5, 2.0), camera, 0.9)
    view = photo_view(gap_house, pose)
    assert (view.height, view.width) == SIZE and view.position == (1.0, 1.5, 2.0)
    assert np.isclose(view.focal_px / view.width, camera.focal_px / camera.width)
    painter = painter_of(gap_house, paint(gap_house), assemble(gap_house).parts)
    photos = {name: tmp_path / name for name in ("seen.png", "unplaced.png")}
    sheet = render_photo_views(gap_house, photos, {"seen.png": pose}, painter)
    photo, house = sheet[8:233, 8:308], sheet[8:233, 308:608]
    assert (photo == (10, 200, 30)).all()
    np.testing.assert_array_equal(house, painter(view))
    write_png(photos["unplaced.png"], house)
    sheets = [
        render_photo_views(gap_house, photos, dict.fromkeys(photos, pose), painter, threads)
        for threads in (1, 2)
    ]
    np.testing.assert_array_equal(*sheets)
    assert render_photo_views(gap_house, photos, {}, painter).min() < 100  # says so
