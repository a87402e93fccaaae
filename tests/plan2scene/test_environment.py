"""The files that say what is installed agree."""

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def canonical(requirement: str) -> str:
    return re.match(r"[A-Za-z0-9_.-]+", requirement).group().lower().replace("_", "-")


def test_conda_environment_lists_the_dependencies_of_the_project():
    environment = yaml.safe_load((ROOT / "envs" / "plan2scene.yaml").read_text())
    pip = next(entry["pip"] for entry in environment["dependencies"] if isinstance(entry, dict))
    assert pip == PROJECT["dependencies"]


def test_every_dependency_is_pinned_within_its_range():
    from packaging.requirements import Requirement

    pinned = {}
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        if not line.startswith("#"):
            name, version = line.split("==")
            pinned[canonical(name)] = version
    extras = PROJECT["optional-dependencies"]
    # The extra `pretrained` is for users who bring such weights; the tests don't install it.
    tested = [text for name in ("test", "workshop", "dev") for text in extras[name]]
    for text in [*PROJECT["dependencies"], *tested]:
        requirement = Requirement(text)
        assert pinned[canonical(requirement.name)] in requirement.specifier, text
