import pytest
from clones import demo_rows, make_clone


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """Two houses: of the first everything is made, of the other nothing."""
    other, first = demo_rows()[:2]
    dataset = {"name": "tiny", "root": "data", "table": "houses.tsv", "splits": ["test"]}
    dataset |= {"houses": [first["house"]]}
    changes = {"dataset": dataset, "textures": {"size_px": 128, "library_tiles": 8}}
    clone = make_clone(tmp_path_factory.mktemp("made") / "clone", [first, other], **changes)
    run = clone.snakemake("all")
    assert run.returncode == 0, run.stdout[-6000:]
    return clone
