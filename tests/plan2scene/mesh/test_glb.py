from dataclasses import replace

import numpy as np
import pytest
import trimesh
from glb_file import chunks
from PIL import Image

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.baking import lamp_position
from plan2scene.mesh.glb import ROUGHNESS, write_glb
from plan2scene.mesh.relief import tangents
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.exports.obj import write_obj


@pytest.mark.parametrize("name", ["ring_house", "gap_house"])
def test_trimesh_finds_the_same_nodes_and_areas(name, request, paint, tmp_path):
    house = request.getfixturevalue(name)
    write_glb(house, paint(house), tmp_path / "house.glb")
    found = trimesh.load(tmp_path / "house.glb").geometry
    parts = assemble(house).parts
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
            assert rough == 1 and "occlusionTexture" not in material
        else:  # the painted tiles are of substance tile
            assert rough == ROUGHNESS["tile"]
            texture = document["textures"][material["occlusionTexture"]["index"]]
            assert document["images"][texture["source"]]["name"] == "occlusion"
            assert material["occlusionTexture"]["texCoord"] == 1 and texture["sampler"] == 1
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    embedded = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    assert embedded.rstrip(b"\0") in {tile.png for tile in textures.values()}  # views are padded
    extras = {node["name"]: node.get("extras") for node in document["nodes"]}
    assert extras["hall/floor"]["substance"] == "tile"
    assert extras["hall/floor"]["observed"] is True and extras["hall/floor"]["size_m"] == 0.8
    assert document["scenes"][0]["extras"]["rooms"][0]["types"] == ["Entrance", "Reception"]


def test_equal_tiles_are_embedded_once_and_surfaces_without_one_are_plain(l_house, paint, tmp_path):
    textures = paint(l_house)
    same = dict.fromkeys(textures, textures[SurfaceKey("hall", "floor")])
    write_glb(l_house, same, tmp_path / "house.glb")
    images = chunks(tmp_path / "house.glb")[0]["images"]
    assert [image["name"] for image in images] == ["hall_floor", "occlusion"]
    write_glb(l_house, {}, tmp_path / "house.glb")
    document, _ = chunks(tmp_path / "house.glb")
    assert "images" not in document
    colours = [m["pbrMetallicRoughness"].get("baseColorFactor") for m in document["materials"]]
    assert sum(colour is not None for colour in colours) == 4  # three surfaces and glass


def test_obj_has_the_same_areas_and_textures(gap_house, paint, tmp_path):
    textures = paint(gap_house)
    write_obj(gap_house, textures, tmp_path / "house.obj")
    total = sum(part.mesh.area for part in assemble(gap_house).parts)
    meshes = trimesh.load(tmp_path / "house.obj").geometry.values()
    assert sum(mesh.area for mesh in meshes) == pytest.approx(total, rel=1e-4)
    text = (tmp_path / "house.mtl").read_text()
    for line in text.splitlines():
        if line.startswith("map_Kd "):
            assert Image.open(tmp_path / line.split(" ", 1)[1]).size == (16, 16)
    assert text.count("map_Kd") == len(textures)


@pytest.fixture
def tree(gap_house, tmp_path):
    write_glb(gap_house, {}, tmp_path / "house.glb")
    return chunks(tmp_path / "house.glb")[0]


def lit_nodes(tree):
    """Return nodes with a light by name, each with its light and the way that it shines."""
    lights = tree["extensions"]["KHR_lights_punctual"]["lights"]
    found = {}
    for node in tree["nodes"]:
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if number is not None:
            x, y, z, w = node["rotation"]
            turn = trimesh.transformations.quaternion_matrix([w, x, y, z])[:3, :3]
            found[node["name"]] = node, lights[number], turn @ [0, 0, -1]
    return found


def test_a_lamp_in_each_room_indoors_shines_down_as_far_as_its_room(tree, gap_house, tmp_path):
    found = lit_nodes(tree)
    assert set(found) == {"a/lamp", "b/lamp", "sun"}
    for room in gap_house.rooms:
        node, light, way = found[f"{room.id}/lamp"]
        assert node["translation"] == pytest.approx(list(lamp_position(gap_house, room.id)))
        assert way == pytest.approx([0, -1, 0], abs=1e-9)
        corners = [[x, 0, z] for x, z in room.rings[0]]
        reach = np.linalg.norm(np.array(corners) - node["translation"], axis=1).max()
        assert reach < light["range"]
    root = next(node for node in tree["nodes"] if node.get("name") == gap_house.id)
    assert {"a/lamp", "sun"} <= set([tree["nodes"][child]["name"] for child in root["children"]])
    rooms = (replace(gap_house.rooms[0], types=("Balcony",)), *gap_house.rooms[1:])
    write_glb(replace(gap_house, rooms=rooms), {}, tmp_path / "open.glb")
    assert set(lit_nodes(chunks(tmp_path / "open.glb")[0])) == {"b/lamp", "sun"}
    write_glb(gap_house, {}, tmp_path / "unlit.glb", unlit=True)
    assert "extensions" not in chunks(tmp_path / "unlit.glb")[0]


def joints(contrast=90, size_px=64, size_m=0.5):
    """Return a tile with a joint down its middle and one across, darker by `contrast`."""
    image = np.full((size_px, size_px, 3), 130)
    middle = slice(size_px // 2 - 2, size_px // 2 + 2)
    image[middle] = image[:, middle] = 130 - contrast
    image = image.astype(np.uint8)
    return TileTexture(png_bytes(image), size_m, True, "tile")


def test_files_have_them_on_demand_and_valid(gap_house, tmp_path):
    textures = dict.fromkeys(gap_house.surface_keys(), joints())
    write_glb(gap_house, textures, tmp_path / "plain.glb")
    write_glb(gap_house, textures, tmp_path / "relief.glb", relief=True)
    plain, made = (chunks(tmp_path / f"{name}.glb")[0] for name in ("plain", "relief"))
    assert not any("normalTexture" in material for material in plain["materials"])
    named = {m["name"]: m["normalTexture"] for m in made["materials"] if "normalTexture" in m}
    assert set(named) == {key.filename for key in textures}
    images = {made["textures"][use["index"]]["source"] for use in named.values()}
    assert len(images) == 1  # equal ones once
    assert made["images"][images.pop()]["mimeType"] == "image/jpeg"


def test_tangents_run_along_the_image_s_rows_and_up_it(gap_house, tmp_path):
    by_name = {part.name: part for part in assemble(gap_house).parts}
    along = {"a/floor": (1, 0, 0), "a/ceiling": (1, 0, 0), "a/wall/a_w0": (1, 0, 0)}
    up = {"a/floor": (0, 0, -1), "a/ceiling": (0, 0, -1), "a/wall/a_w0": (0, 1, 0)}
    for name, expected in along.items():
        made = tangents(by_name[name])
        assert np.allclose(made[:, :3], expected, atol=1e-5)
        turned = np.cross(by_name[name].mesh.vertex_normals, made[:, :3]) * made[:, 3:]
        assert np.allclose(turned, up[name], atol=1e-5)
    textures = dict.fromkeys(gap_house.surface_keys(), joints())
    write_glb(gap_house, textures, tmp_path / "relief.glb", relief=True)
    tree = chunks(tmp_path / "relief.glb")[0]
    primitives = [mesh["primitives"][0] for mesh in tree["meshes"]]
    mapped = ["normalTexture" in tree["materials"][entry["material"]] for entry in primitives]
    assert ["TANGENT" in entry["attributes"] for entry in primitives] == mapped
    assert any(mapped) and not all(mapped)
