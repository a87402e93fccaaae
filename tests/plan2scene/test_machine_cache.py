"""Files made once per machine: by key, whole, and without the cache where there is none."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from plan2scene.machine_cache import VARIABLE, cache_folder, made_once


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


class Maker:
    """Writes a text and counts how often."""

    def __init__(self, text: str) -> None:
        self.text, self.calls = text, 0

    def __call__(self, path: Path) -> None:
        self.calls += 1
        path.write_text(self.text)


def test_a_key_is_made_once(cache, tmp_path):
    make = Maker("a")
    for name in ("one.txt", "two.txt"):
        made_once(tmp_path / name, {"seed": 0}, make)
        assert (tmp_path / name).read_text() == "a"
    assert make.calls == 1
    made_once(tmp_path / "three.txt", {"seed": 1}, Maker("b"))
    assert (tmp_path / "three.txt").read_text() == "b"


def test_a_kept_file_that_was_changed_is_made_again(cache, tmp_path):
    make = Maker("a")
    made_once(tmp_path / "one.txt", 0, make)
    (kept,) = cache.glob("*.txt")
    kept.write_text("spoilt")
    made_once(tmp_path / "two.txt", 0, make)
    assert (tmp_path / "two.txt").read_text() == "a"
    assert make.calls == 2


def test_many_at_once_get_the_same_file(cache, tmp_path):
    outputs = [tmp_path / f"{k}.txt" for k in range(8)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda path: made_once(path, "key", Maker("text" * 1000)), outputs))
    assert {path.read_text() for path in outputs} == {"text" * 1000}
    assert len(list(cache.iterdir())) == 2  # the file and its digest, nothing half-written


@pytest.mark.parametrize("blocked", [True, False])
def test_no_folder_is_no_fault(tmp_path, monkeypatch, blocked):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "file") if blocked else "")
    assert (cache_folder() is None) != blocked
    make = Maker("a")
    for name in ("one.txt", "two.txt"):
        made_once(tmp_path / name, 0, make)
        assert (tmp_path / name).read_text() == "a"
    assert make.calls == 2
