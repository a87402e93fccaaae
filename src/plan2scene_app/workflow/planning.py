"""What the rules look up in a house's own files while Snakemake plans the jobs.

A fault in such a file is no error here: the house's own jobs report it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from plan2scene.datasets.assignments import read_rows
from plan2scene.errors import InputError
from plan2scene.io import safe_join
from plan2scene.plans.formats import plan_formats
from plan2scene.plans.plan_file import PlanFile


def may_lack_heights(path: Path) -> bool:
    """Return whether a plan may lack heights of ceilings, by the file's name and first bytes."""
    plan = PlanFile(path, "")
    suffix = path.suffix.lower()
    return any(item.lacks_heights(plan) for item in plan_formats() if suffix in item.suffixes)


def lacks_rooms(path: str | Path) -> bool:
    """Return whether a photo table has a row without a room; False if it cannot be read."""
    try:
        return any(not row.room_id for row in read_rows(path))
    except InputError:
        return False  # the job that reads it reports the fault


def photo_paths(folder: Path, names: Iterable[str]) -> list[Path]:
    """Return the paths of those photos that exist; unsafe names are left out."""
    return [path for name in safe_names(names) if (path := folder / name).is_file()]


def safe_names(names: Iterable[str]) -> list[str]:
    """Return the names of photos that are safe in a path; the house's jobs report the others."""
    safe = []
    for name in names:
        try:
            safe_join("", name)
        except InputError:
            continue
        safe.append(name)
    return safe
