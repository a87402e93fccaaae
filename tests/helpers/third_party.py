"""The package of tests/toy_package, installed as a user would install it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from plan2scene import plugins
from plan2scene_app.workflow import closures

SOURCE = Path(__file__).parents[1] / "toy_package"


@pytest.fixture(scope="session")
def toy_site(tmp_path_factory):
    site = tmp_path_factory.mktemp("site")
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--disable-pip-version-check"]
    command = [sys.executable, "-m", "pip", "install", *options, "--target", str(site)]
    subprocess.run([*command, str(SOURCE)], check=True, cwd=site)
    return site


@pytest.fixture
def toy_installed(toy_site, monkeypatch):
    path = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), str(toy_site)]))
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.syspath_prepend(toy_site)
    caches = (plugins.plugins, closures._code_of, plugins.loaded)
    for function in caches:
        function.cache_clear()
    yield
    monkeypatch.undo()
    for function in caches:
        function.cache_clear()
