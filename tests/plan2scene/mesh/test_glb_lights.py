"""Lamps and the sun of a GLB: where they hang, where they shine, how bright."""

import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from glb_file import chunks

from plan2scene.mesh.baking import lamp_position
from plan2scene.mesh.glb import LIGHTS, candela, write_glb


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


def test_a_lamp_in_each_room_shines_down_as_far_as_its_room(tree, gap_house):
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
    names = [tree["nodes"][child]["name"] for child in root["children"]]
    assert {"a/lamp", "sun"} <= set(names)


def test_the_sun_shines_aslant_from_above(tree):
    _, light, way = lit_nodes(tree)["sun"]
    assert light["type"] == "directional"
    assert way == pytest.approx(-np.array(LIGHTS.to_sun) / np.linalg.norm(LIGHTS.to_sun))


def test_lamps_light_large_floors_as_much_as_small_ones():
    for area, height in ((4.0, 2.0), (40.0, 2.6)):
        radius = math.sqrt(area / math.pi)
        r = (np.arange(20000) + 0.5) / 20000 * radius
        lux = candela(area, height) * height / (height**2 + r**2) ** 1.5
        assert np.average(lux, weights=r) == pytest.approx(LIGHTS.lamp_lux, rel=1e-4)


def test_the_open_air_has_no_lamp_and_unlit_houses_none(gap_house, tmp_path):
    rooms = (replace(gap_house.rooms[0], types=("Balcony",)), *gap_house.rooms[1:])
    write_glb(replace(gap_house, rooms=rooms), {}, tmp_path / "open.glb")
    assert set(lit_nodes(chunks(tmp_path / "open.glb")[0])) == {"b/lamp", "sun"}
    write_glb(gap_house, {}, tmp_path / "unlit.glb", unlit=True)
    assert "extensions" not in chunks(tmp_path / "unlit.glb")[0]
