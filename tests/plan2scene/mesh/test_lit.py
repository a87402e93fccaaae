"""house_lit.glb: one unlit image a surface, its texture under the light, doors as bright."""

import io
from dataclasses import replace

import numpy as np
import pytest
from glb_file import chunks
from PIL import Image

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.baking import bake_light, mean_colours
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.lit_house import SETTINGS, lit_part, lit_textures, shown
from plan2scene.mesh.texture_files import TileTexture

pytest.importorskip("embreex")


@pytest.fixture
def lit(gap_house):
    """Return parts, light and lit textures of a house of one grey."""
    tile = TileTexture(png_bytes(np.full((16, 16, 3), 150, np.uint8)), 0.7, True, "plaster", "t")
    textures = dict.fromkeys(gap_house.surface_keys(), tile)
    parts = build_parts(gap_house)
    light = bake_light(gap_house, parts, mean_colours(textures), 0.2)
    return parts, light, lit_textures(gap_house, parts, textures, light)


def test_a_surface_is_dark_in_its_corners_and_bright_below_the_lamp(lit, gap_house):
    parts, _, textures = lit
    floor = textures[SurfaceKey("b", "floor")]
    image = np.asarray(Image.open(io.BytesIO(floor.image)).convert("L")).astype(float)
    assert image.shape[1] == pytest.approx(SETTINGS.px_per_m * floor.extent_m[0], abs=1)
    part = next(part for part in parts if part.name == "b/floor")
    turns = floor.turns(part.uv)
    assert turns.min() > 0 and turns.max() < 1
    x, z = (floor.turns(np.array(point)) for point in ((4.55, 2.0), (3.15, 0.05)))
    middle, corner = (image[int(v * image.shape[0]), int(u * image.shape[1])] for u, v in (x, z))
    assert middle > corner + 20
    for texture in textures.values():
        values = np.asarray(Image.open(io.BytesIO(texture.image)))
        assert values.max() < 252 and np.median(values) > 40


def test_the_file_is_unlit(lit, gap_house, tmp_path):
    parts, light, textures = lit
    file = tmp_path / "lit.glb"
    write_glb(gap_house, textures, file, [lit_part(part, light) for part in parts], unlit=True)
    tree, _ = chunks(file)
    assert tree["extensionsUsed"] == ["KHR_materials_unlit"]
    assert all("KHR_materials_unlit" in m["extensions"] for m in tree["materials"])
    assert all("occlusionTexture" not in m for m in tree["materials"])
    assert {image["mimeType"] for image in tree["images"]} == {"image/jpeg"}


def test_doors_have_the_light_of_their_room(lit):
    parts, light, _ = lit
    door = next(part for part in parts if "/door/" in part.name)
    made = lit_part(door, light)
    assert made.colours.shape == door.colours.shape
    assert not np.array_equal(made.colours, door.colours)
    floor = next(part for part in parts if part.name == "a/floor")
    assert lit_part(floor, light) is floor


def test_every_storey_has_light_of_its_own(storey_house, paint, tmp_path):
    parts, textures = build_parts(storey_house), paint(storey_house)
    light = bake_light(storey_house, parts, mean_colours(textures), 0.7)
    assert set(light.rooms) == {room.id for room in storey_house.rooms}
    assert all(0.3 < value.mean() < 2.0 for value in light.rooms.values())
    lit = lit_textures(storey_house, parts, textures, light)
    assert set(lit) == set(storey_house.surface_keys())
    file = tmp_path / "lit.glb"
    write_glb(storey_house, lit, file, [lit_part(part, light) for part in parts], unlit=True)
    tree, _ = chunks(file)
    assert {"level:ground", "level:upper"} <= {node["name"] for node in tree["nodes"]}
    dark = replace(storey_house, rooms=storey_house.rooms[:4])  # no lamps upstairs
    below = bake_light(dark, parts, mean_colours(textures), 0.7)
    gains = {room: (light.rooms[room] / below.rooms[room]).mean() for room in light.rooms}
    assert min(gains[room.id] for room in storey_house.rooms[4:]) > max(
        gains[room.id] for room in storey_house.rooms[:4]
    )


def test_highlights_are_compressed_in_order():
    values = shown(np.array([0.0, 0.5, 0.75, 1.0, 2.0, 9.0])).astype(int)
    assert values[0] == 0 and values[-1] < 255
    assert (np.diff(values) > 0).all()
