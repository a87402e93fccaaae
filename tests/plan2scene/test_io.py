"""Files: what is refused, round trips, and that writes are all or nothing."""

import pandas as pd
import pytest

from plan2scene import io as p2s_io
from plan2scene.errors import InputError


@pytest.mark.parametrize(
    "name", ["../x.jpg", "/etc/passwd", "a/../../x", "", " x", "a\\b", "C:x", "a\nb", "./x", "a//b"]
)
def test_names_that_leave_the_folder_are_refused(tmp_path, name):
    with pytest.raises(InputError):
        p2s_io.safe_join(tmp_path, name)


def test_plain_names_are_joined(tmp_path):
    assert p2s_io.safe_join(tmp_path, "Küche 1.jpg") == tmp_path / "Küche 1.jpg"
    assert p2s_io.safe_join(tmp_path, "sub/x.jpg") == tmp_path / "sub" / "x.jpg"


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "x.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), p2s_io.atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_directory_is_replaced_as_a_whole(tmp_path):
    target = tmp_path / "d"
    target.mkdir()
    (target / "stale").write_text("")
    with p2s_io.atomic_directory(target) as temporary:
        (temporary / "new").write_text("")
    assert [p.name for p in target.iterdir()] == ["new"]
    assert [p.name for p in tmp_path.iterdir()] == ["d"]


def test_parquet_round_trip_with_metadata(tmp_path):
    frame = pd.DataFrame({"a": [1, 2], "v": [[0.5, 1.0], [2.0]]})
    p2s_io.write_parquet(tmp_path / "x.parquet", frame, {"house": "h"})
    back, metadata = p2s_io.read_parquet(tmp_path / "x.parquet")
    assert metadata == {"schema_version": 1, "house": "h"}
    assert [list(v) for v in back["v"]] == [[0.5, 1.0], [2.0]]


def test_foreign_parquet_is_refused(tmp_path):
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "x.parquet")
    with pytest.raises(InputError):
        p2s_io.read_parquet(tmp_path / "x.parquet")


def test_deep_json_is_one_line(tmp_path):
    path = tmp_path / "x.json"
    path.write_text("[" * 200_000)
    with pytest.raises(InputError):
        p2s_io.read_json(path)
