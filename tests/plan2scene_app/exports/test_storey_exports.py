import numpy as np
import pytest
import trimesh
import yaml
from PIL import Image

from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.exports.occupancy import FREE, OCCUPIED, RESOLUTION_M, UNKNOWN
from plan2scene_app.exports.registry import export_house
from plan2scene_app.exports.simulator import mjcf_text, write_simulator
from plan2scene_app.exports.solids import house_solids


@pytest.fixture(scope="module")
def solids(storey_house):
    return {solid.name: solid for solid in house_solids(storey_house)}


def test_bodies_are_closed_and_at_their_level(solids):
    assert all(piece.is_watertight for solid in solids.values() for piece in solid.pieces)
    assert solids["bedroom/floor"].pieces[0].bounds[:, 1] == pytest.approx([2.7, 2.8])
    landing = sum(piece.volume for piece in solids["landing/floor"].pieces)
    assert landing == pytest.approx((2.4 * 6 + 2.2 - 0.9 * 3.6) * 0.1)
    assert solids["hall/stairs/stairs"].category == "stairs"
    assert len(solids["hall/stairs/stairs"].pieces) == 15


def test_each_level_has_its_map(storey_house, tmp_path):
    write_scene_json(storey_house, tmp_path / "scene.json")
    (tmp_path / "textures.json").write_text('{"surfaces": {}}')
    out = tmp_path / "out"
    written = export_house(tmp_path / "scene.json", tmp_path, out, "map", house_id="two")
    names = sorted(path.name for path in out.glob("[!.]*"))
    assert names == ["map.pgm", "map.yaml", "map_upper.pgm", "map_upper.yaml"]
    assert sorted(path.name for path in written) == names

    def at(name, x, z):
        facts = yaml.safe_load((out / f"{name}.yaml").read_text())
        grid = np.asarray(Image.open(out / facts["image"]))
        column = int((x - facts["origin"][0]) / RESOLUTION_M)
        return grid[grid.shape[0] - 1 - int((-z - facts["origin"][1]) / RESOLUTION_M), column]

    assert at("map", -0.4, -0.4) == UNKNOWN
    assert at("map", 4.5, 5.0) == FREE  # the kitchen, below the bathroom's wall
    assert at("map_upper", 4.6, 5.0) == OCCUPIED
    assert at("map", 0.45, 2.0) == OCCUPIED  # the stairs
    assert at("map_upper", 0.45, 2.0) == OCCUPIED  # the well
    assert at("map_upper", 0.45, 0.5) == FREE


def test_a_ball_rests_on_both_floors_and_falls_through_the_well(storey_house, solids):
    mujoco = pytest.importorskip("mujoco")
    text = mjcf_text(storey_house, list(solids.values()))
    spots = {"bedroom": (5.0, 3.6, 1.5), "living": (5.0, 0.8, 1.5), "well": (0.45, 3.4, 4.4)}
    rests = {}
    for name, (x, y, z) in spots.items():
        ball = f'<body pos="{x} {-z} {y}"><freejoint/><geom size="0.1" mass="1"/></body>'
        model = mujoco.MjModel.from_xml_string(text.replace("</worldbody>", f"{ball}</worldbody>"))
        data = mujoco.MjData(model)
        while data.time < 1.2:
            mujoco.mj_step(model, data)
        rests[name] = data.body(model.nbody - 1).xpos[2]
    assert rests["bedroom"] == pytest.approx(2.8 + 0.1, abs=0.02)
    assert rests["living"] == pytest.approx(0.1, abs=0.02)
    assert 0.05 < rests["well"] < 1.0  # on the steps below, or down them


def test_the_simulator_pack_has_every_level(storey_house, paint, tmp_path):
    write_simulator(storey_house, paint(storey_house), tmp_path)
    for name in ("house.glb", "collision.glb", "semantic.glb"):
        scene = trimesh.load(tmp_path / name)
        assert scene.bounds[1, 1] == pytest.approx(2.8 + 2.535, abs=0.07), name
    rows = (tmp_path / "semantic.txt").read_text().splitlines()[1:]
    regions = {row.split(",")[3] for row in rows}
    assert regions == {str(k) for k in range(-1, len(storey_house.rooms))}
    assert any('"stairs"' in row for row in rows)
