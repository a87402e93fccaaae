"""Results of an earlier run that a failed one leaves out of date: they are not results any more."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from plan2scene.temporary import remove

#: Paths of a job: what it reads, and what it makes.
_Job = tuple[Sequence[str], Sequence[str]]


def remove_outdated(jobs: Iterable[_Job]) -> list[str]:
    """Remove what jobs that did not run made once from inputs that are gone; return the paths.

    Parameters
    ----------
    jobs : iterable of (inputs, outputs)
        Paths of every job that a failed run planned and did not finish. An output whose job
        failed is gone by now; what lies downstream of it goes too.
    """
    waiting = list(jobs)
    made = {path for _, outputs in waiting for path in outputs}
    removed: list[str] = []
    while True:
        lost: list[_Job] = []
        kept: list[_Job] = []
        for job in waiting:
            (lost if any(_is_gone(path, made) for path in job[0]) else kept).append(job)
        if not lost:
            return removed
        waiting = kept
        for path in (path for _, outputs in lost for path in outputs):
            if os.path.lexists(path):
                remove(Path(path))
                removed.append(path)


def _is_gone(path: str, made: set[str]) -> bool:
    return path in made and not os.path.lexists(path)
