"""Baked light and pictures at eye level: windows and lamps light, cameras stand inside."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import Point

from plan2scene.house import Opening
from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.baking import bake_light, lamp_position
from plan2scene.mesh.rays import Rays, hemisphere
from plan2scene.mesh.renderer import sample
from plan2scene.mesh.room_views import SETTINGS, camera_in, render_rooms, standpoints
from plan2scene.plans.geometry import room_polygon

pytest.importorskip("embreex")


def light_of(house):
    colours = {key: np.full(3, 0.6) for key in house.surface_keys()}
    return bake_light(house, build_parts(house), colours, 0.25)


def at(light, part, point):
    uv = light.uv(part)
    known = np.column_stack([part.mesh.vertices, np.ones(len(part.mesh.vertices))])
    to_uv, *_ = np.linalg.lstsq(known, uv, rcond=None)
    u, v = np.array([*point, 1.0]) @ to_uv
    height, width = light.image.shape[:2]
    return light.image[int(v * height), int(u * width)]


@pytest.fixture
def windowed(gap_house):
    """Room a has a window opposite to its door, room b has none."""
    wall = next(wall for wall in gap_house.walls if wall.id == "a_w3")
    lit = replace(wall, openings=(Opening("w", "window", 1.0, 3.0, 0.8, 2.2),))
    walls = tuple(lit if other is wall else other for other in gap_house.walls)
    return replace(gap_house, walls=walls)


def test_a_window_lights_the_floor_before_it(windowed):
    light = light_of(windowed)
    parts = {part.name: part for part in build_parts(windowed)}
    floor = parts["a/floor"]
    assert at(light, floor, (0.8, 0, 2)).mean() > 1.15 * at(light, floor, (2.5, 0, 3.7)).mean()
    # The sky is bluer than the lamp.
    near, far = (at(light, floor, (x, 0, z)) for x, z in ((0.5, 2.0), (2.7, 3.7)))
    assert near[2] / near[0] > far[2] / far[0]
    assert light.rooms["a"].mean() > light.rooms["b"].mean()
    assert light.image.min() >= 0 and np.isfinite(light.image).all()
    np.testing.assert_array_equal(light_of(windowed).image, light.image)


def test_a_lamp_is_brightest_below_itself(gap_house):
    light = light_of(gap_house)
    parts = {part.name: part for part in build_parts(gap_house)}
    lamp = lamp_position(gap_house, "b")
    assert Point(lamp[0], lamp[2]).within(room_polygon(gap_house.room("b")))
    below = at(light, parts["b/floor"], (lamp[0], 0, lamp[2])).mean()
    assert below > 1.2 * at(light, parts["b/floor"], (3.3, 0, 0.2)).mean()


def test_light_runs_on_where_a_wall_of_one_plane_goes_on(storey_house):
    parts = {part.name: part for part in build_parts(storey_house)}
    colours = {key: np.full(3, 0.6) for key in storey_house.surface_keys()}
    light = bake_light(storey_house, list(parts.values()), colours, 0.25)
    before, behind = (  # the hall's wall along two rooms that meet at z = 3.4, nearest to its lamp
        sample([light.image], light.uv(part)[end], np.ones(len(end))).mean(axis=1)
        for part, end in (
            (part, np.flatnonzero(np.abs(part.mesh.vertices[:, 2] - 3.4) < 1e-3))
            for part in (parts["hall/wall/hall_wall_1"], parts["hall/wall/hall_wall_2"])
        )
    )
    assert before.max() > 0.5
    np.testing.assert_allclose(np.sort(before), np.sort(behind), rtol=0.08)


def test_rooms_drawn_a_little_into_each_other_have_no_dark_wall(gap_house):
    def moved(point):
        return (2.993, point[1]) if point[0] == 3.1 else point

    rooms = tuple(
        replace(room, rings=(tuple(map(moved, room.rings[0])),)) for room in gap_house.rooms
    )
    walls = tuple(
        replace(wall, start=moved(wall.start), end=moved(wall.end)) for wall in gap_house.walls
    )
    house = replace(gap_house, rooms=rooms, walls=walls)
    light = light_of(house)
    for name in ("a/wall/a_w1", "b/wall/b_w3"):
        chart = light.charts[name]
        place = (chart.row, chart.column)
        rows, columns = (slice(n, n + m) for n, m in zip(place, chart.size, strict=True))
        assert light.image[rows, columns].mean(axis=2).min() > 0.15


def test_lamps_hang_and_cameras_stand_inside_any_room(l_house, ring_house):
    for house in (l_house, ring_house):
        room = house.rooms[0]
        polygon = room_polygon(room)
        lamp = lamp_position(house, room.id)
        assert Point(lamp[0], lamp[2]).within(polygon)
        rays = Rays.of(build_parts(house))
        camera = camera_in(house, room.id, rays)
        assert camera.position[1] == SETTINGS.eye_m
        assert polygon.contains(Point(camera.position[0], camera.position[2]))
        for eye, _ in standpoints(polygon):
            assert polygon.exterior.distance(Point(*eye)) > 0.3


def test_a_picture_shows_the_surfaces_in_their_colours(gap_house, paint):
    textures = paint(gap_house)
    parts = build_parts(gap_house)
    sheet = render_rooms(gap_house, textures, parts)
    first = sheet[8 : 8 + SETTINGS.size[0], 8 : 8 + SETTINGS.size[1]].astype(int)
    assert sheet.dtype == np.uint8
    # Bright corners of the tiles are orange; nothing is black or burnt.
    orange = (first[..., 0] > first[..., 2] + 60).mean()
    assert 0.1 < orange < 0.5
    assert (first.max(axis=2) < 12).mean() < 0.01
    assert (first.min(axis=2) > 250).mean() < 0.01
    np.testing.assert_array_equal(render_rooms(gap_house, textures, parts), sheet)


def test_rooms_are_drawn_without_a_ray_tracer(gap_house, paint, monkeypatch):
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    first = render_rooms(gap_house, paint(gap_house), build_parts(gap_house))[8:288, 8:428]
    assert (first.max(axis=2) > 40).mean() > 0.95


def test_rays_lie_about_the_normal_as_dense_as_the_cosine():
    for normal in ([0, 1, 0], [0, -1, 0], [1, 0, 0], [0.6, 0, 0.8]):
        ways = hemisphere(np.array(normal, float), 256)
        np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 1)
        cosine = ways @ np.array(normal, float)
        assert cosine.min() > 0
        assert cosine.mean() == pytest.approx(2 / 3, abs=0.01)
