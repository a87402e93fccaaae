from collections import defaultdict
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
import shapely

from plan2scene.plans.validate import validate_house
from plan2scene_workshop.homes.floorplans import generate_house

HOUSES = [generate_house(f"house_{k}", 3) for k in range(40)]


def opening_segments(house):
    segments = defaultdict(list)
    for wall in house.walls:
        start = np.array(wall.start)
        along = (np.array(wall.end) - start) / wall.length
        for opening in wall.openings:
            ends = [tuple(start + along * t) for t in (opening.start, opening.end)]
            segments[opening.id].append(tuple(np.round(sorted(ends), 3).ravel()))
    return segments


@pytest.mark.parametrize("house", HOUSES, ids=lambda h: h.id)
def test_plan_is_valid_and_every_room_is_reachable(house):
    assert validate_house(house) == [] and 4 <= len(house.rooms) <= 10
    assert all(2.3 <= room.height <= 3.0 for room in house.rooms)
    polygons = [shapely.Polygon(room.rings[0]) for room in house.rooms]
    union = shapely.unary_union(polygons)
    assert union.area == pytest.approx(sum(p.area for p in polygons), rel=1e-6)
    assert union.geom_type == "Polygon" and not union.interiors
    for room in house.rooms:
        lengths = sum(wall.length for wall in house.walls_of(room.id))
        assert lengths == pytest.approx(shapely.Polygon(room.rings[0]).length, rel=1e-6)
    graph = nx.Graph(house.adjacency())
    graph.add_nodes_from(room.id for room in house.rooms)
    assert nx.is_connected(graph)


@pytest.mark.parametrize("house", HOUSES, ids=lambda h: h.id)
def test_openings_are_in_the_walls_of_their_rooms(house):
    """A door between rooms is in two walls at the same place, an outer opening in one."""
    assert sum(door.room_b is None for door in house.doors) == 1
    outer = {door.opening_id for door in house.doors if door.room_b is None}
    kinds = {o.id: o.kind for wall in house.walls for o in wall.openings}
    segments = opening_segments(house)
    rim = shapely.unary_union([shapely.Polygon(r.rings[0]) for r in house.rooms]).exterior
    for name, kind in kinds.items():
        assert len(segments[name]) == (1 if (kind == "window" or name in outer) else 2)
        assert len(set(segments[name])) == 1
        line = shapely.LineString(np.reshape(segments[name][0], (2, 2)))
        assert kind != "window" or rim.buffer(1e-2).contains(line)
    assert {door.opening_id for door in house.doors} == {n for n in kinds if kinds[n] != "window"}
    for wall in house.walls:
        assert all(a.end <= b.start for a, b in pairwise(wall.openings))


def test_same_seed_same_house():
    assert generate_house("house_7", 3) == HOUSES[7]
    assert generate_house("house_7", 4) != HOUSES[7]
