"""Fixtures of the tests on a SLURM: pytest -m slurm tests/slurm (.ci/run runs test_profile.py)."""

import importlib.util
from contextlib import ExitStack

import cluster
import pytest


def pytest_collection_modifyitems(config, items):
    on_demand = pytest.mark.skip(reason="on demand: pytest -m slurm tests/slurm")
    for item in items:
        if item.get_closest_marker("slurm") and "slurm" not in config.option.markexpr:
            item.add_marker(on_demand)


@pytest.fixture(scope="session")
def slurm():
    if cluster.missing():
        pytest.skip(cluster.missing())
    if importlib.util.find_spec("snakemake_executor_plugin_slurm") is None:
        pytest.skip("not installed: snakemake-executor-plugin-slurm")
    with ExitStack() as stack:
        try:
            made = stack.enter_context(cluster.cluster())
        except TimeoutError as error:
            pytest.skip(f"no SLURM starts here: {error}")
        yield made
