"""Photos of a house of two levels: a room's own level alone is looked through and drawn."""

import numpy as np
import pytest

from plan2scene.camera import Camera
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.pose import Pose, pose_to_json
from plan2scene_app.contact_sheet.panels import OWN_ROOM, plan_panel
from plan2scene_app.viewer.viewer_page import _camera


@pytest.fixture(scope="module")
def house(storey_house):
    return storey_house


def pose(room):
    camera = Camera(64, 48, 60.0, 31.5, 23.5, np.eye(3), "exif", 1.0, fallback=False)
    return Pose(room, (5.0, 1.5, 1.0), camera, 0.9)


def test_a_sheet_draws_the_level_of_the_photo(house):
    shapes = room_shapes(house)
    low, high = (plan_panel(shapes, pose(room), (120, 160)) for room in ("kitchen", "study"))
    assert (low == OWN_ROOM).all(axis=-1).sum() > 100
    assert not np.array_equal(low, high)
    unknown = plan_panel(shapes, None, (120, 160))
    ground = plan_panel({k: s for k, s in shapes.items() if s.level == "ground"}, None, (120, 160))
    assert np.array_equal(unknown, ground)


def test_the_viewer_has_cameras_at_their_level(house):
    for room, y in (("living", 1.5), ("bedroom", 4.3)):
        entry = pose_to_json(pose(room).camera, pose(room))
        assert _camera(entry, house)["position"] == pytest.approx([5.0, y, 1.0])
