"""An installed wheel, away from the clone, makes its example of two storeys, with photos."""

import json
import os
import subprocess
import sys
from pathlib import Path

from plan2scene.plans.scene_json import read_scene_json

ROOT = Path(__file__).parents[2]
#: One photo a level keeps the test short.
TABLE = "room_id,photo\nkitchen,kitchen_0.jpg\nbedroom,bedroom_0.jpg\n"


def test_the_wheel_makes_a_house_from_an_empty_directory(tmp_path):
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    wheels, site, work = tmp_path / "wheels", tmp_path / "site", tmp_path / "work"
    work.mkdir()
    build = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(wheels), str(ROOT)]
    subprocess.run([*pip, *build], check=True, cwd=tmp_path)
    (wheel,) = wheels.glob("plan2scene-*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", str(site), str(wheel)], check=True)
    example = site / "plan2scene" / "_workflow" / "resources" / "examples" / "two_storeys"
    assert (example / "photos.csv").read_text().count("\n") == 7
    (work / "photos.csv").write_text(TABLE)
    given = ["--plan", str(example / "plan.json"), "--photos", "photos.csv"]
    given += ["--photos-dir", str(example / "photos"), "--out", "house", "--house", "two"]
    command = "import plan2scene, sys; sys.stderr.write(plan2scene.__file__)"
    program = f"{command}; from plan2scene_app.cli import main; main()"
    run = subprocess.run(
        [sys.executable, "-c", program, "run", *given],
        cwd=work,
        env=os.environ | {"PYTHONPATH": str(site)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-4000:]
    assert str(site) in run.stdout
    assert_both_storeys(work / "house")


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
