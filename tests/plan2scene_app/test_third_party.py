import logging
import os
import subprocess
import sys

import pytest

from plan2scene.io import write_json
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.textures.methods import texture_methods
from plan2scene_app.workflow.closures import export_code, method_code, reader_code

pytestmark = pytest.mark.usefixtures("toy_installed")


def plan2scene(*arguments, cwd):
    main = "from plan2scene_app.cli import main; main()"
    command = [sys.executable, "-c", main, *map(str, arguments)]
    wide = os.environ | {"COLUMNS": "200"}
    done = subprocess.run(command, cwd=cwd, env=wide, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_command_uses_them_by_name(storey_house, tmp_path):
    assert "toy" in plan2scene("methods", cwd=tmp_path)
    assert "toy" in plan2scene("run", "--help", cwd=tmp_path)
    write_scene_json(storey_house, tmp_path / "out" / "house.scene.json")
    write_json(tmp_path / "out/textures/textures.json", {"method": "toy", "surfaces": {}})
    made = plan2scene("export", "out", "--to", "rooms", cwd=tmp_path).split()
    assert made == ["out/rooms/rooms.txt"]
    assert (tmp_path / made[0]).read_text().split() == [room.id for room in storey_house.rooms]


def test_what_cannot_be_used_is_warned_of_and_left_out(caplog):
    with caplog.at_level(logging.WARNING):
        methods = texture_methods()
    assert methods["crop"].summary != "another one"
    lines = [record.getMessage() for record in caplog.records]
    expected = ("NOTHING", "not a TextureMethod", "another one is called crop")
    assert [any(text in line for line in lines) for text in expected] == [True] * 3
    assert all("plan2scene-toy 0.3" in line for line in lines)


def test_a_rule_depends_on_the_version_of_others_and_on_our_source():
    assert method_code("toy") == export_code("rooms") == reader_code(".square")
    assert method_code("toy") == ["plan2scene-toy 0.3"]
    (ours,) = method_code("crop")
    assert ours != export_code("obj")[0] and len(ours) == 16
