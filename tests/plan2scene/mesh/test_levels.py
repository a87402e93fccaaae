from dataclasses import replace

import numpy as np
import pytest
import trimesh
from glb_file import chunks
from sample_houses import parts_of

from plan2scene.house import SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import write_json
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.structure import CAP_COLOUR
from plan2scene.mesh.texture_files import textured
from plan2scene.plans.geometry import walls_of_rooms
from plan2scene.plans.plan_json import house_of_plan
from plan2scene_app.exports.solids import house_solids

WELL = 0.9 * 3.6
RED, GREY = (140, 20, 30), (90, 90, 90)


@pytest.fixture(scope="module")
def house(storey_house):
    return storey_house


def two_levels(*rooms):
    """Return a house of rooms (id, level, x0, x1) 4 m deep, on levels 2.8 m apart."""
    levels = [{"id": "low", "elevation": 0.0}, {"id": "high", "elevation": 2.8}]
    entries = [
        {"id": name, "types": ["Bedroom"], "level": level}
        | {"polygon": [[x0, 0], [x0, 4], [x1, 4], [x1, 0]]}
        for name, level, x0, x1 in rooms
    ]
    plan = {"format": "plan2scene-plan", "version": 1, "levels": levels, "rooms": entries}
    return house_of_plan(plan | {"wall_depth": 0.2}, "h")


@pytest.fixture(scope="module")
def parts(house):
    return parts_of(house)


def test_floors_and_ceilings_lie_at_their_level_open_over_the_stairs(house, parts):
    for room in house.rooms:
        low = house.level_of(room.id).elevation
        assert parts[f"{room.id}/floor"].mesh.vertices[:, 1] == pytest.approx(low)
        assert parts[f"{room.id}/ceiling"].mesh.vertices[:, 1] == pytest.approx(low + 2.5)
        assert parts[f"{room.id}/floor"].extras["level"] == room.level
    assert parts["landing/floor"].mesh.area == pytest.approx(2.4 * 6 + 2.2 - WELL)
    assert parts["hall/ceiling"].mesh.area == pytest.approx(2.4 * 6 - WELL)
    assert parts["hall/floor"].mesh.area == pytest.approx(2.4 * 6)
    assert parts["landing/ceiling"].mesh.area == pytest.approx(2.4 * 6 + 2.2)


def test_steps_reach_the_next_floor_and_a_railing_stands_around_their_well(parts):
    stairs = parts["hall/stairs/stairs"]
    assert stairs.extras["leads_to"] == "landing"
    low, high = stairs.mesh.bounds
    assert (low[1], high[1]) == pytest.approx((0.0, 2.8))
    tops = np.unique(np.round(stairs.mesh.vertices[stairs.mesh.vertex_normals[:, 1] > 0.9, 1], 4))
    assert len(tops) == 15 and np.diff(tops) == pytest.approx(2.8 / 15, abs=1e-3)
    vertices = parts["landing/railing/stairs"].mesh.vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    assert (low[1], high[1]) == pytest.approx((2.8, 2.8 + 1.05))
    assert high[[0, 2]] == pytest.approx([0.9, 4.6], abs=0.005)
    at_head = (vertices[:, 2] < 1.05) & (vertices[:, 0] < 0.8)
    at_wall = vertices[:, 0] < 0.09
    assert not at_head.any() and not at_wall.any()


@pytest.mark.parametrize(("seen", "covered"), [("landing", RED), ("hall", GREY), ("", RED)])
def test_steps_have_the_colour_of_the_floor_that_they_lead_to(house, tmp_path, seen, covered):
    floors = {"landing": RED, "hall": GREY}
    entry = {"size_m": 1.0, "substance": "carpet", "source": "crops"}
    surfaces = {}
    for room, colour in floors.items():
        surfaces[f"{room}/floor"] = {**entry, "observed": room == seen}
        tile = np.full((8, 8, 3), colour, np.uint8)
        write_png(tmp_path / f"{SurfaceKey(room, 'floor').filename}.png", tile)
    write_json(tmp_path / "textures.json", {"method": "toy", "surfaces": surfaces})
    shown, _ = textured(tmp_path, house)
    made = parts_of(shown)["hall/stairs/stairs"]
    assert np.unique(made.colours, axis=0).tolist() == [list(covered)]


def test_one_sees_up_through_the_well_and_nowhere_else(parts):
    rays = Rays.of(list(parts.values()))
    up = np.array([[0.0, 1.0, 0.0]])
    steps = [0.45, 2.81, 1.2]  # on the upper flight's end: nothing but the landing's ceiling
    assert rays.distances(np.array([steps]), up)[0] == pytest.approx(2.8 + 2.5 - 2.81, abs=1e-3)
    assert rays.distances(np.array([[1.8, 1.0, 3.0]]), up)[0] == pytest.approx(1.5, abs=1e-3)
    assert rays.distances(np.array([[0.45, 1.0, 4.4]]), up)[0] == pytest.approx(5.3 - 1.0, abs=1e-3)


def test_walls_below_rooms_go_on_to_their_floor(parts):
    lower = parts["structure/wall/living_wall_0"].mesh.bounds[:, 1]
    upper = parts["structure/wall/bedroom_wall_0"].mesh.bounds[:, 1]
    assert lower == pytest.approx([0.0, 2.8], abs=0.025)
    assert upper == pytest.approx([2.8, 2.8 + 2.535], abs=0.025)
    # They overlap, and the dark cap between them ends behind both.
    assert upper[0] < lower[1] < 2.8
    wall = parts["structure/wall/living_wall_0"]
    dark = wall.mesh.vertices[(wall.colours == CAP_COLOUR).all(axis=1)]
    assert dark[:, 2].min() > wall.mesh.vertices[:, 2].min() + 0.001


def test_no_wall_below_comes_out_of_a_floor_without_a_slab():
    house = two_levels(("a", "low", 0, 3), ("b", "low", 3, 7), ("over", "high", 0, 7))
    rays = Rays.of(assemble(house).parts)
    above = np.array([[x, 2.9, 2.0] for x in np.linspace(2.8, 3.2, 9)])
    assert rays.distances(above, np.tile([0.0, -1.0, 0.0], (9, 1))) == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize(("inset", "dark"), [(0.1, False), (0.8, True)])
def test_a_narrow_ledge_below_the_next_storey_has_no_dark_cap(inset, dark):
    house = two_levels(("low", "low", 0, 4), ("high", "high", inset, 4))
    wall = parts_of(house)["structure/wall/low_wall_0"]
    ledge = (wall.mesh.vertices[:, 0] < inset - 0.25) & (wall.mesh.vertices[:, 1] > 2.4)
    ledge |= (wall.mesh.vertices[:, 0] < -0.15) & (wall.mesh.vertices[:, 1] > 2.4)
    assert (wall.colours[ledge] == CAP_COLOUR).all(axis=1).any() == dark


def test_glb_has_a_node_for_each_level(house, tmp_path):
    write_glb(house, {}, tmp_path / "house.glb")
    scene = trimesh.load(tmp_path / "house.glb")
    assert scene.graph.transforms.parents["landing/floor"] == "level:upper"
    assert scene.graph.transforms.parents["level:upper"] == "two"
    tree, _ = chunks(tmp_path / "house.glb")
    nodes = {node["name"]: node for node in tree["nodes"]}
    assert nodes["level:upper"]["extras"]["elevation"] == 2.8
    assert nodes["landing/floor"]["extras"]["level"] == "upper"
    assert [level["id"] for level in tree["scenes"][0]["extras"]["levels"]] == ["ground", "upper"]


def test_what_juts_out_has_an_underside(house, parts):
    assert not any("soffit" in name for name in parts)  # the storeys of the example are congruent
    wide = replace(house.room("study"), rings=(((4.6, 3.4), (9.5, 3.4), (9.5, 6.0), (4.6, 6.0)),))
    rooms = tuple(wide if room.id == "study" else room for room in house.rooms)
    walls = [wall for wall in house.walls if "study" not in wall.room_ids]
    walls += walls_of_rooms([wide], depth=0.12)
    under = parts_of(replace(house, rooms=rooms, walls=tuple(walls)))["structure/soffit/upper"].mesh
    assert (under.face_normals[:, 1] < -0.99).all()
    assert under.area == pytest.approx(1.5 * 2.6 + 1.5 * 2 * 0.12, rel=0.01)


@pytest.fixture
def balcony_house(gap_house):
    """The two rooms with a door between them, the second one a balcony."""
    inside, outside = gap_house.rooms
    return replace(gap_house, rooms=(inside, replace(outside, types=("Balcony",))))


def test_a_balcony_has_no_ceiling_and_railings_on_its_free_sides(balcony_house):
    parts = parts_of(balcony_house)
    assert "a/ceiling" in parts and "b/ceiling" not in parts
    assert {name for name in parts if "railing" in name} == {f"b/railing/b_w{k}" for k in (0, 1, 2)}
    assert "b/wall/b_w3" in parts  # the house's wall, with the door
    assert not any(name.startswith(("b/wall/b_w0", "structure/wall/b_w0")) for name in parts)
    for k in (0, 1, 2):
        mesh = parts[f"b/railing/b_w{k}"].mesh
        assert mesh.bounds[1, 1] == pytest.approx(1.05) and mesh.volume > 0
    low, high = parts["b/railing/b_w1"].mesh.bounds[:, [0, 2]]
    assert high[1] - low[1] == pytest.approx(4.0, abs=1e-4)
    assert low[0] >= 6.0 - 1e-4 and high[0] < 6.1  # on the wall's line, outwards


def test_railings_are_solids_without_a_roof(balcony_house):
    solids = house_solids(balcony_house)
    rails = [solid for solid in solids if solid.category == "railing"]
    assert len(rails) == 3
    assert all(piece.is_watertight for solid in rails for piece in solid.pieces)
    assert "b/ceiling" not in {solid.name for solid in solids}
