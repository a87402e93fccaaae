import os
import subprocess
import sys

import pytest

from plan2scene.errors import InputError
from plan2scene_app.out_folder import changed_by_hand, claimed_folder

NAMES = ("house.glb", "textures")


@pytest.fixture
def made(tmp_path):
    (tmp_path / "made" / "textures").mkdir(parents=True)
    (tmp_path / "made" / "house.glb").write_bytes(b"new")
    for name in ("a_floor.png", ".snakemake_timestamp"):
        (tmp_path / "made" / "textures" / name).write_bytes(b"new")
    return {name: tmp_path / "made" / name for name in NAMES}


def refused(out, words, *inputs):
    with pytest.raises(InputError, match=words), claimed_folder(out, NAMES, inputs):
        pass


def snapshot(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "work" not in path.relative_to(folder).parts
    }


def test_results_take_the_place_of_earlier_ones_and_files_of_the_user_are_told(tmp_path, made):
    out = tmp_path / "out"
    for content in (b"new", b"newer"):
        made["house.glb"].write_bytes(content)
        with claimed_folder(out, NAMES, []) as folder:
            folder.deliver(made)
        assert snapshot(out) == {"house.glb": content, "textures/a_floor.png": b"new"}

    made["textures"].joinpath("a_floor.png").rename(made["textures"] / "b_floor.png")
    with claimed_folder(out, NAMES, []) as folder:
        folder.deliver(made)
    assert set(snapshot(out)) == {"house.glb", "textures/b_floor.png"}
    (out / "textures" / "mine.png").write_bytes(b"mine")
    refused(out, r"found textures/mine\.png")
    assert (out / "textures" / "mine.png").read_bytes() == b"mine"


@pytest.mark.parametrize("name", ["textures/mine.png", "house.glb", "work/notes.txt"])
def test_what_no_run_delivered_is_refused_and_stays(tmp_path, name):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(b"mine")
    refused(tmp_path, "found")
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == [path]


@pytest.mark.parametrize("name", ["house.glb", "textures/plan.json", "work/plan.json", "."])
def test_an_input_or_a_file_in_the_way_is_refused(tmp_path, name):
    refused(tmp_path, "overwrite the input", (tmp_path / name))
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "out").write_text("mine")
    refused(tmp_path / "out", "found a file")


def test_a_second_run_is_refused_while_the_first_or_its_child_lives(tmp_path):
    lock = tmp_path / "work" / ".snakemake" / "locks" / "0.output.lock"
    with claimed_folder(tmp_path, NAMES, []) as folder:
        lock.mkdir(parents=True)
        code = [sys.executable, "-c", "input()"]
        child = subprocess.Popen(code, stdin=subprocess.PIPE, pass_fds=(folder.lock,))
        refused(tmp_path, "a run that is under way")
    refused(tmp_path, "a run that is under way")
    child.kill()
    child.wait()
    with claimed_folder(tmp_path, NAMES, []):
        assert not lock.parent.exists()


def test_what_is_left_of_a_killed_run_is_waited_for(tmp_path, caplog):
    holds = f"""
import os, subprocess, sys
from pathlib import Path
from plan2scene_app.out_folder import changed_by_hand, claimed_folder
with claimed_folder(Path({str(tmp_path)!r}), (), []) as folder:
    code = "import time; time.sleep(1.5)"
    subprocess.Popen([sys.executable, "-c", code], pass_fds=(folder.lock,))
    os._exit(1)
"""
    subprocess.run([sys.executable, "-c", holds], check=False)
    with claimed_folder(tmp_path, NAMES, []):
        (record,) = caplog.records
    assert record.getMessage().startswith(f"{tmp_path}: waiting until the processes of a killed")


def test_what_the_user_changed_since_stays(tmp_path, made, caplog):
    for content in (b"new", b"newer", b"newest"):
        made["house.glb"].write_bytes(content)
        with claimed_folder(tmp_path / "out", NAMES, []) as folder:
            folder.deliver(made)
        if content == b"newer":
            (tmp_path / "out" / "house.glb").write_bytes(b"mine")
        assert changed_by_hand(tmp_path / "out", "house.glb") == (content != b"new")
    assert (tmp_path / "out" / "house.glb").read_bytes() == b"mine"
    assert "house.glb was changed since the last run: it stays" in caplog.text


def test_a_failed_delivery_keeps_what_was_there(tmp_path, made, monkeypatch):
    out = tmp_path / "out"
    with claimed_folder(out, NAMES, []) as folder:
        folder.deliver(made)
    before = snapshot(out)
    made["house.glb"].write_bytes(b"x" * 100_000)
    for name in ("shutil.copyfile", "shutil.copytree"):

        def full(*_, **__):
            raise OSError(28, os.strerror(28))

        with monkeypatch.context() as patch, pytest.raises(OSError, match="No space"):
            patch.setattr(name, full)
            with claimed_folder(out, NAMES, []) as folder:
                folder.deliver(made)
        whole = made["house.glb"].read_bytes() if name == "shutil.copytree" else before["house.glb"]
        assert snapshot(out) == {**before, "house.glb": whole}
