"""Any bytes of a stranger are read or refused in one line (benchmarks/fuzz.py has the long form).

``tests/corpus/{reader}/`` keeps files that once did otherwise.
"""

from pathlib import Path

import pytest
from foreign import READERS, foreign_bytes, outcome
from hypothesis import HealthCheck, Phase, given, settings

CORPUS = Path(__file__).parents[1] / "corpus"
BY_NAME = {reader.name: reader for reader in READERS}
#: Cases of each reader: 500 in all.
CASES = -(-500 // len(READERS))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of the files, in another one that must stay as it is."""
    inside = tmp_path / "inside" / "here"
    inside.mkdir(parents=True)
    (tmp_path / "secret.txt").write_text("secret")
    monkeypatch.chdir(inside)
    yield inside
    assert sorted(p.name for p in tmp_path.iterdir()) == ["inside", "secret.txt"]
    assert [p.name for p in (tmp_path / "inside").iterdir()] == ["here"]
    assert (tmp_path / "secret.txt").read_text() == "secret"


#: The same cases each time, however long one takes.
SAME = settings(deadline=None, database=None, derandomize=True, suppress_health_check=HealthCheck)


@pytest.mark.parametrize("name", BY_NAME)
def test_whole_files_are_read(name, folder):
    reader = BY_NAME[name]
    assert "read" in {outcome(reader, data, folder) for data in reader.examples()}


@pytest.mark.parametrize("name", BY_NAME)
def test_damaged_files_are_read_or_one_line(name, folder):
    reader = BY_NAME[name]
    seen = []

    @settings(SAME, max_examples=CASES, phases=[Phase.generate])
    @given(foreign_bytes(reader))
    def check(data):
        seen.append(outcome(reader, data, folder))

    check()
    assert len(seen) >= CASES
    if name != "boxes.json":  # a faulty file of boxes is a warning
        assert "one line" in seen


@pytest.mark.parametrize(
    "path", sorted(CORPUS.glob("*/*")), ids=lambda path: f"{path.parent.name}-{path.name}"
)
def test_what_was_found_once(path, folder):
    assert outcome(BY_NAME[path.parent.name], path.read_bytes(), folder) in ("read", "one line")
