"""What a workflow's plan need not do again for each of thousands of jobs."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any


def first_of_each(check: Callable[[Any, Any], None], kind: Callable[[Any], Hashable]) -> Any:
    """Return a method that checks the first job of each kind alone, in place of `check`."""
    known: set[Hashable] = set()

    def check_first(self: Any, job: Any) -> None:
        if kind(job) not in known:
            check(self, job)
            known.add(kind(job))

    return check_first
