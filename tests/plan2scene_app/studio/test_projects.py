import io
import json
import sys
import time
from functools import partial

import pillow_heif
import psutil
import pytest
from PIL import Image
from places import PLAN

from plan2scene.datasets.assignments import read_assignment
from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene_app.studio import runs
from plan2scene_app.studio.projects import Conflict, Projects


def photo(tmp_path, colour="red"):
    path = tmp_path / f"{colour}.png"
    Image.new("RGB", (32, 24), colour).save(path)
    return path.read_bytes()


def state(project, **changes):
    plan = json.loads(PLAN.read_text())
    return {"plan": plan, "photos": [], "place": None, "revision": project.revision()} | changes


def test_what_is_saved_is_what_run_reads(project, tmp_path):
    project.add_photo("a.png", photo(tmp_path))
    photos = [{"name": "a.png", "rooms": ["hall", "living"]}, {"name": "b.png", "rooms": []}]
    place = {"x": 1, "z": 2, "metres_per_pixel": 0.01, "opacity": 0.5, "visible": True}
    revision = project.save(state(project, photos=photos, place=place, notes=["a doubt"]))
    house = read_plan(project.path / "plan.json", "home")
    rows = read_assignment(project.path / "photos.csv", house)
    # The run looks for the room of a photo that has none.
    assert {tuple(row) for row in rows} == {("hall", "a.png"), ("living", "a.png"), ("", "b.png")}
    again = project.state()
    assert again["revision"] == revision and again["notes"] == ["a doubt"]
    assert sorted(again["photos"], key=lambda p: p["name"]) == photos
    assert again["place"] is None  # there is no picture
    (project.path / "plan_picture.png").write_bytes(photo(tmp_path))
    assert project.state()["place"] == place


def test_two_tabs_never_overwrite_each_other_or_a_file_that_did_not_change(project):
    first = state(project)
    project.save(state(project))
    with pytest.raises(Conflict):
        project.save(first)
    mine = state(project)
    (project.path / "photos.csv").write_text("room_id,photo\nhall,c.jpg\n")
    with pytest.raises(Conflict):
        project.save(mine)
    assert project.state()["photos"] == [{"name": "c.jpg", "rooms": ["hall"]}]
    before = (project.path / "plan.json").stat().st_mtime_ns
    project.save(state(project, photos=[{"name": "a.png", "rooms": ["hall"]}]))
    assert (project.path / "plan.json").stat().st_mtime_ns == before


def test_photos_are_checked_and_kept(project, tmp_path):
    project.add_photo("a.png", photo(tmp_path))
    project.add_photo("a.png", photo(tmp_path))
    with pytest.raises(InputError, match="no other photo"):
        project.add_photo("a.png", photo(tmp_path, "blue"))
    with pytest.raises(InputError, match=r"b\.jpg: expected"):
        project.add_photo("b.jpg", b"no picture")
    heic = io.BytesIO()
    pillow_heif.from_pillow(Image.new("RGB", (64, 48))).save(heic)
    project.add_photo("phone.HEIC", heic.getvalue())
    for name in ("../a.png", "/etc/a.png", "a/b.png", ".png", "a.svg", "a\\b.png", "a.png\n"):
        with pytest.raises(InputError):
            project.add_photo(name, photo(tmp_path))
    assert sorted(path.name for path in project.photos.iterdir()) == ["a.png", "phone.HEIC"]
    assert (project.photos / "a.png").read_bytes() == photo(tmp_path)


@pytest.mark.parametrize(
    "changes",
    [
        {"plan": None},
        {"plan": {"format": "other"}},
        {"photos": [{"name": "../x.png", "rooms": []}]},
        {"photos": [{"name": "x.png"}]},
        {"place": {"x": "left"}},
        {"notes": "all"},
    ],
)
def test_only_what_the_editor_holds_is_saved(project, changes):
    with pytest.raises(InputError):
        project.save(state(project, **changes))
    assert not (project.path / "plan.json").exists()


def test_names_and_links_of_projects(tmp_path):
    projects = Projects(tmp_path / "homes")
    projects.make("home")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "plan.json").write_text("{}")
    (tmp_path / "homes" / "link").symlink_to(tmp_path / "other")
    assert projects.names() == ["home"]
    for name in ("home", " ", ""):
        with pytest.raises(InputError):
            projects.make(name)
    named = {"..": "home_2", "a/b": "a_b", ".hidden": "hidden", "link": "link_2", "Дача": "home_3"}
    for name, own in named.items():
        made = projects.make(name)
        assert (made.name, made.title, made.path.parent) == (own, name, tmp_path / "homes")
    for name in ("..", "link", "other"):
        with pytest.raises(InputError, match="moved or deleted"):
            projects.get(name)


JOB = """
import json, os, sys, time
with open(sys.argv[1] + "/run_events.jsonl", "w") as file:
    for event, told in (("planned", {"jobs": {"masks": 1}}), ("started", {"rule": "masks"})):
        file.write(json.dumps({"event": event, **told}) + "\\n")
child = os.fork()
time.sleep(60)
"""


def test_a_run_is_seen_and_cancelled_by_any_server(project, monkeypatch):
    monkeypatch.setattr(runs, "JOB", (sys.executable, "-c", JOB))
    for wrong in ({"method": "rm -rf"}, {"method": []}, {"texture_size": 9}, {"colours": "none"}):
        with pytest.raises(InputError):
            runs.settings_of(wrong, 1)
    settings = runs.settings_of({}, 1)
    assert runs.status(project)["state"] == "none"
    runs.start(project, settings)
    while not (found := runs.status(project))["stages"]:
        time.sleep(0.05)
    # Nothing of this is in memory: another server would see the same.
    assert found["state"] == "running" and found["stages"][0]["state"] == "running"
    with pytest.raises(InputError, match="under way"):
        runs.start(project, settings)
    process = psutil.Process(json.loads((project.path / "run.json").read_text())["pid"])
    family = [process, *process.children(recursive=True)]
    assert len(family) == 2
    wait = psutil.wait_procs  # as it ends, the owner goes on: the new run is not told as cancelled
    with monkeypatch.context() as patch:
        go_on = partial(runs.start, project, settings)
        patch.setattr(psutil, "wait_procs", lambda ps, **n: (wait(ps, **n), ps or go_on())[0])
        runs.cancel(project)
    assert runs.status(project)["state"] == "running"
    runs.cancel(project)
    assert runs.status(project)["state"] == "cancelled"
    assert not any(p.is_running() and p.status() != "zombie" for p in family)


def test_a_bad_plan_or_a_record_of_another_form_is_a_failed_run(project):
    plan = json.loads(PLAN.read_text())
    plan["rooms"][0]["types"] = ["Ballroom"]
    project.save(state(project, plan=plan))
    runs.start(project, runs.settings_of({}, 1))
    while (found := runs.status(project))["state"] != "failed":
        time.sleep(0.05)
    assert "room living: expected a room type" in found["fault"]
    assert "'Ballroom'" in found["fault"] and found["stages"] == []
    (project.path / "run.json").write_text("[]")
    assert runs.status(project)["state"] == "failed"
    runs.cancel(project)
