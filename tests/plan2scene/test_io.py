import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from plan2scene import io as p2s_io
from plan2scene.errors import InputError

NAMES = ["../x.jpg", "/etc/passwd", "a/../../x", "", " x", "a\\b", "C:x", "a\nb", "./x", "a//b"]


@pytest.mark.parametrize("name", [*NAMES, "{x}.jpg", "n" * 300, "d" * 300 + "/x"])
def test_names_that_leave_the_folder_are_refused_and_others_joined(tmp_path, name):
    with pytest.raises(InputError):
        p2s_io.safe_join(tmp_path, name)
    assert p2s_io.safe_join(tmp_path, "Küche 1.jpg") == tmp_path / "Küche 1.jpg"
    assert p2s_io.safe_join(tmp_path, "sub/x.jpg") == tmp_path / "sub" / "x.jpg"


def test_a_failed_write_leaves_the_old_file_and_a_long_name_can_be_written(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), p2s_io.atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
    path.unlink()
    p2s_io.write_text(tmp_path / ("n" * 251 + ".txt"), "whole")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["whole"]


def test_the_old_directory_stays_until_the_new_one_is_there(tmp_path):
    target = tmp_path / "d"
    target.mkdir()
    (target / "old").write_text("")
    with pytest.raises(RuntimeError), p2s_io.atomic_directory(target):
        raise RuntimeError
    with p2s_io.atomic_directory(target) as new:
        (new / "new").write_text("")
        assert [p.name for p in target.iterdir()] == ["old"]
    assert [p.name for p in target.iterdir()] == ["new"]
    assert list(tmp_path.iterdir()) == [target]


def test_a_process_killed_between_the_two_renames_leaves_no_half_directory(tmp_path):
    target = tmp_path / "d"
    code = (
        "import os, sys\nfrom pathlib import Path\nfrom plan2scene.io import atomic_directory\n"
        "rename = Path.replace\n"
        "def rename_once(*names): rename(*names); os.kill(os.getpid(), 9)\n"
        "Path(sys.argv[1]).mkdir()\n"
        "with atomic_directory(sys.argv[1]): Path.replace = rename_once"
    )
    subprocess.run([sys.executable, "-c", code, str(target)], check=False)
    assert not target.exists() and len(list(tmp_path.iterdir())) == 2
    with p2s_io.atomic_directory(target):
        pass
    assert list(tmp_path.iterdir()) == [target]


def test_what_a_killed_process_left_goes_and_that_of_a_live_one_stays(tmp_path):
    target = tmp_path / "x.png"
    code = (
        "import os, sys\nfrom plan2scene.io import atomic_path, atomic_directory\n"
        "with atomic_path(sys.argv[1]), atomic_directory(sys.argv[1] + '.d'):\n"
        "    os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", code, str(target)], check=False)
    assert len(list(tmp_path.iterdir())) == 2
    with p2s_io.atomic_path(target) as mine:  # of a process that lives
        p2s_io.write_text(target, "whole")
        assert {p.name for p in tmp_path.iterdir() if p.is_file()} == {"x.png", mine.name}
        with p2s_io.atomic_directory(f"{target}.d"):
            pass
        assert {p.name for p in tmp_path.iterdir()} == {"x.png", "x.png.d", mine.name}


def test_damaged_and_foreign_parquet_files_are_named_with_what_helps(tmp_path):
    path = tmp_path / "x.parquet"
    p2s_io.write_parquet(path, pd.DataFrame({"a": range(999)}), {})
    whole = path.read_bytes()
    for damaged in (whole[:-9], whole[:40], b"", whole[:60] + b"\xff" * 60 + whole[120:]):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match=rf"{path}: expected a whole .*`rm '{path}'`"):
            p2s_io.read_parquet(path)
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "x.parquet")
    with pytest.raises(InputError):
        p2s_io.read_parquet(tmp_path / "x.parquet")


def test_a_missing_file_is_told_with_what_differs_in_its_ending(tmp_path):
    (tmp_path / "a.JPG").write_text("")
    assert p2s_io.absent(tmp_path / "a.jpg") == "no such file, but a.JPG"
    assert p2s_io.absent(tmp_path / "b.jpg") == "no such file"


@pytest.mark.parametrize(("mask", "file", "folder"), [(0o022, 0o644, 0o755), (0o077, 0o600, 0o700)])
def test_written_files_obey_the_umask(tmp_path, mask, file, folder):
    before = os.umask(mask)
    try:
        p2s_io.write_json(tmp_path / "a.json", {})
        with p2s_io.atomic_directory(tmp_path / "b") as made:
            p2s_io.write_json(made / "c.json", {})
    finally:
        os.umask(before)
    modes = {path.name: path.stat().st_mode & 0o777 for path in tmp_path.rglob("*")}
    assert modes == {"a.json": file, "b": folder, "c.json": file}


def test_finals_are_on_the_disk_before_they_take_their_name(tmp_path, monkeypatch):
    steps, fsync, replace = [], os.fsync, Path.replace

    def flushed(handle):
        steps.append(Path(f"/proc/self/fd/{handle}").readlink().name[:5])
        fsync(handle)

    monkeypatch.setattr(os, "fsync", flushed)
    monkeypatch.setattr(Path, "replace", lambda a, b: (steps.append(b.name), replace(a, b)))
    with p2s_io.atomic_path(tmp_path / "a.txt", flush=True) as path:
        path.write_text("a")
    with p2s_io.atomic_directory(tmp_path / "b", flush=True) as folder:
        (folder / "inside").write_text("b")
    parent = tmp_path.name[:5]
    assert steps == [".tmp_", "a.txt", parent, "insid", ".tmp_", "b", parent]
