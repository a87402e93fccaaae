"""The house's textures have the colours of its paint."""

import numpy as np
import pandas as pd
import pytest

from plan2scene.colour import median_colour, srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import jpeg_bytes, read_image, write_png
from plan2scene.io import read_json, write_json, write_parquet
from plan2scene.paint.observations import PlaneColours, write_colours
from plan2scene.paint.surfaces import door_paints, paint_gains, read_paint, write_paint
from plan2scene.textures.painted import paint_textures


def plane(photo, room_id, surface, colour):
    shares = np.tile(np.float32(colour), (32, 1))
    return PlaneColours(photo, (room_id,), surface, 0, True, (), 0.05, shares)


@pytest.fixture
def paint(tmp_path):
    """A white room and a blue one in dim light."""
    light = np.array([0.35, 0.33, 0.3])
    planes = [
        plane("1.jpg", "a", "floor", (0.1, 0.06, 0.04)),
        plane("1.jpg", "a", "wall", 0.82 * light),
        plane("1.jpg", "a", "ceiling", 0.8 * light),
        plane("2.jpg", "b", "wall", np.array([0.15, 0.3, 0.6]) * light),
        plane("2.jpg", "b", "ceiling", 0.82 * light),
    ]
    write_colours(tmp_path / "colours.parquet", planes, dataset="d", house_id="h")
    materials = pd.DataFrame({"room_id": [], "surface": [], "material": []})
    write_parquet(tmp_path / "materials.parquet", materials, {"dataset": "d", "house": "h"})
    inputs = tmp_path / "colours.parquet", tmp_path / "materials.parquet"
    write_paint(*inputs, tmp_path / "paint.parquet", dataset="d", house="h")
    return tmp_path / "paint.parquet"


def test_a_white_and_a_blue_wall(paint):
    paints, white = read_paint(paint)
    assert SurfaceKey("a", "wall") in white
    assert SurfaceKey("b", "wall") not in white
    red, green, blue = paints[SurfaceKey("b", "wall")]
    assert red < green < blue


def test_tiles_and_maps_get_the_paint_and_keep_their_pattern(paint, tmp_path):
    rng = np.random.default_rng(0)
    folder = tmp_path / "textures"
    folder.mkdir()
    tile = rng.integers(110, 140, (32, 32, 3), dtype=np.uint8)
    write_png(folder / "a_wall.png", tile)
    (folder / "a_wall.jpg").write_bytes(jpeg_bytes(tile, quality=95))
    index = {"method": "toy", "surfaces": {"a/wall": {"size_m": 1.0, "observed": True}}}
    write_json(folder / "textures.json", index)
    write_json(folder / "maps.json", {"surfaces": {}})
    paint_textures(folder, paint, tmp_path / "out")
    painted = read_image(tmp_path / "out" / "a_wall.png")
    linear = srgb_to_linear(median_colour(painted))
    assert linear == pytest.approx(read_paint(paint)[0][SurfaceKey("a", "wall")], abs=0.02)
    together = np.corrcoef(tile[..., 1].ravel(), painted[..., 1].ravel())[0, 1]
    assert together > 0.95
    assert painted.max() < 255
    whole = read_image(tmp_path / "out" / "a_wall.jpg")
    assert median_colour(whole) == pytest.approx(median_colour(painted), abs=0.02)
    assert read_json(tmp_path / "out" / "textures.json") == index
    assert np.array_equal(read_image(folder / "a_wall.png"), tile)


def test_unseen_surfaces_follow_the_house():
    grey, white = np.full(3, 0.2), np.full(3, 0.8)
    key = SurfaceKey
    shown = {
        key("a", "wall"): grey,
        key("b", "wall"): grey,
        key("b", "wall.3"): grey / 2,
        key("a", "floor"): grey / 2,
        key("b", "floor"): grey / 4,
    }
    paint = {key("a", "wall"): white, key("a", "floor"): grey}
    unseen = {key("b", "wall"), key("b", "floor")}
    gains = paint_gains(shown, paint, frozenset({key("a", "wall")}), unseen, white)
    assert gains[key("b", "wall")] * grey == pytest.approx(white)
    assert gains[key("b", "floor")] == pytest.approx([2.0] * 3)
    blue = {key("a", "wall"): np.array([0.1, 0.2, 0.4])}
    gains = paint_gains(shown, blue, frozenset(), unseen, white)
    assert gains[key("b", "wall")] * grey == pytest.approx(blue[key("a", "wall")])


def test_without_photos_walls_are_white_and_floors_as_made():
    shown = {SurfaceKey("a", "wall"): np.full(3, 0.4), SurfaceKey("a", "floor"): np.full(3, 0.1)}
    gains = paint_gains(shown, {}, frozenset(), set(shown), [0.8] * 3)
    assert gains[SurfaceKey("a", "wall")] == pytest.approx([2.0] * 3)
    assert gains[SurfaceKey("a", "floor")] == pytest.approx([1.0] * 3)


def test_a_surface_of_ready_crops_keeps_its_colour():
    shown = {SurfaceKey("a", "wall"): np.full(3, 0.4)}
    gains = paint_gains(shown, {}, frozenset(), set(), [0.8] * 3)
    assert gains[SurfaceKey("a", "wall")] == pytest.approx([1.0] * 3)


def test_unseen_doors_are_like_the_others():
    oak, white = np.array([0.3, 0.2, 0.1]), np.full(3, 0.8)
    seen = {SurfaceKey("1", "door"): oak, SurfaceKey("a", "wall"): white}
    assert set(door_paints(seen, frozenset())) == {"1"}
    seen[SurfaceKey("2", "door")] = oak
    assert door_paints(seen, frozenset())[""] == pytest.approx(oak)
    seen[SurfaceKey("2", "door")] = white
    assert "" not in door_paints(seen, frozenset({SurfaceKey("2", "door")}))


def test_an_unseen_floor_is_lit_like_the_floor_that_looks_alike():
    key = SurfaceKey
    oak, slate = np.array([0.2, 0.12, 0.06]), np.full(3, 0.02)
    shown = {key("a", "floor"): oak, key("b", "floor"): slate, key("c", "floor"): 0.9 * oak}
    paint = {key("a", "floor"): 1.5 * oak, key("b", "floor"): 4.0 * slate}
    gains = paint_gains(shown, paint, frozenset(), {key("c", "floor")}, [0.8] * 3)
    assert gains[key("c", "floor")] == pytest.approx([1.5] * 3)
