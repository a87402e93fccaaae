import numpy as np
import pytest
import shapely
from sample_houses import reception_and_bedroom

from plan2scene_workshop.rendering import plan_views
from plan2scene_workshop.rendering.furniture import furnish_room
from plan2scene_workshop.rendering.geometry import Geometry
from plan2scene_workshop.rendering.palette import draw_palette
from plan2scene_workshop.rendering.shell import wall_faces


def test_views_stand_in_the_room_and_keep_their_ranges():
    house = reception_and_bedroom()
    views = plan_views(house, ["a", "b"], 7, 3)
    assert len(views) == 7 and {view.room_id for view in views} == {"a", "b"}
    for view in views:
        polygon = shapely.Polygon(house.room(view.room_id).rings[0])
        stand = shapely.Point(view.position[0], view.position[2])
        assert polygon.contains(stand) and polygon.exterior.distance(stand) >= 0.3
        assert 1.2 <= view.position[1] <= 1.7 and 50 <= np.degrees(view.fov) <= 90
        assert abs(np.degrees(view.pitch)) <= 8 and abs(np.degrees(view.roll)) <= 2
        rotation = view.rotation()
        assert np.allclose(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert rotation[1, 1] < -0.9  # image down is world down
    assert plan_views(house, ["a", "b"], 7, 3) == views
    assert len({view.yaw for view in views}) == 7


@pytest.mark.parametrize("seed", range(2))
def test_furniture_stays_inside_and_clear_of_the_camera(seed):
    """Of a listing's room and (odd seeds) of a randomised one."""
    house = reception_and_bedroom()
    room = house.room("a")
    camera = shapely.Point(4.4, 0.6)
    rng = np.random.default_rng(seed)
    geometry = Geometry()
    faces = wall_faces(house, room)
    furnish_room(geometry, room, faces, draw_palette(rng), rng, [camera], random_room=seed % 2 == 1)
    vertices = np.concatenate([g.solid.vertices for g in geometry.joined().values()])
    inside = shapely.Polygon(room.rings[0])
    points = shapely.points(vertices[:, 0], vertices[:, 2])
    assert len(vertices) > 500 and shapely.contains(inside, points).all()
    assert vertices[:, 1].min() >= -1e-6 and vertices[:, 1].max() <= room.height
    tall = vertices[:, 1] > 0.05
    assert shapely.distance(points[tall & (vertices[:, 1] < 1.2)], camera).min() > 0.1
