"""Results of an earlier run that a failed one leaves out of date: they are not results any more."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from plan2scene.temporary import remove


def remove_outdated(jobs: Iterable[tuple[Sequence[str], Sequence[str]]]) -> list[str]:
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
        lost = [job for job in waiting if any(_is_gone(path, made) for path in job[0])]
        if not lost:
            return removed
        waiting = [job for job in waiting if job not in lost]
        for path in (path for _, outputs in lost for path in outputs):
            if os.path.lexists(path):
                remove(Path(path))
                removed.append(path)


def _is_gone(path: str, made: set[str]) -> bool:
    return path in made and not os.path.lexists(path)
