"""Entry points: how plan formats, texture methods and exports of any package are found by name."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol, TypeVar

from plan2scene.errors import InputError
from plan2scene.provenance import WORKFLOW

_LOG = logging.getLogger("plan2scene")


class Plugin(Protocol):
    """What an entry point must point to."""

    @property
    def name(self) -> str:
        """Its name in the command line, the configuration and messages."""

    @property
    def needs(self) -> str:
        """What pip must install for it beyond its package's dependencies; empty for nothing."""


P = TypeVar("P", bound=Plugin)


@cache
def plugins(group: str, kind: type[P]) -> dict[str, P]:
    """Return the plugins of a group by name: our own in alphabetical order, then others.

    An entry point that cannot be loaded, does not name a `kind`, or repeats a name is left out with
    a warning. Each is imported here, so its module should import large packages only when it runs.
    """
    return {name: item for name, (_, item) in loaded(group, kind).items()}


@contextmanager
def installed(needs: str, house: str = "") -> Iterator[None]:
    """Turn a missing package into an InputError that says to install `needs`, if there is any."""
    try:
        yield
    except ModuleNotFoundError as error:
        if not needs:
            raise
        expected = f"{error.name} ({pip_command(needs)})"
        raise InputError(expected, "no such package", house=house) from None


def pip_command(needs: str) -> str:
    """Return the pip command that installs `needs`; our own extras are taken from this clone."""
    clone = needs.startswith("plan2scene[") and (WORKFLOW / "pyproject.toml").is_file()
    if not clone:
        return f"pip install '{needs}'"
    return f"{sys.executable} -m pip install -e '{WORKFLOW}{needs.removeprefix('plan2scene')}'"


@cache
def loaded(group: str, kind: type[P]) -> dict[str, tuple[EntryPoint, P]]:
    """Return what :func:`plugins` does, each with its entry point."""
    found: dict[str, tuple[EntryPoint, P]] = {}
    entries = entry_points(group=group)
    for entry in sorted(entries, key=lambda entry: (not is_ours(entry), entry.name)):
        try:
            item = entry.load()
            if not isinstance(item, kind):
                raise TypeError(f"not a {kind.__name__}")
            if item.name in found:
                raise ValueError(f"another one is called {item.name}")
        except Exception as error:  # noqa: BLE001 - another package's code may raise anything
            _LOG.warning("%s of %s is left out: %s", entry.value, distribution(entry), error)
            continue
        found[item.name] = (entry, item)
    return found


def is_ours(entry: EntryPoint) -> bool:
    """Return whether an entry point names an object of the core or the app."""
    return entry.module.split(".")[0] in ("plan2scene", "plan2scene_app")


def distribution(entry: EntryPoint) -> str:
    """Return the name and version of an entry point's package, else its module."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.module
