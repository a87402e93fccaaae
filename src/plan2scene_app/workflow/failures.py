"""Why houses are not finished, from the logs of their jobs."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

#: Most houses that are named.
MOST_NAMED = 20


def failures(logs: Path, houses: Collection[str]) -> list[str]:
    """Return a line for each of these houses whose logs end with an error: the newest one.

    A job that succeeds writes its log anew. More than `MOST_NAMED` houses are counted.
    """
    newest: dict[str, tuple[float, str]] = {}
    for log in logs.rglob("*.log"):
        if log.stem in houses:
            lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
            if any(line.startswith("ERROR ") for line in lines):
                error = log.stat().st_mtime, f"{lines[-1].removeprefix('ERROR ')} ({log})"
                newest[log.stem] = max(newest.get(log.stem, error), error)
    lines = [f"failed: {newest[house][1]}" for house in houses if house in newest]
    more = [f"failed: {len(lines) - MOST_NAMED} more houses"] if len(lines) > MOST_NAMED else []
    return lines[:MOST_NAMED] + more
