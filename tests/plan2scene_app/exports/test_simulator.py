from dataclasses import replace

import numpy as np
import pytest
import trimesh

from plan2scene.house import IconBox
from plan2scene_app.exports.simulator import write_simulator
from plan2scene_app.exports.solids import house_solids


def test_collision_stands_still_and_each_instance_has_its_own_colour(gap_house, paint, tmp_path):
    gap_house = replace(gap_house, icons=(IconBox("toilet", (4.0, 0.1), (4.4, 0.8)),))
    write_simulator(gap_house, paint(gap_house), tmp_path)
    scene = trimesh.load(tmp_path / "collision.glb")
    solids = {solid.name: solid for solid in house_solids(gap_house)}
    assert set(solids) - set(scene.geometry) == {"a/door/ha/leaf0"}  # it stands open
    for name, mesh in scene.geometry.items():
        assert mesh.volume == pytest.approx(sum(p.volume for p in solids[name].pieces), rel=1e-3)
    header, *rows = (tmp_path / "semantic.txt").read_text().splitlines()
    assert header == "HM3D Semantic Annotations"
    told = {row.split(",")[1]: row.split(",") for row in rows}
    seen = {}
    for name, mesh in trimesh.load(tmp_path / "semantic.glb").geometry.items():
        (colour,) = np.unique(mesh.visual.vertex_colors[:, :3], axis=0)
        seen["".join(f"{c:02X}" for c in colour)] = name
    assert seen.keys() == told.keys() and len(told) == len(rows)
    categories = {seen[colour]: row[2].strip('"') for colour, row in told.items()}
    assert categories["a/floor"] == "floor" and categories["structure/wall/a_w1"] == "wall"
    assert categories["b/object/toilet"] == "toilet"
    assert {told[c][3] for c, name in seen.items() if name.startswith("b/")} == {"1"}
