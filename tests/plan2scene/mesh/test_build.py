import json

import pytest
import trimesh
from PIL import Image
from scene_textures import scene_textures

from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.mesh.build import build_house
from plan2scene.mesh.texture_files import load_textures
from plan2scene_app.pictures.house_pictures import draw_house


def test_files_of_a_house(textured, gap_house, paint):
    out = textured / "out"
    args = textured / "house.scene.json", textured / "textures"
    names = "house.glb", "house.scene.json", "preview.png", "rooms.jpg", "views.jpg", "patterns.jpg"
    outputs = [out / name for name in names]
    build_house(*args, *outputs[:2], house_id="gap")
    draw_house(*args, *outputs[2:], house_id="gap", photos={}, cameras=None, patterns=None)
    assert Image.open(outputs[2]).size == (1600, 800)
    assert Image.open(outputs[3]).size == (2 * 428 + 8, 312 + 8)
    assert outputs[4].is_file() and outputs[5].is_file()  # also without photos
    assert trimesh.load(out / "house.glb").geometry["a/floor"].area == pytest.approx(12.0, rel=1e-4)
    textures = scene_textures(out / "house.scene.json")
    for key, tile in paint(gap_house).items():
        assert textures[key] == (tile.png, tile.size_m)


def test_a_surface_without_texture_is_a_warning(textured, gap_house, caplog):
    index = json.loads((textured / "textures" / "textures.json").read_text())
    del index["surfaces"]["a/wall"]
    (textured / "textures" / "textures.json").write_text(json.dumps(index))
    textures = load_textures(textured / "textures", gap_house)
    assert SurfaceKey("a", "wall") not in textures
    assert "house gap: no texture for a/wall" in caplog.text


def test_missing_and_broken_tiles_are_refused(textured, gap_house):
    (textured / "textures" / "a_floor.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"a_floor\.png.*expected an image"):
        load_textures(textured / "textures", gap_house)
    (textured / "textures" / "a_floor.png").unlink()
    with pytest.raises(InputError, match=r"a_floor\.png.*no such file"):
        load_textures(textured / "textures", gap_house)
