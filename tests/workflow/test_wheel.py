"""An installed wheel, away from the clone, makes a house: the workflow travels in the package."""

import os
import subprocess
import sys
from pathlib import Path

import trimesh

ROOT = Path(__file__).parents[2]


def test_the_wheel_makes_a_house_from_an_empty_directory(tmp_path):
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    wheels, site, work = tmp_path / "wheels", tmp_path / "site", tmp_path / "work"
    work.mkdir()
    build = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(wheels), str(ROOT)]
    subprocess.run([*pip, *build], check=True, cwd=tmp_path)
    (wheel,) = wheels.glob("plan2scene-*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", str(site), str(wheel)], check=True)
    plan = site / "plan2scene" / "_workflow" / "resources" / "examples" / "plan.json"
    command = "import plan2scene, sys; sys.stderr.write(plan2scene.__file__)"
    program = f"{command}; from plan2scene.cli import main; main()"
    run = subprocess.run(
        [sys.executable, "-c", program, "run", "--plan", str(plan), "--out", "house"],
        cwd=work,
        env=os.environ | {"PYTHONPATH": str(site)},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-4000:]
    assert str(site) in run.stdout
    assert trimesh.load(work / "house" / "house.glb").geometry
