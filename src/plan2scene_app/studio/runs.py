"""Runs of a project: start, status, cancel. The project's folder holds all state of a run.

A run is a separate process (this module, executed): it continues when the server ends, and the next
server finds it. Its progress is read from the events that a Snakemake logger writes
(snakemake_logger_plugin_plan2scene).
"""

from __future__ import annotations

import json
import logging
import os
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil

from plan2scene.errors import InputError, WorkflowError
from plan2scene.io import read_json, write_json
from plan2scene.textures.methods import method_named
from plan2scene_app.run import HOUSE_COLOURS, HOUSE_WALLS, TEXTURE_SIZES, SingleHouse, run
from plan2scene_app.studio.projects import PLAN, TABLE, Project

#: The command of a run; the project's folder is its argument.
JOB = (sys.executable, "-m", "plan2scene_app.studio.runs")
#: Seconds to wait until a cancelled run ends by itself, and until a finished run's process ends.
_GRACE, _LEAVING = 3.0, 20.0
#: Files in a project: the record of the current or last run, its events, and its output.
RECORD, EVENTS, LOG = "run.json", "run_events.jsonl", "run.log"
#: Titles of the workflow's rules for people, in the order of the work.
STAGES = {
    "trace": "The picture of the plan",
    "floorplan": "Plan",
    "drawn_floorplan": "Plan",
    "ceilings": "Ceilings",
    "masks": "What the photos show",
    "places": "Where the photos were taken",
    "crops": "Pieces of floors, walls and ceilings",
    "doubts": "What is not sure",
    "contact_sheet": "Pieces of photos",
    "embeddings": "What each piece looks like",
    "materials": "Surfaces of one material",
    "patterns": "Planks and tiles of floors",
    "propagated": "Surfaces that no photo shows",
    "textures": "Textures",
    "paint": "Paint without the photos' light",
    "house": "The house in 3D",
    "pictures": "Pictures of the house",
    "viewer": "The page to walk through it",
}
#: Largest number of warnings that are shown.
_WARNINGS = 20
#: Settings of a house for which its owner chooses nothing.
DEFAULTS = {"method": "exemplar", "texture_size": 128, "colours": "paint", "walls": "wall"}


def settings_of(chosen: Mapping[str, Any], cores: int) -> dict[str, Any]:
    """Return the checked settings of a run: the chosen ones, defaults for others, and `cores`."""
    settings: dict[str, Any] = dict(DEFAULTS)
    settings |= {key: chosen[key] for key in settings if key in chosen}
    method_named(str(settings["method"]))
    if settings["texture_size"] not in TEXTURE_SIZES:
        raise InputError(f"a texture size of {TEXTURE_SIZES}", repr(settings["texture_size"]))
    if settings["colours"] not in HOUSE_COLOURS:
        raise InputError(f"colours {', '.join(HOUSE_COLOURS)}", repr(settings["colours"]))
    if settings["walls"] not in HOUSE_WALLS:
        raise InputError(f"walls {', '.join(HOUSE_WALLS)}", repr(settings["walls"]))
    return settings | {"cores": cores}


def start(project: Project, settings: dict[str, Any]) -> None:
    """Start a run; InputError if one is already running."""
    _let_end(project)
    if _process(project) is not None or _is_starting(project):
        raise InputError("no run under way in this project", "one")
    settings = settings | {
        "revision": project.revision(),
        "finishes": project.finishes_revision(),
    }
    write_json(project.path / RECORD, {"state": "starting", "settings": settings})
    (project.path / EVENTS).unlink(missing_ok=True)
    with (project.path / LOG).open("wb") as log:
        child = subprocess.Popen(
            [*JOB, str(project.path)],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    born = psutil.Process(child.pid).create_time()
    record = {"state": "running", "settings": settings, "pid": child.pid, "born": born}
    _record_start(project, record)


def _record(project: Project) -> dict[str, Any]:
    """Return a run's record without entries of a wrong type (other programs may write it)."""
    record = read_json(project.path / RECORD)
    if not isinstance(record, dict):
        return {}
    kinds = {"state": str, "fault": str, "settings": dict}
    return {k: v for k, v in record.items() if isinstance(v, kinds.get(k, object))}


def _let_end(project: Project) -> None:
    """Wait, at most `_LEAVING`, until the process of a run that has recorded its end is gone."""
    process = _process(project)
    if process and _record(project).get("state") not in ("starting", "running"):
        psutil.wait_procs([process], timeout=_LEAVING)


def _record_start(project: Project, record: dict[str, Any]) -> None:
    """Record a run's process, unless the run was so quick that it has already recorded its end."""
    if _record(project).get("state") == "starting":
        write_json(project.path / RECORD, record)


def status(project: Project) -> dict[str, Any]:
    """Return ``{state, stages, fault, warnings, settings}`` of the current or last run.

    The state is none, running, done, failed, cancelled or interrupted (killed from outside).
    """
    file = project.path / RECORD
    if not file.is_file():
        return {"state": "none", "stages": [], "fault": "", "warnings": [], "settings": {}}
    alive = _process(project) is not None or _is_starting(project)
    record = _record(project)  # read after `alive`: a run records its end before it exits
    state = record.get("state", "failed")
    if state in ("starting", "running"):
        state = "running" if alive else "interrupted"
    progress = read_progress(project.path / EVENTS)
    stages = progress.stages()
    if state != "running":
        stopped = "failed" if state == "failed" else "waiting"
        for stage in stages:
            stage["state"] = stopped if stage["state"] == "running" else stage["state"]
    return {
        "state": state,
        "stages": stages,
        "fault": (progress.fault or record.get("fault", "")) if state == "failed" else "",
        "warnings": progress.warnings[:_WARNINGS],
        "settings": record.get("settings", {}),
    }


def _plain(line: str) -> str:
    """Return a warning without its folder and house, which the user knows."""
    place = re.match(r"(?:file (?:[^,]*/)?([^,/]+), )?house [^,:]+(?:, room ([^:]+))?: ", line)
    if place is None:
        return line
    where = place[2] or place[1] or "House"
    return f"{'Plan' if where.startswith('plan.') else where}: {line[place.end() :]}"


@dataclass
class Progress:
    """Progress of a run: the numbers of planned and finished jobs of each rule, and failures."""

    planned: dict[str, int] = field(default_factory=dict)
    started: set[str] = field(default_factory=set)
    finished: Counter[str] = field(default_factory=Counter)
    failed: set[str] = field(default_factory=set)
    fault: str = ""
    warnings: list[str] = field(default_factory=list)

    def add(self, event: Mapping[str, Any]) -> None:
        """Add an event of the logger, or a ``warning`` of the run's own process."""
        match event["event"]:
            case "planned":
                for rule, count in event["jobs"].items():
                    self.planned[rule] = self.finished[rule] + count
            case "started":
                self.started.add(event["rule"])
            case "finished":
                self.finished[event["rule"]] += 1
            case "failed":
                self.failed.add(event["rule"])
                self.fault = self.fault or event["message"]
        for line in map(_plain, event.get("warnings", ())):
            if line not in self.warnings:
                self.warnings.append(line)

    def stages(self) -> list[dict[str, str]]:
        """Return ``{rule, title, state}`` of every stage of this run, in order."""
        order = list(STAGES)
        rules = sorted(self.planned, key=lambda r: order.index(r) if r in order else len(order))
        return [
            {
                "rule": rule,
                "title": STAGES.get(rule, rule.replace("_", " ").capitalize()),
                "state": self._state(rule),
            }
            for rule in rules
        ]

    def _state(self, rule: str) -> str:
        if rule in self.failed:
            return "failed"
        if self.finished[rule] >= self.planned[rule]:
            return "done"
        return "running" if rule in self.started else "waiting"


def read_progress(events: Path) -> Progress:
    """Return the progress from a run's events; a line that is only half written is skipped."""
    progress = Progress()
    lines = events.read_text("utf-8").splitlines() if events.is_file() else []
    for line in lines:
        with suppress(json.JSONDecodeError):
            progress.add(json.loads(line))
    return progress


def cancel(project: Project) -> None:
    """End a run and all its child processes; finished results stay, and the next run continues."""
    process = _process(project)
    if process is None:
        return
    family = [process, *process.children(recursive=True)]
    write_json(project.path / RECORD, _record(project) | {"state": "cancelled"})
    for member in family:
        _signal(member, kill=False)
    _, alive = psutil.wait_procs(family, timeout=_GRACE)
    for member in alive:
        _signal(member, kill=True)
    psutil.wait_procs(alive, timeout=_GRACE)
    time.sleep(0.05)
    record = _record(project)
    if record.get("pid") == process.pid:  # the owner may have gone on in the meantime
        write_json(project.path / RECORD, record | {"state": "cancelled"})


def _is_starting(project: Project) -> bool:
    """Return whether a run was started a moment ago and its process is not yet recorded."""
    file = project.path / RECORD
    fresh = file.is_file() and time.time() - file.stat().st_mtime < _GRACE
    return fresh and _record(project).get("state") == "starting"


def _signal(process: psutil.Process, *, kill: bool) -> None:
    with suppress(psutil.NoSuchProcess):
        process.kill() if kill else process.terminate()


def _process(project: Project) -> psutil.Process | None:
    """Return the running process of the recorded run, not a later one with the same number."""
    file = project.path / RECORD
    record = _record(project) if file.is_file() else {}
    if not isinstance(record.get("pid"), int):
        return None
    try:
        process = psutil.Process(record["pid"])
        same = abs(process.create_time() - float(record["born"])) < 1.0
        return process if same and process.status() != psutil.STATUS_ZOMBIE else None
    except (psutil.Error, ArithmeticError, KeyError, ValueError, TypeError):
        return None


class _AsEvent(logging.Formatter):
    """Formats a log record as a ``warning`` event of the run."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line of JSON."""
        return json.dumps({"event": "warning", "warnings": [record.getMessage()]})


def make_house(project: Project, settings: Mapping[str, Any]) -> None:
    """Run the workflow on a project, and record how it ended."""
    table = project.path / TABLE
    has_rows = table.is_file() and len(table.read_text("utf-8").splitlines()) > 1
    request = SingleHouse(
        plan=project.path / PLAN,
        photo_table=table if has_rows else None,
        photos_dir=project.photos if has_rows else None,
        house=project.name,
        name=project.title,
        method=settings["method"],
        metres_per_pixel=None,
        seed=0,
        texture_size=settings["texture_size"],
        colours=settings["colours"],
        walls=settings["walls"],
    )
    # In a project with a house, deliver the new house and its viewer before the slow pictures.
    viewer_files = ("house.glb", "viewer.html")
    first = viewer_files if (project.house / viewer_files[1]).is_file() else ()
    events = project.path / EVENTS
    warnings = logging.FileHandler(events, encoding="utf-8", delay=True)
    warnings.setFormatter(_AsEvent())
    warnings.setLevel(logging.WARNING)
    logging.getLogger("plan2scene").addHandler(warnings)
    record = _record(project)
    try:
        run(request, project.house, cores=settings["cores"], events=events, first=first)
        end = {"state": "done"}
    except (InputError, WorkflowError) as error:
        end = {"state": "failed", "fault": str(error)}
    write_json(project.path / RECORD, record | end)


if __name__ == "__main__":
    home = Path(sys.argv[1])
    os.chdir(home)
    make_house(Project(home), read_json(home / RECORD)["settings"])
