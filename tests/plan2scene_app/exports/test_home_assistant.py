import numpy as np
import trimesh
import yaml

from plan2scene_app.exports.home_assistant import write_home_assistant


def test_the_card_names_a_lamp_of_every_room(gap_house, paint, tmp_path):
    write_home_assistant(gap_house, paint(gap_house), tmp_path)
    card = yaml.safe_load((tmp_path / "card.yaml").read_text())
    assert card["type"] == "custom:floor3d-card"
    assert (tmp_path / card["objfile"]).is_file() and (tmp_path / card["mtlfile"]).is_file()
    lines = (tmp_path / "house.obj").read_text().splitlines()
    names = [line[2:] for line in lines if line.startswith("o ")]
    lights = {e["entity"]: e["object_id"] for e in card["entities"] if e["type3d"] == "light"}
    assert lights == {"light.a": "a/lamp", "light.b": "b/lamp"}
    assert set(lights.values()) <= set(names) and len(set(names)) == len(names)
    assert {zoom["object_id"] for zoom in card["zoom_areas"]} == {"a/floor", "b/floor"} <= {*names}
    files = [path.name for path in (tmp_path / "house_textures").iterdir()]
    assert not [name for name in (*names, *files) if "ceiling" in name]
    low, high = trimesh.load(tmp_path / "house.obj", group_material=False, split_object=True).bounds
    assert np.allclose(low[[0, 2]], 0.0, atol=0.01)  # the corner of the plan, centimetres
    assert 600 < high[0] < 640 and 240 < high[1] < 300


def test_objects_tell_their_storey_as_the_card_reads_it(storey_house, paint, tmp_path):
    write_home_assistant(storey_house, paint(storey_house), tmp_path)
    lines = (tmp_path / "house.obj").read_text().splitlines()
    levels = {level.id: f"lvl{k:03d}" for k, level in enumerate(storey_house.levels)}
    for room in storey_house.rooms:
        assert {f"o {levels[room.level]}{room.id}/{x}" for x in ("lamp", "floor")} <= {*lines}
