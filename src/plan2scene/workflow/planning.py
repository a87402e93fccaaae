"""What a workflow's plan need not do again for each of thousands of jobs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import cache
from typing import Any
from weakref import WeakKeyDictionary


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


def answer_of_each(ask: Callable[..., Any], kind: Callable[[Any], Hashable]) -> Any:
    """Return a method that asks the first object of each kind alone, in place of `ask`."""
    known: dict[Hashable, Any] = {}

    def answer(self: Any, *asked: Hashable) -> Any:
        own = (kind(self), *asked)
        if own not in known:
            known[own] = ask(self, *asked)
        return known[own]

    return answer


def parameters_of_each(read: Callable[[Any], Mapping[str, Any]]) -> Any:
    """Return a function that reads a function's parameters once, in place of `read`.

    Those of a method are read once for all objects of its class. They are forgotten with it.
    """
    known: WeakKeyDictionary[Any, Mapping[str, Any]] = WeakKeyDictionary()
    bound: WeakKeyDictionary[Any, Mapping[str, Any]] = WeakKeyDictionary()

    def parameters(function: Any) -> Mapping[str, Any]:
        method = getattr(function, "__func__", None)
        table, key = (known, function) if method is None else (bound, method)
        try:
            return table[key]
        except KeyError:
            table[key] = found = read(function)
            return found
        except TypeError:  # no key of a table
            return read(function)

    return parameters


def plain_as_it_is(form: Callable[..., str]) -> Any:
    """Return a function that tells of a path without flags as it is, of others by `form`."""

    def formed(path: Any, as_input: bool = False, as_output: bool = False) -> str:
        if type(getattr(path, "_file", None)) is str:
            return str(path)
        return form(path, as_input=as_input, as_output=as_output)

    return formed
