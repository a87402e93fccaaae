import numpy as np
import pytest
from model_folder import model_folder
from sample_houses import reception_and_bedroom

from plan2scene.house import SurfaceKey
from plan2scene.materials import Material
from plan2scene_workshop.rendering import plan_views, render_house
from plan2scene_workshop.rendering.decor import listing_decor
from plan2scene_workshop.rendering.furniture import CAMERA_CLEARANCE
from plan2scene_workshop.rendering.models import read_model_index
from plan2scene_workshop.rendering.scene import build_room_scene
from plan2scene_workshop.rendering.sources import Sources
from plan2scene_workshop.rendering.tracer import Tracer, load_mitsuba

pytest.importorskip("mitsuba", exc_type=ImportError)

#: Works wherever Mitsuba is installed, and compiles nothing.
VARIANT = "scalar_rgb"
SIZE = (27, 36)


def _material(name, colour, size=1.0):
    return Material(name, "plaster", "paint", np.full((16, 16, 3), colour, np.uint8), size, 1.0)


def _materials():
    colours = {"floor": (150, 90, 50), "wall": (200, 200, 190), "ceiling": (235, 235, 235)}
    return {
        SurfaceKey(room, surface): _material(surface, colour)
        for room in ("a", "b")
        for surface, colour in colours.items()
    }


@pytest.fixture(scope="module")
def photos():
    house = reception_and_bedroom()
    return list(_render(house, plan_views(house, ["a", "b"], 3, 11)))


def _render(house, views, decor=None):
    size = {"height": SIZE[0], "width": SIZE[1], "samples_per_pixel": 4}
    photos = render_house(house, _materials(), {}, views, 5, **size, variant=VARIANT, decor=decor)
    return iter(photos)


def test_photos_are_bright_and_see_every_surface(photos):
    seen: set[int] = set()
    for photo in photos:
        assert photo.image.shape == (*SIZE, 3) and photo.image.dtype == np.uint8
        assert 60 < photo.image.mean() < 230
        seen |= set(np.unique(photo.labels))
        floor = photo.image[photo.labels == 1].astype(float).mean(0)
        if (photo.labels == 1).sum() > 20:
            assert floor[0] > floor[1] > floor[2]  # the brown floor stays brown
    assert seen == {0, 1, 2, 3}


def test_unprojected_pixels_lie_on_their_planes():
    house = reception_and_bedroom()
    view = plan_views(house, ["a"], 1, 11)[0]
    scene = build_room_scene(house, "a", _materials(), {}, [view], 5)
    truth = Tracer(scene.geometry, scene.finishes, load_mitsuba(VARIANT)).truth(view, SIZE)
    offset = np.array([p.offset for p in scene.planes])
    normal = np.array([p.normal for p in scene.planes])
    known = truth.planes != 255
    assert known.mean() > 0.3
    points, index = truth.position[known], truth.planes[known]
    assert np.abs((points * normal[index]).sum(1) - offset[index]).max() < 0.02
    rotation = view.rotation()
    focal = SIZE[1] / 2 / np.tan(view.fov / 2)
    camera = (truth.position[known] - view.position) @ rotation.T
    pixel = camera[:, :2] / camera[:, 2:] * focal + [(SIZE[1] - 1) / 2, (SIZE[0] - 1) / 2]
    rows, columns = np.nonzero(known)
    assert np.abs(pixel - np.stack([columns, rows], 1)).max() < 0.01


def test_same_seed_same_bytes(photos):
    house = reception_and_bedroom()
    photo, again = photos[0], next(_render(house, [photo.view for photo in photos]))
    assert (again.image == photo.image).all()
    assert (again.labels == photo.labels).all() and again.camera == photo.camera


def test_models_furnish_listings_and_keep_clear_of_cameras(tmp_path):
    house = reception_and_bedroom()
    decor = listing_decor(Sources(models=read_model_index(model_folder(tmp_path), train=True)), 3)
    views = plan_views(house, ["a"], 3, 11)
    scene = build_room_scene(house, "a", _materials(), {}, views, 5, decor=decor)
    things = scene.geometry.joined()["model"].solid.vertices
    assert len(things) >= 8 and scene.finishes["model"].two_sided
    for view in views:
        away = np.hypot(things[:, 0] - view.position[0], things[:, 2] - view.position[2])
        assert away.min() > CAMERA_CLEARANCE[0] - 0.05
    (photo,) = _render(house, views[:1], decor=decor)
    assert photo.image.mean() > 40
