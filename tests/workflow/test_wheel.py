import json
import os
import subprocess
import sys
from pathlib import Path

from kills import house_command, kill_often, strays
from places import ROOT

from plan2scene.plans.scene_json import read_scene_json

#: One photo a level keeps the test short.
TABLE = "room_id,photo\nkitchen,kitchen_0.jpg\nbedroom,bedroom_0.jpg\n"


def test_the_wheel_makes_a_house_though_it_is_killed(tmp_path, tmp_path_factory):
    root = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(root), str(ROOT)]
    subprocess.run([*pip, *build], check=True, cwd=root)
    (wheel,) = root.glob("plan2scene-*.whl")
    site = root / "site"
    subprocess.run([*pip, "install", "--no-deps", "--target", str(site), str(wheel)], check=True)
    installed = site
    example = installed / "plan2scene" / "_workflow" / "resources" / "examples" / "two_storeys"
    assert (example / "photos.csv").read_text().count("\n") == 7
    (tmp_path / "photos.csv").write_text(TABLE)
    given = ["--photos", "photos.csv", "--photos-dir", str(example / "photos"), "--house", "two"]
    options = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(installed)}}
    where = [sys.executable, "-c", "import plan2scene; print(plan2scene.__file__)"]
    assert str(installed) in subprocess.run(where, capture_output=True, text=True, **options).stdout
    command = house_command(example / "plan.json", Path("house"), *given)
    assert kill_often(command, 1, 30.0, seed=10, **options) > 0
    assert strays(tmp_path / "house") == []
    assert_both_storeys(tmp_path / "house")


def assert_both_storeys(out):
    """Every floor is textured on its level; photos tell of rooms of their own level alone."""
    house = read_scene_json(out / "house.scene.json", "two")
    assert [level.id for level in house.levels] == ["ground", "upper"]
    data = (out / "house.glb").read_bytes()
    tree = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    extras = {node["name"]: node.get("extras", {}) for node in tree["nodes"]}
    assert extras["hall/stairs/stairs"]["leads_to"] == "landing"
    for room in house.rooms:
        floor = extras[f"{room.id}/floor"]
        assert floor["level"] == room.level
        assert floor["substance"]
    observed = {room.id for room in house.rooms if extras[f"{room.id}/floor"]["observed"]}
    assert {"kitchen", "bedroom"} <= observed
    assert "study" not in observed  # right above the kitchen
    (file,) = (out / "work").glob("results/*/drop_0.0/*/two/textures/textures.json")
    made = json.loads(file.read_text())["surfaces"]
    assert all("/kitchen_0" in crop for crop in made["kitchen/floor"]["crops"])
    (file,) = (out / "work").glob("results/*/houses/two/cameras.json")
    for name, camera in json.loads(file.read_text()).items():
        assert camera["room_id"] in (None, name.rsplit("_", 1)[0])
    assert (out / "viewer.html").stat().st_size > 500_000
