"""GLB and OBJ files, read again by trimesh."""

import numpy as np
import pytest
import trimesh
from glb_file import chunks
from PIL import Image

from plan2scene.house import SurfaceKey
from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.glb import ROUGHNESS, write_glb
from plan2scene_app.exports.obj import write_obj


@pytest.mark.parametrize("name", ["ring_house", "gap_house"])
def test_trimesh_finds_the_same_nodes_and_areas(name, request, paint, tmp_path):
    house = request.getfixturevalue(name)
    write_glb(house, paint(house), tmp_path / "house.glb")
    found = trimesh.load(tmp_path / "house.glb").geometry
    parts = build_parts(house)
    assert list(found) == [part.name for part in parts]
    for part in parts:
        assert found[part.name].area == pytest.approx(part.mesh.area, rel=1e-5)
        assert found[part.name].bounds == pytest.approx(part.mesh.bounds, abs=1e-5)


def test_texture_keeps_its_scale(l_house, paint, tmp_path):
    """A point that moves by the tile's size moves by one in UV."""
    write_glb(l_house, paint(l_house, size_m=0.4), tmp_path / "house.glb")
    floor = trimesh.load(tmp_path / "house.glb").geometry["hall/floor"]
    # trimesh turns v over on loading.
    uv = np.column_stack([floor.visual.uv[:, 0], 1 - floor.visual.uv[:, 1]])
    np.testing.assert_allclose(uv, floor.vertices[:, [0, 2]] / 0.4, atol=1e-4)


def test_materials_and_samplers(l_house, paint, tmp_path):
    textures = paint(l_house)
    write_glb(l_house, textures, tmp_path / "house.glb")
    document, binary = chunks(tmp_path / "house.glb")
    repeating, plain = document["samplers"]
    assert repeating == {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
    assert plain == {"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}
    for material in document["materials"]:
        assert material["pbrMetallicRoughness"]["metallicFactor"] == 0
        if material["name"] == "glass":
            continue
        assert not material["doubleSided"]
        rough = material["pbrMetallicRoughness"]["roughnessFactor"]
        if material["name"] == "plain":
            assert rough == 1
            assert "occlusionTexture" not in material
        else:  # the painted tiles are of substance tile
            assert rough == ROUGHNESS["tile"]
            texture = document["textures"][material["occlusionTexture"]["index"]]
            assert document["images"][texture["source"]]["name"] == "occlusion"
            assert material["occlusionTexture"]["texCoord"] == 1
            assert texture["sampler"] == 1
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    embedded = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    assert embedded.rstrip(b"\0") in {tile.png for tile in textures.values()}  # views are padded
    extras = {node["name"]: node.get("extras") for node in document["nodes"]}
    assert extras["hall/floor"]["substance"] == "tile"
    assert extras["hall/floor"]["observed"] is True
    assert extras["hall/floor"]["size_m"] == 0.8
    assert document["scenes"][0]["extras"]["rooms"][0]["types"] == ["Entrance", "Reception"]


def test_equal_tiles_are_embedded_once(l_house, paint, tmp_path):
    textures = paint(l_house)
    floor = textures[SurfaceKey("hall", "floor")]
    same = dict.fromkeys(textures, floor)
    write_glb(l_house, same, tmp_path / "house.glb")
    images = chunks(tmp_path / "house.glb")[0]["images"]
    assert [image["name"] for image in images] == ["hall_floor", "occlusion"]


def test_without_textures_surfaces_are_plain(l_house, tmp_path):
    write_glb(l_house, {}, tmp_path / "house.glb")
    document, _ = chunks(tmp_path / "house.glb")
    assert "images" not in document
    colours = [m["pbrMetallicRoughness"].get("baseColorFactor") for m in document["materials"]]
    assert sum(colour is not None for colour in colours) == 4  # three surfaces and glass


def test_same_input_same_bytes(gap_house, paint, tmp_path):
    write_glb(gap_house, paint(gap_house), tmp_path / "a.glb")
    write_glb(gap_house, paint(gap_house), tmp_path / "b.glb")
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_obj_has_the_same_areas_and_textures(gap_house, paint, tmp_path):
    textures = paint(gap_house)
    write_obj(gap_house, textures, tmp_path / "house.obj")
    total = sum(part.mesh.area for part in build_parts(gap_house))
    meshes = trimesh.load(tmp_path / "house.obj").geometry.values()
    assert sum(mesh.area for mesh in meshes) == pytest.approx(total, rel=1e-4)
    text = (tmp_path / "house.mtl").read_text()
    for line in text.splitlines():
        if line.startswith("map_Kd "):
            assert Image.open(tmp_path / line.split(" ", 1)[1]).size == (16, 16)
    assert text.count("map_Kd") == len(textures)
