import os
from dataclasses import replace
from pathlib import Path

import pytest
from places import PLAN

from plan2scene.errors import InputError
from plan2scene_app import run as runs
from plan2scene_app.run import SingleHouse, prepare


@pytest.fixture
def given(tmp_path):
    """A plan, a photo table and two photos; the second of each is older than the first."""
    for number, time in (("1", 2_000_000_000), ("2", 1_000_000_000)):
        folder = tmp_path / number
        folder.mkdir()
        for name in ("plan.json", "photos.csv", "a.jpg", "b.jpg"):
            (folder / name).write_text(f"{name} {number}")
            os.utime(folder / name, (time, time))
    return tmp_path


def request(folder):
    return SingleHouse(
        folder / "plan.json", folder / "photos.csv", None, "h", "exemplar", None, 0, 128
    )


def test_copies_follow_the_contents_of_what_is_given_whatever_their_time(given):
    work = given / "work"
    prepare(request(given / "1"), ["a.jpg", "b.jpg"], work)
    copies = {
        "plan.json": work / "dataset/plan.json",
        "photos.csv": work / "dataset/photoroom.csv",
        "a.jpg": work / "dataset/photos/a.jpg",
    }
    before = {name: copy.stat().st_mtime_ns for name, copy in copies.items()}
    prepare(request(given / "2"), ["a.jpg", "b.jpg"], work)
    for name, copy in copies.items():
        assert copy.read_text() == f"{name} 2" and copy.stat().st_mtime_ns > before[name]
    prepare(request(given / "1"), ["a.jpg"], work)
    before = (work / "dataset/photos/a.jpg").stat().st_mtime_ns
    os.utime(given / "1" / "a.jpg", (10, 10))
    prepare(request(given / "1"), ["a.jpg"], work)
    assert (work / "dataset/photos/a.jpg").stat().st_mtime_ns == before
    prepare(request(given / "1"), ["a.jpg", "b.jpg"], work)
    (given / "1" / "b.jpg").unlink()
    prepare(request(given / "1"), ["a.jpg", "b.jpg"], work)
    assert not (work / "dataset/photos/b.jpg").exists()


def test_what_is_wanted_first_lies_there_before_the_rest_is_made(given, monkeypatch):
    seen, viewer = [], given / "out" / "viewer.html"

    def make(targets, config, folder, options):
        seen.append([len(targets), viewer.is_file() and viewer.stat().st_mtime_ns])
        for target in (*targets, str(Path(targets[0]).parent / "textures" / "a.png")):
            (folder.work / target).parent.mkdir(parents=True, exist_ok=True)
            (folder.work / target).write_text("made")

    monkeypatch.setattr(runs, "_make", make)
    plan = replace(request(given), plan=PLAN, photo_table=None)
    runs.run(plan, given / "out", cores=1, first=("viewer.html",))
    assert seen == [[1, False], [5, viewer.stat().st_mtime_ns]]  # nor is it copied again


def test_a_table_names_the_views_of_a_panorama(given, tmp_path):
    (table := given / "1" / "photos.csv").write_text("photo,room_id\na.jpg,hall\nb.jpg,bath\n")
    views = {"a.jpg": {f"a_{k}.jpg": given / "1" / "b.jpg" for k in (1, 2)}}
    asked = replace(request(table.parent), views=views)
    prepare(asked, ["a_1.jpg", "a_2.jpg", "b.jpg"], tmp_path)
    rows = (tmp_path / "dataset" / "photoroom.csv").read_text().splitlines()
    assert rows == ["room_id,photo", "hall,a_1.jpg", "hall,a_2.jpg", "bath,b.jpg"]
    names = sorted(path.name for path in (tmp_path / "dataset" / "photos").iterdir())
    assert names == ["a_1.jpg", "a_2.jpg", "b.jpg"]
    corrected = given / "2" / "photos.csv"
    corrected.write_text("photo,room_id,guess\na_2.jpg,bath,\nb.jpg,hall,hall\n")
    prepare(replace(asked, corrections=corrected), ["a_1.jpg", "a_2.jpg", "b.jpg"], tmp_path)
    rows = (tmp_path / "dataset" / "photoroom.csv").read_text().splitlines()
    assert rows == ["room_id,photo", "hall,a_1.jpg", "bath,a_2.jpg", "bath,b.jpg"]
    asked = replace(asked, photo_table=None, photos_dir=table.parent, corrections=table)
    prepare(asked, ["b.jpg", "c.jpg"], tmp_path)
    rows = (tmp_path / "dataset" / "photoroom.csv").read_text().splitlines()
    assert rows == ["room_id,photo", "bath,b.jpg", ",c.jpg"]
    with pytest.raises(InputError, match=r"1/photos\.csv, .* room bath: expected a room of the"):
        runs.read_input(replace(asked, plan=PLAN))


def test_a_table_or_plan_of_a_run_that_was_changed_by_hand_is_used(given, monkeypatch, caplog):
    seen, out, asked = [], given / "2", request(given / "1")
    monkeypatch.setattr(runs, "_views", lambda *_: {})
    monkeypatch.setattr(runs, "read_input", lambda one: seen.append(one.corrections) or 1 / 0)
    (out / "work").mkdir()
    (out / "work" / "delivered.json").write_text('{"digests": {"photos.csv": [], "plan.json": []}}')
    asked.plan.write_bytes(b"\x89PNG")
    for table in (asked.photo_table, out / "photos.csv"):
        with pytest.raises(ZeroDivisionError):
            runs.run(replace(asked, photo_table=table), out, cores=1)
    assert seen == [out / "photos.csv", None]
    assert caplog.text.count("its rooms are used") == 1 and caplog.text.count("--plan") == 2
    monkeypatch.undo()
    (given / "1" / "photos.csv").write_text("room_id,photo\n")
    assert runs.read_input(replace(asked, plan=PLAN)) == []
    assert "1/photos.csv: expected at least one photo, found none" in caplog.text


@pytest.mark.parametrize(("installed", "masks"), [(True, "imagenet"), (False, "embedded")])
def test_photos_are_labelled_by_the_best_that_is_installed(given, monkeypatch, installed, masks):
    monkeypatch.setattr(runs, "imagenet_installed", lambda: installed)
    assert f"masks: {masks}" in prepare(request(given / "1"), ["a.jpg"], given / "work").read_text()
