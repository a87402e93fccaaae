import io
import sys
from dataclasses import replace

import numpy as np
import pytest
from glb_file import chunks
from PIL import Image
from sample_houses import one_room, parts_of
from shapely.geometry import Point

from plan2scene.house import Door, Opening, SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.baking import lamp_position
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene_app.pictures.baked_light import bake_light, mean_colours
from plan2scene_app.pictures.lit_house import SETTINGS as LIT
from plan2scene_app.pictures.lit_house import lit_part, lit_textures
from plan2scene_app.pictures.lit_picture import painter_of
from plan2scene_app.pictures.renderer import sample
from plan2scene_app.pictures.room_views import SETTINGS, camera_in, render_rooms, standpoints

pytest.importorskip("embreex")


def wall_light(light):
    _, values, owner = light.walls
    return {room: values[owner == room].mean() for room in np.unique(owner)}


def light_of(house):
    colours = {key: np.full(3, 0.6) for key in house.surface_keys()}
    return bake_light(house, assemble(house).parts, colours, 0.25)


def texels(light, name):
    chart = light.charts[name]
    (rows, columns), (row, column) = chart.size, (chart.row, chart.column)
    return light.image[row : row + rows, column : column + columns]


def view_in(house):
    return camera_in(house, house.rooms[0].id, Rays.of(assemble(house).parts))


def at(light, part, point):
    uv = light.uv(part)
    known = np.column_stack([part.mesh.vertices, np.ones(len(part.mesh.vertices))])
    to_uv, *_ = np.linalg.lstsq(known, uv, rcond=None)
    u, v = np.array([*point, 1.0]) @ to_uv
    height, width = light.image.shape[:2]
    return light.image[int(v * height), int(u * width)]


@pytest.fixture
def windowed(gap_house):
    window = (Opening("w", "window", 1.0, 3.0, 0.8, 2.2),)
    walls = (replace(w, openings=window) if w.id == "a_w3" else w for w in gap_house.walls)
    return replace(gap_house, walls=tuple(walls))


def test_a_window_lights_the_floor_before_it(windowed):
    light = light_of(windowed)
    floor = parts_of(windowed)["a/floor"]
    assert at(light, floor, (0.8, 0, 2)).mean() > 1.15 * at(light, floor, (2.5, 0, 3.7)).mean()
    near, far = (at(light, floor, (x, 0, z)) for x, z in ((0.5, 2.0), (2.7, 3.7)))
    assert near[2] / near[0] > far[2] / far[0]
    means = wall_light(light)
    assert means["a"] > means["b"]
    assert light.image.min() >= 0 and np.isfinite(light.image).all()
    np.testing.assert_array_equal(light_of(windowed).image, light.image)


def test_floors_are_as_bright_as_photos_show_them_beside_walls():
    # The lamp of a hall of 8 by 8 m lights the floor much more than its walls.
    light = light_of(one_room("Reception", 8.0, 8.0))
    shown = {}
    for name, chart in light.charts.items():
        shown.setdefault(chart.part.extras["kind"], []).append(texels(light, name).reshape(-1, 3))
    floor, wall = (np.concatenate(shown[kind]).mean() for kind in ("floor", "wall"))
    assert floor == pytest.approx(1.1 * wall, rel=0.03)


def test_a_small_window_throws_no_pictures_of_itself_on_far_walls():
    """Directions that all texels share would show it in some of them alone."""
    window = Opening("w", "window", 5.5, 6.5, 1.0, 2.0)
    light = light_of(one_room("Reception", 12.0, 9.0, {0: [window]}))
    there = texels(light, "room/wall/room_w2").mean(axis=(0, 2))  # opposite to it, as the lamp
    np.testing.assert_allclose(there, there[::-1], rtol=0.2)


def test_what_has_no_texels_has_the_light_of_walls_near_it(windowed):
    light = light_of(windowed)
    parts = parts_of(windowed)
    door = parts["a/door/ha"]
    upright, x = np.abs(door.mesh.vertex_normals[:, 1]) < 0.1, door.mesh.vertices[:, 0]
    plain = light.of_plain(door)
    leaf = upright & (x < 2.8)  # wide open, so that the wall by its hinge is near
    beside = [at(light, parts["a/wall/a_w1"], (3.0, y, 0.8)) for y in door.mesh.vertices[leaf, 1]]
    np.testing.assert_allclose(plain[leaf].mean(axis=0), np.mean(beside, axis=0), rtol=0.25)
    away = at(light, parts["a/wall/a_w1"], (3.0, 2.3, 2.3))
    assert np.abs(plain[leaf].mean(axis=0) / away - 1).min() > 0.25
    boards = parts["a/skirting"]
    top = boards.mesh.vertex_normals[:, 1] > 0.9
    front, above = (light.of_plain(boards)[which].mean() for which in (~top, top))
    assert above == pytest.approx(front, rel=0.07)  # else a line of bright dots in pictures


def test_light_runs_on_where_a_wall_of_one_plane_goes_on(storey_house):
    parts = parts_of(storey_house)
    light = light_of(storey_house)
    ends = []  # the hall's wall along two rooms that meet at z = 3.4, nearest to its lamp
    for part in (parts["hall/wall/hall_wall_1"], parts["hall/wall/hall_wall_2"]):
        uv = light.uv(part)[np.abs(part.mesh.vertices[:, 2] - 3.4) < 1e-3]
        ends.append(sample([light.image], uv, np.ones(len(uv))).mean(axis=1))
    before, behind = ends
    assert before.max() > 0.5
    np.testing.assert_allclose(np.sort(before), np.sort(behind), rtol=0.08)


def test_rooms_drawn_a_little_into_each_other_have_no_dark_wall(gap_house):
    def moved(point):
        return (2.993, point[1]) if point[0] == 3.1 else point

    rooms = (replace(r, rings=(tuple(map(moved, r.rings[0])),)) for r in gap_house.rooms)
    walls = (replace(w, start=moved(w.start), end=moved(w.end)) for w in gap_house.walls)
    light = light_of(replace(gap_house, rooms=tuple(rooms), walls=tuple(walls)))
    for name in ("a/wall/a_w1", "b/wall/b_w3"):
        assert texels(light, name).mean(axis=2).min() > 0.15


def test_lamps_hang_and_cameras_stand_inside_any_room(l_house, ring_house):
    for house in (l_house, ring_house):
        room = house.rooms[0]
        polygon = room_polygon(room)
        lamp = lamp_position(house, room.id)
        assert Point(lamp[0], lamp[2]).within(polygon)
        camera = camera_in(house, room.id, Rays.of(assemble(house).parts))
        assert camera.position[1] == SETTINGS.eye_m
        assert polygon.contains(Point(camera.position[0], camera.position[2]))
        for eye, _ in standpoints(polygon):
            assert polygon.exterior.distance(Point(*eye)) > 0.3


@pytest.mark.parametrize(("size", "down"), [((1.5, 1.7), 0.67), ((6.0, 5.0), 0.21)])
def test_the_smaller_a_room_the_more_one_looks_at_its_floor(size, down):
    """In a bath of 2.5 square metres a flatter picture has walls alone."""
    bath = one_room("Bathroom", *size, {0: [Opening("way", "door", 0.3, 1.1, 0.0, 2.1)]})
    camera = view_in(replace(bath, doors=(Door("room", "way", None),)))
    assert -camera.matrix[2][1] == pytest.approx(down, abs=0.02)


@pytest.mark.parametrize("opening", ["window", "door"])
@pytest.mark.parametrize("wall", range(4))
def test_the_picture_of_a_room_shows_its_window_or_wide_door(wall, opening):
    pane = Opening("pane", opening, 0.9, 2.3, 0.9 * (opening == "window"), 2.1)
    house = one_room("Bedroom", 4.0, 3.5, {wall: [pane]})
    camera = view_in(house)
    (holed,) = (w for w in house.walls if w.openings)
    x, z = np.add(holed.start, 1.6 / holed.length * np.subtract(holed.end, holed.start))
    right, down, ahead = camera.matrix @ (np.array([x, 1.5, z]) - camera.position)
    assert ahead > 0 and abs(right) * camera.focal_px < camera.cx * ahead
    assert abs(down) * camera.focal_px < camera.cy * ahead


def test_windows_are_not_looked_at_from_beside_their_wall():
    panes = [Opening(f"w{k}", "window", 6.3 + 0.6 * k, 6.8 + 0.6 * k, 0.9, 2.1) for k in range(4)]
    camera = view_in(one_room("Reception", 9.0, 4.0, {0: panes}))
    assert camera.position[2] > 2.0  # they are at z = 0


def drawn(house, textures, parts):
    return render_rooms(house, Rays.of(parts), painter_of(house, textures, parts))


def test_a_picture_shows_the_surfaces_in_their_colours(gap_house, paint):
    textures = paint(gap_house)
    parts = assemble(gap_house).parts
    sheet = drawn(gap_house, textures, parts)
    first = sheet[8 : 8 + SETTINGS.size[0], 8 : 8 + SETTINGS.size[1]].astype(int)
    assert sheet.dtype == np.uint8
    # Bright corners of the tiles are orange; nothing is black or burnt.
    assert 0.1 < (first[..., 0] > first[..., 2] + 60).mean() < 0.5
    assert (first.max(axis=2) < 12).mean() < 0.01 and (first.min(axis=2) > 250).mean() < 0.01
    np.testing.assert_array_equal(drawn(gap_house, textures, parts), sheet)


def grey_tiles(house):
    tile = TileTexture(png_bytes(np.full((16, 16, 3), 150, np.uint8)), 0.7, True, "plaster", "t")
    return dict.fromkeys(house.surface_keys(), tile)


def test_a_bright_part_of_a_dim_picture_is_not_burnt(gap_house):
    textures, parts = grey_tiles(gap_house), assemble(gap_house).parts
    light = bake_light(gap_house, parts, mean_colours(textures), 0.25)
    dim = replace(light, image=np.full_like(light.image, 0.3))
    for name in ("a/floor", "b/floor"):
        texels(dim, name)[:] = 2.4
    painter = painter_of(gap_house, textures, parts, light=dim)
    first = render_rooms(gap_house, Rays.of(parts), painter)[8:288, 8:428]
    assert np.median(first) > 60 and np.quantile(first, 0.98) < 240


def test_rooms_are_drawn_without_a_ray_tracer(gap_house, paint, monkeypatch):
    monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)
    first = drawn(gap_house, paint(gap_house), assemble(gap_house).parts)[8:288, 8:428]
    assert (first.max(axis=2) > 40).mean() > 0.95


def test_a_surface_is_dark_in_its_corners_and_bright_below_the_lamp(gap_house):
    textures, parts = grey_tiles(gap_house), assemble(gap_house).parts
    light = bake_light(gap_house, parts, mean_colours(textures), 0.2)
    lit = lit_textures(gap_house, parts, textures, light)
    floor = lit[SurfaceKey("b", "floor")]
    image = np.asarray(Image.open(io.BytesIO(floor.image)).convert("L")).astype(float)
    assert image.shape[1] == pytest.approx(LIT.px_per_m * floor.extent_m[0], abs=1)
    part = next(part for part in parts if part.name == "b/floor")
    turns = floor.turns(part.uv)
    assert turns.min() > 0 and turns.max() < 1
    x, z = (floor.turns(np.array(point)) for point in ((4.55, 2.0), (3.15, 0.05)))
    middle, corner = (image[int(v * image.shape[0]), int(u * image.shape[1])] for u, v in (x, z))
    assert middle > corner + 20
    for texture in lit.values():
        values = np.asarray(Image.open(io.BytesIO(texture.image)))
        assert values.max() < 252 and np.median(values) > 40


def test_every_storey_has_light_of_its_own(storey_house, paint, tmp_path):
    parts, textures = assemble(storey_house).parts, paint(storey_house)
    light = bake_light(storey_house, parts, mean_colours(textures), 0.7)
    means = wall_light(light)
    assert set(means) == {room.id for room in storey_house.rooms}
    assert all(0.3 < value < 2.0 for value in means.values())
    lit = lit_textures(storey_house, parts, textures, light)
    assert set(lit) == set(storey_house.surface_keys())
    file = tmp_path / "lit.glb"
    write_glb(storey_house, lit, file, [lit_part(part, light) for part in parts], unlit=True)
    tree, _ = chunks(file)
    assert tree["extensionsUsed"] == ["KHR_materials_unlit"]
    assert all("KHR_materials_unlit" in m["extensions"] for m in tree["materials"])
    assert {image["mimeType"] for image in tree["images"]} == {"image/jpeg"}
    assert {"level:ground", "level:upper"} <= {node["name"] for node in tree["nodes"]}
    dark = replace(storey_house, rooms=storey_house.rooms[:4])  # no lamps upstairs
    below = wall_light(bake_light(dark, parts, mean_colours(textures), 0.7))
    gains = {room: means[room] / below[room] for room in means}
    gain = [gains[room.id] for room in storey_house.rooms]
    assert min(gain[4:]) > max(gain[:4])
