import shutil

from browser import pages_and_photos
from places import PLAN
from typer.testing import CliRunner

from plan2scene.errors import WorkflowError
from plan2scene_app import homes
from plan2scene_app.bound_process import EndedError
from plan2scene_app.cli import app


def test_plans_are_found_and_a_home_that_fails_stops_no_other(tmp_path, monkeypatch):
    storeys = ["plan_first_floor.png", "plan_ground_floor.png"]
    pages = {"a b": ["p07.png"], "fails": ["Grundriss.png", "map.png"], "storeys": storeys}
    for name, names in (pages | {"drawn": ["p07.png"], ".hidden": []}).items():
        pages_and_photos(tmp_path / name, *names)
    (tmp_path / "bad").mkdir()
    shutil.copy(PLAN, tmp_path / "drawn" / "plan.json")
    shutil.make_archive(str(tmp_path / "zipped"), "zip", tmp_path / ".hidden")
    (tmp_path / "out" / "a b").mkdir(parents=True)
    made, ended = {}, False

    def run(request, out, **_):
        made[out.name] = [path.name for path in (request.plan, *request.storeys)]
        if out.name == "fails":
            (out / "work" / "logs").mkdir(parents=True, exist_ok=True)
            (out / "work" / "logs" / f"{request.house}.log").write_text("ERROR no room\n")
            raise WorkflowError("the workflow failed")
        if ended:
            raise EndedError("ended")

    monkeypatch.setattr(homes, "run", run)
    asked = ["run", "--homes", str(tmp_path), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, asked)
    found = pages | {"fails": ["Grundriss.png"], "drawn": ["plan.json"]}
    assert made == found | {"zipped": ["floorplan.jpg"]}
    first, bad, fails = result.output.splitlines()[-3:]
    assert result.exit_code == 1 and first.startswith("4 of 6 homes are made")
    assert bad.startswith("bad failed: ") and bad.endswith("plan_ground_floor.jpg, found none")
    assert fails.startswith("fails failed: no room")
    made.clear()
    ended = True
    assert isinstance(CliRunner().invoke(app, asked).exception, EndedError)
    assert list(made) == ["a b"]
