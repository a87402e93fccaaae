"""Shell, furniture, views and development: everything that needs no Mitsuba."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from plan2scene.errors import InputError
from plan2scene.house import Door, House, Opening, Room, Wall
from plan2scene.photos.labels.palette import FLOOR, WALL
from plan2scene_workshop.rendering import plan_views, randomised
from plan2scene_workshop.rendering.furniture import ALONG_WALLS, STANDING_FREE, furnish_room
from plan2scene_workshop.rendering.geometry import Geometry
from plan2scene_workshop.rendering.palette import draw_palette
from plan2scene_workshop.rendering.shell import (
    SKIRTING_DEPTH,
    add_room_shell,
    room_planes,
    wall_faces,
)

HEIGHT = 2.6


def two_rooms() -> House:
    """Return an L-shaped reception and a bedroom that share a wall with a door."""
    door = Opening("door", "door", 0.8, 1.65, 0.0, 2.05)
    window = Opening("window", "window", 1.0, 2.6, 0.9, 2.2)
    ring = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (2.0, 4.0), (2.0, 3.0), (0.0, 3.0))
    a = Room("a", ("Reception",), (ring,), HEIGHT)
    b = Room("b", ("Bedroom",), (((5.0, 0.0), (9.0, 0.0), (9.0, 4.0), (5.0, 4.0)),), HEIGHT)
    walls = [
        Wall("w0", ("a",), ring[0], ring[1], HEIGHT, openings=(window,)),
        Wall("w1", ("a", "b"), ring[1], ring[2], HEIGHT, openings=(door,)),
    ]
    for i in range(2, 6):
        walls.append(Wall(f"w{i}", ("a",), ring[i], ring[(i + 1) % 6], HEIGHT))
    corners = [(5.0, 0.0), (9.0, 0.0), (9.0, 4.0), (5.0, 4.0)]
    for i in range(3):
        walls.append(Wall(f"v{i}", ("b",), corners[i + 1], corners[i], HEIGHT))
    return House("two", (a, b), tuple(walls), (Door("a", "door", "b"),))


def _area(solid_vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (solid_vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_faces_follow_the_inset_room_and_cut_openings() -> None:
    house = two_rooms()
    room = house.room("a")
    faces = wall_faces(house, room)
    inset = shapely.Polygon(room.rings[0]).buffer(-0.05, join_style="mitre")
    assert sum(face.length for face in faces) == pytest.approx(inset.length, abs=1e-6)
    assert {face.wall.id for face in faces if face.outer} == {"w0", "w2", "w3", "w4", "w5"}
    geometry = Geometry()
    add_room_shell(geometry, room, faces, 0, {}, (0.9, 0.9, 0.9))
    joined = geometry.joined()["a/wall"]
    on_plane = joined.planes != 255
    area = _area(joined.solid.vertices, joined.solid.faces[on_plane])
    assert area == pytest.approx(inset.length * HEIGHT - 0.85 * 2.05 - 1.6 * 1.3, rel=1e-6)
    floor = geometry.joined()["a/floor"]
    assert _area(floor.solid.vertices, floor.solid.faces) == pytest.approx(18.0)
    assert set(floor.labels) == {FLOOR} and set(joined.labels) == {WALL}


def test_shell_vertices_lie_on_their_planes_and_face_the_room() -> None:
    house = two_rooms()
    for room in house.rooms:
        faces = wall_faces(house, room)
        planes = room_planes(room, faces)
        geometry = Geometry()
        add_room_shell(geometry, room, faces, 0, {}, (0.9, 0.9, 0.9))
        centre = np.array([room.rings[0][0][0] + 2.5, 1.3, 1.5])
        for group in geometry.joined().values():
            solid = group.solid
            for index in set(group.planes) - {255}:
                plane = planes[index]
                used = solid.faces[group.planes == index]
                points = solid.vertices[np.unique(used)]
                assert np.abs(points @ plane.normal - plane.offset).max() < 1e-9
                assert centre @ np.array(plane.normal) > plane.offset
                a, b, c = (solid.vertices[used[:, k]] for k in range(3))
                assert (np.cross(b - a, c - a) @ plane.normal > 0).all()


def test_views_stand_in_the_room_and_keep_their_ranges() -> None:
    house = two_rooms()
    views = plan_views(house, ["a", "b"], 7, 3)
    assert len(views) == 7 and {view.room_id for view in views} == {"a", "b"}
    for view in views:
        polygon = shapely.Polygon(house.room(view.room_id).rings[0])
        stand = shapely.Point(view.position[0], view.position[2])
        assert polygon.contains(stand) and polygon.exterior.distance(stand) >= 0.3
        assert 1.2 <= view.position[1] <= 1.7
        assert 50 <= np.degrees(view.fov) <= 90
        assert abs(np.degrees(view.pitch)) <= 8 and abs(np.degrees(view.roll)) <= 2
        rotation = view.rotation()
        assert np.allclose(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert rotation[1, 1] < -0.9  # image down is world down
    assert plan_views(house, ["a", "b"], 7, 3) == views
    assert len({view.yaw for view in views}) == 7


def test_unknown_room_is_refused() -> None:
    with pytest.raises(InputError, match=r"house two, room z.*expected a room"):
        plan_views(two_rooms(), ["z"], 1, 0)


@pytest.mark.parametrize("seed", range(4))
def test_furniture_stays_inside_and_clear_of_the_camera(seed: int) -> None:
    """Of a listing's room and (odd seeds) of a randomised one."""
    house = two_rooms()
    room = house.room("a")
    camera = shapely.Point(4.4, 0.6)
    rng = np.random.default_rng(seed)
    geometry = Geometry()
    faces = wall_faces(house, room)
    furnish_room(
        geometry, room, faces, draw_palette(rng), rng, [camera], random_room=bool(seed % 2)
    )
    vertices = np.concatenate([g.solid.vertices for g in geometry.joined().values()])
    inside = shapely.Polygon(room.rings[0])
    points = shapely.points(vertices[:, 0], vertices[:, 2])
    assert len(vertices) > 500
    assert shapely.contains(inside, points).all()
    assert vertices[:, 1].min() >= -1e-6 and vertices[:, 1].max() <= HEIGHT
    tall = vertices[:, 1] > 0.05
    on_floor = vertices[:, 1] < 1.2
    assert shapely.distance(points[tall & on_floor], camera).min() > 0.1
    assert SKIRTING_DEPTH < 0.02


def test_every_piece_fits_its_own_footprint() -> None:
    makers = {m for table in (ALONG_WALLS, STANDING_FREE) for row in table.values() for m, _ in row}
    makers |= {m for m, _ in (*randomised.ALONG_WALLS, *randomised.STANDING_FREE)}
    rng = np.random.default_rng(1)
    palette = draw_palette(rng)
    for maker in sorted(makers, key=lambda m: m.__name__):
        for _ in range(5):
            piece = maker(rng, palette)
            points = np.concatenate([solid.vertices for _, solid, _ in piece.parts])
            assert np.abs(points[:, 0]).max() <= piece.width / 2 + 0.08, maker.__name__
            assert points[:, 2].min() >= -0.08 and points[:, 2].max() <= piece.depth + 0.15
            assert points[:, 1].min() >= -1e-6
