"""What a workflow's plan need not do again for each of thousands of jobs."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import cache
from typing import Any


def first_of_each(check: Callable[[Any, Any], None], kind: Callable[[Any], Hashable]) -> Any:
    """Return a method that checks the first job of each kind alone, in place of `check`."""
    known: set[Hashable] = set()

    def check_first(self: Any, job: Any) -> None:
        if kind(job) not in known:
            check(self, job)
            known.add(kind(job))

    return check_first


def flags_of_flagged(clone_flags: Callable[..., None]) -> Any:
    """Return a method that copies a path's flags where there are any, in place of `clone_flags`.

    Snakemake gives each path of each job a second string with an empty dictionary of flags, a
    quarter of a plan's memory. A path without flags stays a plain string.
    """

    def clone_some(self: Any, other: Any, skip_storage_object: bool = False) -> None:
        if self.flags or other.flags:
            clone_flags(self, other, skip_storage_object=skip_storage_object)

    return clone_some


def one_of_each() -> Any:
    """Return a ``__new__`` that makes one object for equal arguments of an immutable class."""

    @cache
    def shared(cls: type, *_arguments: Hashable) -> Any:
        return object.__new__(cls)

    return staticmethod(shared)
