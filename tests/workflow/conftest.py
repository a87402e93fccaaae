"""Fixtures of the workflow tests."""

import pytest
from clones import Clone, demo_rows, make_clone


@pytest.fixture(scope="session")
def made(tmp_path_factory) -> Clone:
    """Two houses, everything made."""
    clone = make_clone(tmp_path_factory.mktemp("made") / "clone", demo_rows()[:2])
    run = clone.snakemake("all")
    assert run.returncode == 0, run.stdout[-6000:]
    return clone
