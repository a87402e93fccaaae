import numpy as np
import pytest

from plan2scene.photos.labels.palette import OTHER
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.rendering.decor import draw_decor
from plan2scene_workshop.rendering.geometry import Geometry, quad
from plan2scene_workshop.rendering.quick import QuickTracer
from plan2scene_workshop.rendering.snapshots import shoot_room
from plan2scene_workshop.rendering.sources import Sources
from plan2scene_workshop.rendering.tracer import Finish, load_mitsuba
from plan2scene_workshop.rendering.views import View

pytest.importorskip("mitsuba", exc_type=ImportError)


@pytest.fixture(scope="module")
def mi():
    found = load_mitsuba()
    if found.variant().startswith("scalar"):
        pytest.skip("needs LLVM")
    return found


def _shoot(mi, seed):
    house = generate_house("tiny", seed)
    materials = assign_materials(house, seed, (), size_px=64)
    decor = draw_decor(Sources(), seed, randomised=True)
    room = max(house.rooms, key=lambda room: room.types == ("Reception",)).id
    shots = shoot_room(house, room, materials, {}, decor, 2, seed, long_side=64, mi=mi, amodal=True)
    return list(shots)


@pytest.fixture(scope="module")
def snapshots(mi):
    return _shoot(mi, 3)


def test_snapshots_are_reproducible_and_see_the_room(mi, snapshots):
    again = _shoot(mi, 3)
    assert len(snapshots) == 2
    for first, second in zip(snapshots, again, strict=True):
        assert first.camera == second.camera and np.array_equal(first.labels, second.labels)
        assert np.array_equal(first.image, second.image)
        assert max(first.labels.shape) == 64 and first.image.shape[:2] == first.labels.shape
        assert set(np.unique(first.labels)) <= set(range(6)) and len(np.unique(first.labels)) > 2
        assert first.image.std() > 5


def test_depth_normals_and_labels_agree_with_the_camera(snapshots):
    for shot in snapshots:
        camera, rotation = shot.camera, np.array(shot.camera["rotation"])
        rows, columns = np.mgrid[: camera["height"], : camera["width"]]
        depth = shot.depth / 1000.0
        ray = np.stack(
            [
                (columns - camera["cx"]) / camera["focal_px"],
                (rows - camera["cy"]) / camera["focal_px"],
                np.ones_like(depth),
            ],
            -1,
        )
        world = (ray * depth[..., None]) @ rotation + camera["position"]
        normal = (shot.normals / 255.0 * 2 - 1) @ rotation
        floor = shot.labels == 1
        assert floor.any() and np.abs(world[floor][:, 1]).max() < 0.01
        assert normal[floor][:, 1].min() > 0.98
        assert np.median(np.abs(normal[(shot.labels == 2)][:, 1])) < 0.02
        assert ((normal * (ray @ rotation)).sum(-1)[depth > 0] < 0.02).all()


def test_amodal_labels_tell_what_furniture_hides(snapshots):
    for shot in snapshots:
        seen = shot.labels != OTHER
        assert 0.1 < seen.mean() < 0.9 and shot.amodal is not None
        assert (shot.amodal == shot.labels)[seen].mean() > 0.99
        assert (shot.amodal != OTHER).mean() > 0.99


def test_textures_are_seen_the_right_way_up(mi):
    """A quad of one tile, red top left, blue bottom right, seen from the front."""
    tile = np.zeros((8, 8, 3), np.uint8)
    tile[:4, :4], tile[4:, 4:] = (200, 0, 0), (0, 0, 200)
    geometry = Geometry()
    geometry.add(
        "tile", quad(np.array([1, 2.0, 2]), np.array([-2.0, 0, 0]), np.array([0, -2.0, 0]))
    )
    tracer = QuickTracer(geometry, {"tile": Finish(tile, 2.0)}, mi)
    albedo = tracer.albedo(View("a", (0.0, 1.0, 0.0), 0.0, 0.0, 0.0, np.pi / 2, 0), (32, 32))
    corners = albedo[10, 10], albedo[10, 21], albedo[21, 10], albedo[21, 21]
    red = (200 / 255) ** 2.2
    assert corners[0] == pytest.approx([red, 0, 0], abs=0.02)
    assert corners[1] == pytest.approx([0, 0, 0], abs=0.02)
    assert corners[3] == pytest.approx([0, 0, red], abs=0.02)
