"""The real sample plans: areas of floors and walls after loading the GLB again."""

import pytest
import trimesh
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from plan2scene.mesh import write_glb


@pytest.mark.shared
def test_areas(sample_house, paint, tmp_path):
    write_glb(sample_house, paint(sample_house), tmp_path / "house.glb")
    geometry = trimesh.load(tmp_path / "house.glb").geometry
    for room in sample_house.rooms:
        area = Polygon(room.rings[0], room.rings[1:]).area
        assert geometry[f"{room.id}/floor"].area == pytest.approx(area, rel=1e-3)
        assert geometry[f"{room.id}/ceiling"].area == pytest.approx(area, rel=1e-3)
    for wall in sample_house.walls:
        rectangle = box(0, 0, wall.length, wall.height)
        holes = unary_union([box(o.start, o.bottom, o.end, o.top) for o in wall.openings])
        area = rectangle.difference(holes).area
        for room_id in wall.room_ids:
            face = geometry[f"{room_id}/wall/{wall.id}"]
            assert face.area == pytest.approx(area, rel=5e-3), wall.id
    openings = {o.id for wall in sample_house.walls for o in wall.openings}
    parts = {name.split("/")[1] for name in geometry}
    assert {"door", "structure"} <= parts | {name.split("/")[0] for name in geometry}
    assert sum("/door/" in n or "/window/" in n for n in geometry) <= 2 * len(openings)
