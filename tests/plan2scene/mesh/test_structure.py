from dataclasses import replace

import numpy as np
import pytest
import trimesh
from sample_houses import parts_of, with_openings
from shapely.geometry import Polygon

from plan2scene.house import Door, House, Opening
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.structure import SKIRTING


@pytest.mark.parametrize("name", ["l_house", "ring_house", "shared_house", "gap_house"])
def test_surfaces_have_their_area_and_face_their_room(name, request):
    house = request.getfixturevalue(name)
    parts = parts_of(house)
    for room in house.rooms:
        polygon = Polygon(room.rings[0], room.rings[1:])
        floor, ceiling = (parts[f"{room.id}/{name}"].mesh for name in ("floor", "ceiling"))
        assert floor.area == pytest.approx(polygon.area, rel=1e-6)
        assert ceiling.area == pytest.approx(polygon.area, rel=1e-6)
        assert np.allclose(floor.vertex_normals, [0, 1, 0])
        assert np.allclose(ceiling.vertex_normals, [0, -1, 0])
        assert np.allclose(ceiling.vertices[:, 1], room.height)
        for wall in house.walls_of(room.id):
            face = parts[f"{room.id}/wall/{wall.id}"].mesh
            step = 0.005
            s = np.arange(step / 2, wall.length, step)[:, None]
            y = np.arange(step / 2, wall.height, step)[None]
            hole = np.zeros((s.size, y.size), dtype=bool)
            for o in wall.openings:
                hole |= (s > o.start) & (s < o.end) & (y > o.bottom) & (y < o.top)
            assert face.area == pytest.approx(
                (wall.length * wall.height - hole.sum() * step * step), rel=2e-3
            )
            normal = face.vertex_normals[0, [0, 2]]
            inside = ((np.array(wall.start) + np.array(wall.end)) / 2) + 0.05 * normal
            assert polygon.contains(Polygon.from_bounds(*(inside - 1e-6), *(inside + 1e-6)))
            assert np.abs((face.vertices[:, [0, 2]] - np.array(wall.start)) @ normal).max() < 1e-3


def test_names_are_complete_and_a_door_drawn_once_is_cut_in_both_rooms(gap_house):
    names = [part.name for part in assemble(gap_house).parts]
    assert len(names) == len(set(names))
    assert {"a/door/ha", "a/threshold/ha", "structure/wall/a_w1"} <= set(names)
    assert "b/door/hb" not in names  # the other room's copy of the same door
    walls = tuple(replace(w, openings=()) if w.id == "b_w3" else w for w in gap_house.walls)
    once = House("once", gap_house.rooms, walls, (Door("a", "ha", "b"),))
    assert parts_of(once)["b/wall/b_w3"].mesh.area == pytest.approx(4.0 * 2.5 - 0.8 * 2.0, rel=1e-3)
    alone = replace(once, doors=(Door("a", "ha", None),))
    assert parts_of(alone)["b/wall/b_w3"].mesh.area == pytest.approx(4.0 * 2.5, rel=1e-3)


def test_outer_face_has_the_hole(l_house):
    part = parts_of(l_house)["structure/wall/hall_w0"]
    faces = part.mesh.faces[(part.mesh.vertex_normals[:, 2] < -0.99)[part.mesh.faces[:, 0]]]
    at = part.mesh.vertices[faces].mean(axis=1)
    low = at[(at[:, 1] < 2.5) & (np.abs(at[:, 2] + 0.1) < 1e-6)]
    assert len(low) > 0
    assert not ((low[:, 0] > 1.05) & (low[:, 0] < 1.85) & (low[:, 1] < 2.0)).any()


def test_uv_runs_on_round_the_corner_in_metres(l_house):
    parts = parts_of(l_house)
    first, second = parts["hall/wall/hall_w0"], parts["hall/wall/hall_w1"]

    def u_at(part, x, z, y):
        distance = np.linalg.norm(part.mesh.vertices - [x, y, z], axis=1)
        assert distance.min() < 2e-3
        return part.uv[distance.argmin()]

    corner = u_at(first, 5.0, 0.0, 0.0), u_at(second, 5.0, 0.0, 0.0)
    np.testing.assert_allclose(corner[0], corner[1], atol=2e-3)
    left = u_at(first, 0.0, 0.0, 2.5)
    assert corner[0][0] - left[0] == pytest.approx(5.0, abs=2e-3)
    assert left[1] == pytest.approx(0.0, abs=1e-6)  # v is 0 at the ceiling and grows downwards
    assert corner[0][1] == pytest.approx(2.5, abs=1e-6)
    # Seen from inside, u grows to the right: facing -z that is +x.
    assert corner[0][0] > left[0]


def test_doors_and_windows_are_closed_solids(l_house):
    """Frames, leaves, handles and sills: boxes that face outwards, so their volume counts up."""
    parts = parts_of(l_house)
    for name, boxes in (("hall/door/front", 10), ("hall/window/win", 5)):
        mesh = parts[name].mesh.copy()
        assert len(mesh.faces) == 12 * boxes
        volumes = []
        for first in range(0, len(mesh.faces), 12):
            solid = mesh.submesh([range(first, first + 12)], append=True)
            solid.merge_vertices(merge_norm=True, merge_tex=True)
            assert solid.is_watertight and solid.is_winding_consistent
            volumes.append(solid.volume)
        assert min(volumes) > 0
        if name == "hall/door/front":  # the leaf: 0.792 m wide, 2.038 m high, 4 cm thick
            assert max(volumes) == pytest.approx(0.792 * 2.038 * 0.04, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "made"), [("Bathroom", {"window"}), ("Balcony", {"window", "glass"})]
)
def test_a_window_between_two_rooms_is_a_hatch_unless_one_is_outside(gap_house, kind, made):
    house = with_openings(gap_house, kind="window", bottom=1.0)
    rooms = house.rooms[0], replace(house.rooms[1], types=(kind,))
    parts = assemble(replace(house, rooms=rooms, doors=())).parts
    found = [part.extras for part in parts if part.extras["kind"] in ("window", "glass")]
    assert {e["kind"] for e in found} == made
    assert all({e["room_id"], e["leads_to"]} == {"a", "b"} for e in found)


@pytest.mark.parametrize(
    ("kinds", "glazed"),
    [(("Bedroom", "Balcony"), True), (("Corridor", "Terrace"), False), (("Bedroom",) * 2, False)],
)
def test_the_door_of_a_lived_in_room_to_a_balcony_is_of_glass(gap_house, kinds, glazed):
    rooms = (replace(r, types=(k,)) for r, k in zip(gap_house.rooms, kinds, strict=True))
    parts = assemble(replace(gap_house, rooms=tuple(rooms))).parts
    panes = [part for part in parts if part.extras["kind"] == "glass"]
    assert bool(panes) is glazed
    for pane in panes:
        assert pane.mesh.bounds[0][1] < 0.1 and pane.mesh.bounds[1][1] > 1.9  # down to the floor


@pytest.mark.parametrize(("top", "made"), [(2.0, {"passage"}), (2.5, set())])
def test_a_passage_up_to_the_ceiling_has_no_lining_and_no_cap(gap_house, top, made):
    house = with_openings(gap_house, kind="passage", top=top)
    assert house.passages() == (("a", "b", pytest.approx(0.8)), ("b", "a", pytest.approx(0.8)))
    assert gap_house.passages() == ()
    parts = assemble(house).parts
    assert {part.extras["kind"] for part in parts} & {"door", "passage"} == made
    over = np.array([[3.05, 9.0, 1.4]])  # the middle of the passage, from above
    caps = trimesh.util.concatenate([p.mesh for p in parts if p.extras["kind"] == "structure"])
    faces = caps.ray.intersects_first(over, np.array([[0.0, -1.0, 0.0]]))
    assert bool((caps.face_normals[faces[faces >= 0]][:, 1] > 0.9).any()) == bool(made)


def test_a_leaf_opens_into_the_room_with_fewer_doors(gap_house):
    def reach(house):
        points = parts_of(house)["a/door/ha"].mesh.vertices[:, 0]
        return 3.0 - points.min(), points.max() - 3.1

    into_a = reach(gap_house)
    walls = list(gap_house.walls)
    walls[3] = replace(walls[3], openings=(Opening("front", "door", 1.0, 1.8, 0.0, 2.0),))
    into_b = reach(replace(gap_house, walls=tuple(walls)))
    assert into_a[0] > 0.3 > into_a[1] and into_b[1] > 0.3 > into_b[0]


@pytest.mark.parametrize(("key", "in_b"), [("a", 0.0), ("", 1.0)])
def test_trim_has_the_colour_that_its_room_is_set_to(gap_house, key, in_b):
    rooms = tuple(replace(room, types=("Bedroom",)) for room in gap_house.rooms)
    parts = parts_of(replace(gap_house, rooms=rooms, trim_colours=((key, (32, 64, 96)),)))
    blue = {n: (p.colours == (32, 64, 96)).all(1).mean() for n, p in parts.items() if p.uv is None}
    assert blue["a/skirting"] == 1.0 and blue["b/skirting"] == in_b
    assert 0.1 < blue["a/door/ha"] < 0.9  # its frame, and not its leaf
    assert {share for name, share in blue.items() if name.startswith("structure")} <= {0.0}


def test_boards_are_as_long_as_the_walls_less_the_door(l_house, gap_house):
    mesh = parts_of(l_house)["hall/skirting"].mesh
    low, high = mesh.bounds
    assert (low[1], high[1]) == (0.0, pytest.approx(SKIRTING.height))
    # Boxes overlap in the corners, so the volume is of the lengths, not of a union.
    length = 2 * (5.0 + 4.0) - (0.9 + 2 * SKIRTING.frame)
    assert mesh.volume == pytest.approx(length * SKIRTING.height * SKIRTING.depth, rel=1e-3)
    parts = parts_of(gap_house)
    places = [[2.5, SKIRTING.height / 2, z] for z in (1.4, 3.0)]
    hit = parts["a/skirting"].mesh.ray.intersects_any(places, [[1.0, 0.0, 0.0]] * 2)
    assert hit.tolist() == [False, True] and "b/skirting" not in parts
