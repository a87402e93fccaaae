"""The parts of a house: areas, openings, walls, skirting boards, triangles."""

import dataclasses

import numpy as np
import pytest
from shapely.geometry import MultiPolygon, Polygon, box

from plan2scene.house import Door, House, Opening, Wall
from plan2scene.mesh.assembly import assemble, build_parts
from plan2scene.mesh.polygons import signed_areas, triangulate
from plan2scene.mesh.structure import SKIRTING


def by_name(house):
    return {part.name: part for part in build_parts(house)}


def wall_area(wall):
    """Length x height less the union of the holes, on a fine grid independent of shapely."""
    step = 0.005
    s = np.arange(step / 2, wall.length, step)[:, None]
    y = np.arange(step / 2, wall.height, step)[None]
    hole = np.zeros((s.size, y.size), dtype=bool)
    for o in wall.openings:
        hole |= (s > o.start) & (s < o.end) & (y > o.bottom) & (y < o.top)
    return wall.length * wall.height - hole.sum() * step * step


@pytest.mark.parametrize("name", ["l_house", "ring_house", "shared_house", "gap_house"])
def test_areas(name, request):
    house = request.getfixturevalue(name)
    parts = by_name(house)
    for room in house.rooms:
        area = Polygon(room.rings[0], room.rings[1:]).area
        assert parts[f"{room.id}/floor"].mesh.area == pytest.approx(area, rel=1e-6)
        assert parts[f"{room.id}/ceiling"].mesh.area == pytest.approx(area, rel=1e-6)
    for wall in house.walls:
        for room_id in wall.room_ids:
            face = parts[f"{room_id}/wall/{wall.id}"]
            assert face.mesh.area == pytest.approx(wall_area(wall), rel=2e-3)


@pytest.mark.parametrize("name", ["l_house", "ring_house", "shared_house", "gap_house"])
def test_surfaces_face_their_room(name, request):
    house = request.getfixturevalue(name)
    parts = by_name(house)
    for room in house.rooms:
        polygon = Polygon(room.rings[0], room.rings[1:])
        floor, ceiling = (parts[f"{room.id}/{name}"].mesh for name in ("floor", "ceiling"))
        assert np.allclose(floor.vertex_normals, [0, 1, 0])
        assert np.allclose(ceiling.vertex_normals, [0, -1, 0])
        assert np.allclose(ceiling.vertices[:, 1], room.height)
        for wall in house.walls_of(room.id):
            face = parts[f"{room.id}/wall/{wall.id}"].mesh
            normal = face.vertex_normals[0, [0, 2]]
            middle = (np.array(wall.start) + np.array(wall.end)) / 2
            inside = middle + 0.05 * normal
            assert polygon.contains(Polygon.from_bounds(*(inside - 1e-6), *(inside + 1e-6)))
            distance = (face.vertices[:, [0, 2]] - np.array(wall.start)) @ normal
            assert np.abs(distance).max() < 1e-3


def test_names_are_unique_and_complete(gap_house):
    names = [part.name for part in build_parts(gap_house)]
    assert len(names) == len(set(names))
    assert "a/door/ha" in names
    assert "b/door/hb" not in names  # the other room's copy of the same door
    assert "a/threshold/ha" in names
    assert "structure/wall/a_w1" in names


def test_twice_the_same_id_gets_a_number(l_house):
    wall = dataclasses.replace(
        l_house.walls[0],
        openings=(
            Opening("x", "window", 0.5, 1.0, 1.0, 2.0),
            Opening("x", "window", 3.0, 3.5, 1.0, 2.0),
        ),
    )
    names = [p.name for p in build_parts(dataclasses.replace(l_house, walls=(wall,)))]
    assert "hall/window/x" in names
    assert "hall/window/x#2" in names


def test_holes_of_both_copies_join(gap_house):
    (portal,) = assemble(gap_house).storeys[0].portals
    assert portal.other == "b"
    assert portal.depth == pytest.approx(0.1)
    np.testing.assert_allclose(np.sort(portal.back[:, 1]), [1.0, 1.8], atol=1e-9)
    np.testing.assert_allclose(portal.back[:, 0], 3.1)


def test_a_door_drawn_once_is_cut_in_the_other_room_too(gap_house):
    walls = tuple(
        dataclasses.replace(w, openings=()) if w.id == "b_w3" else w for w in gap_house.walls
    )
    once = House("once", gap_house.rooms, walls, (Door("a", "ha", "b"),))
    full = by_name(once)["b/wall/b_w3"].mesh.area
    assert full == pytest.approx(4.0 * 2.5 - 0.8 * 2.0, rel=1e-3)
    alone = dataclasses.replace(once, doors=(Door("a", "ha", None),))
    assert by_name(alone)["b/wall/b_w3"].mesh.area == pytest.approx(4.0 * 2.5, rel=1e-3)


def test_wall_body_stays_out_of_rooms(gap_house):
    rooms = [Polygon(room.rings[0]) for room in gap_house.rooms]
    bodies = [body.area for body in assemble(gap_house).storeys[0].bodies]
    for k, body in enumerate(bodies):
        assert all(body.intersection(room).area < 1e-6 for room in rooms)
        assert all(body.intersection(other).area < 1e-6 for other in bodies[k + 1 :])
    assert sum(body.area for body in bodies) > 2.0  # 0.1 m around both rooms and between them


def test_outer_face_has_the_hole(l_house):
    part = by_name(l_house)["structure/wall/hall_w0"]
    outer = part.mesh.vertex_normals[:, 2] < -0.99
    faces = part.mesh.faces[outer[part.mesh.faces[:, 0]]]
    at = part.mesh.vertices[faces].mean(axis=1)
    low = at[(at[:, 1] < 2.5) & (np.abs(at[:, 2] + 0.1) < 1e-6)]
    assert len(low) > 0
    in_door = (low[:, 0] > 1.05) & (low[:, 0] < 1.85) & (low[:, 1] < 2.0)
    assert not in_door.any()


def test_uv_runs_on_round_the_corner_in_metres(l_house):
    parts = by_name(l_house)
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


def test_floor_uv_is_plan_position(l_house):
    floor = by_name(l_house)["hall/floor"]
    np.testing.assert_allclose(floor.uv, floor.mesh.vertices[:, [0, 2]], atol=1e-5)


def test_normals_agree_with_faces(shared_house):
    for part in build_parts(shared_house):
        solid = part.mesh.area_faces > 1e-8
        normals = part.mesh.vertex_normals[part.mesh.faces[solid, 0]]
        cosine = (part.mesh.face_normals[solid] * normals).sum(axis=1)
        assert cosine.min() > 0.999, part.name


def test_doors_and_windows_are_closed_solids(l_house):
    """Frames, leaves, handles and sills: boxes that face outwards, so their volume counts up."""
    parts = by_name(l_house)
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


def test_hole_as_large_as_its_wall_leaves_no_face(l_house):
    gap = Opening("all", "passage", -0.1, 5.1, 0.0, 2.5)
    wall = dataclasses.replace(l_house.walls[0], openings=(gap,))
    names = by_name(dataclasses.replace(l_house, walls=(wall, *l_house.walls[1:])))
    assert "hall/wall/hall_w0" not in names
    assert "hall/passage/all" in names


def test_wall_that_no_outline_knows(l_house):
    """A partition in the middle of a room still gets one face of the right area."""
    free = Wall("free", ("hall",), (0.5, 1.0), (1.5, 1.0), 2.0)
    part = by_name(dataclasses.replace(l_house, walls=(*l_house.walls, free)))
    assert part["hall/wall/free"].mesh.area == pytest.approx(2.0, rel=3e-3)


def test_walls_without_thickness(l_house):
    walls = tuple(dataclasses.replace(w, depth=0.0, extra_height=0.0) for w in l_house.walls)
    parts = by_name(dataclasses.replace(l_house, walls=walls))
    assert parts["hall/wall/hall_w2"].mesh.area == pytest.approx(3.0 * 2.5, rel=1e-3)
    assert "hall/door/front" in parts
    assert not any(name.startswith("structure/wall/hall_w2") for name in parts)


def test_house_without_walls(l_house):
    names = set(by_name(dataclasses.replace(l_house, walls=(), doors=())))
    assert names == {"hall/floor", "hall/ceiling"}


def test_a_window_between_two_rooms_says_where_it_leads(gap_house):
    def glazed(wall):
        openings = tuple(dataclasses.replace(o, kind="window", bottom=1.0) for o in wall.openings)
        return dataclasses.replace(wall, openings=openings)

    walls = tuple(glazed(wall) for wall in gap_house.walls)
    parts = build_parts(dataclasses.replace(gap_house, walls=walls, doors=()))
    found = [part.extras for part in parts if part.extras["kind"] in ("window", "glass")]
    assert [(e["kind"], {e["room_id"], e["leads_to"]}) for e in found] == [
        ("window", {"a", "b"}),
        ("glass", {"a", "b"}),
    ]


def board(house, name):
    return {part.name: part for part in build_parts(house)}[f"{name}/skirting"].mesh


def test_length_is_the_walls_less_the_door(l_house):
    mesh = board(l_house, "hall")
    low, high = mesh.bounds
    assert (low[1], high[1]) == (0.0, pytest.approx(SKIRTING.height))
    # Boxes overlap in the corners, so the volume is of the lengths, not of a union.
    length = 2 * (5.0 + 4.0) - (0.9 + 2 * SKIRTING.frame)
    assert mesh.volume == pytest.approx(length * SKIRTING.height * SKIRTING.depth, rel=1e-3)


def test_it_stands_inside_its_room(l_house):
    low, high = board(l_house, "hall").bounds
    assert low[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert high[[0, 2]] == pytest.approx([5.0, 4.0], abs=1e-6)


def test_no_board_crosses_a_door(gap_house):
    mesh = board(gap_house, "a")
    ray = mesh.ray.intersects_any([[2.5, SKIRTING.height / 2, 1.4]], [[1.0, 0.0, 0.0]])
    assert not ray.any()
    assert mesh.ray.intersects_any([[2.5, SKIRTING.height / 2, 3.0]], [[1.0, 0.0, 0.0]]).all()


def test_bathrooms_have_none(gap_house):
    assert "b/skirting" not in {part.name for part in build_parts(gap_house)}


def test_random_stars_keep_their_area_and_turn():
    rng = np.random.default_rng(3)
    for _ in range(30):
        angle = np.sort(rng.uniform(0, 2 * np.pi, 12))
        radius = rng.uniform(0.5, 4.0, 12)
        star = Polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
        if not star.is_valid:
            continue
        points, faces = triangulate(star)
        areas = signed_areas(points, faces)
        assert (areas > 0).all()
        assert areas.sum() == pytest.approx(star.area, rel=1e-9)


def test_holes_and_several_parts():
    shape = MultiPolygon([box(0, 0, 4, 4).difference(box(1, 1, 2, 3)), box(6, 0, 7, 1)])
    points, faces = triangulate(shape)
    assert signed_areas(points, faces).sum() == pytest.approx(16 - 2 + 1)
    centres = points[faces].mean(axis=1)
    assert not any(1 < x < 2 and 1 < z < 3 for x, z in centres)


def test_nothing_gives_nothing():
    points, faces = triangulate(Polygon())
    assert points.shape == (0, 2)
    assert faces.shape == (0, 3)
