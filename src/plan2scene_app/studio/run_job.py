"""The process that makes a project's house: ``plan2scene run`` with its end on record."""

from __future__ import annotations

import logging
import os
import sys
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError, WorkflowError
from plan2scene.io import read_json, write_json
from plan2scene_app.run import SingleHouse, run
from plan2scene_app.studio.projects import PLAN, TABLE, Project

#: In a project: the run under way or the last one, and what it told.
RECORD, LOG = "run.json", "run.log"


def make_house(project: Project, settings: dict[str, Any]) -> None:
    """Run the workflow on a project and record how it ended; the log is standard output."""
    table = project.path / TABLE
    has_rows = table.is_file() and len(table.read_text("utf-8").splitlines()) > 1
    request = SingleHouse(
        plan=project.path / PLAN,
        photo_table=table if has_rows else None,
        photos_dir=project.photos if has_rows else None,
        house=project.name,
        method=settings["method"],
        metres_per_pixel=None,
        seed=0,
        texture_size=settings["texture_size"],
        colours=settings["colours"],
    )
    record = read_json(project.path / RECORD)
    try:
        run(request, project.house, cores=settings["cores"], shown="verbose")
        ended = {"state": "done"}
    except (InputError, WorkflowError) as error:
        print(f"ERROR {error}", file=sys.stderr)  # noqa: T201 - its log
        ended = {"state": "failed"}
    write_json(project.path / RECORD, record | ended)


def main(folder: str) -> None:
    """Entry point: the record says what to do."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(message)s")
    os.chdir(folder)
    project = Project(Path(folder))
    record = read_json(project.path / RECORD)
    make_house(project, record["settings"])


if __name__ == "__main__":
    main(sys.argv[1])
