"""Runs of a project: start, look at, cancel. All that is known of a run lies in the project.

A run is a process of its own: it outlives the server, and the next server finds it.
"""

from __future__ import annotations

import subprocess
import sys
import time
from contextlib import suppress
from typing import Any

import psutil

from plan2scene.errors import InputError
from plan2scene.io import read_json, write_json
from plan2scene.textures.methods import method_named
from plan2scene_app.run import TEXTURE_SIZES
from plan2scene_app.studio.progress import read_progress
from plan2scene_app.studio.projects import Project
from plan2scene_app.studio.run_job import LOG, RECORD

#: The command of a run, given a project's folder.
JOB = (sys.executable, "-m", "plan2scene_app.studio.run_job")
#: Seconds that a cancelled run has to end by itself.
_GRACE = 3.0
#: Most bytes of a log that are read.
_LOG_BYTES = 4_000_000


def settings_of(given: Any, cores: int) -> dict[str, Any]:
    """Return how a house is made, checked."""
    given = given if isinstance(given, dict) else {}
    found = {
        "method": given.get("method", "exemplar"),
        "texture_size": given.get("texture_size", 128),
        "colours": given.get("colours", "photo"),
        "cores": cores,
    }
    method_named(str(found["method"]))
    if found["texture_size"] not in TEXTURE_SIZES:
        raise InputError(f"a texture size of {TEXTURE_SIZES}", repr(found["texture_size"]))
    if found["colours"] not in ("photo", "corrected"):
        raise InputError("colours photo or corrected", repr(found["colours"]))
    return found


def start(project: Project, settings: dict[str, Any]) -> None:
    """Start a run; InputError where one is under way."""
    _let_end(project)
    if _process(project) is not None or _is_starting(project):
        raise InputError("no run under way in this project", "one")
    settings = settings | {"revision": project.revision()}
    write_json(project.path / RECORD, {"state": "starting", "settings": settings})
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


def _let_end(project: Project) -> None:
    """Wait for the process of a run that has recorded its end: it takes a moment to go."""
    process = _process(project)
    if process and read_json(project.path / RECORD).get("state") not in ("starting", "running"):
        psutil.wait_procs([process], timeout=_GRACE)


def _record_start(project: Project, record: dict[str, Any]) -> None:
    """Record a child, unless it was so quick that it has recorded its end."""
    found = read_json(project.path / RECORD)
    if found.get("state") == "starting":
        write_json(project.path / RECORD, record)


def status(project: Project) -> dict[str, Any]:
    """Return ``{state, stages, fault, warnings, settings}`` of the run under way or the last.

    The state is none, running, done, failed, cancelled or interrupted (killed from outside).
    """
    file = project.path / RECORD
    if not file.is_file():
        return {"state": "none", "stages": [], "fault": "", "warnings": [], "settings": {}}
    alive = _process(project) is not None or _is_starting(project)
    record = read_json(file)  # after the look at the process: its end is on record by then
    state = record.get("state", "failed")
    if state in ("starting", "running"):
        state = "running" if alive else "interrupted"
    log = project.path / LOG
    lines = log.read_bytes()[-_LOG_BYTES:].decode("utf-8", "replace") if log.is_file() else ""
    progress = read_progress(lines.splitlines())
    stages = progress.stages()
    if state != "running":
        stopped = {"running": "waiting"} if state != "failed" else {"running": "failed"}
        for stage in stages:
            stage["state"] = stopped.get(str(stage["state"]), stage["state"])
    return {
        "state": state,
        "stages": stages,
        "fault": progress.fault if state == "failed" else "",
        "warnings": progress.warnings[:20],
        "settings": record.get("settings", {}),
    }


def cancel(project: Project) -> None:
    """End a run and all that it started; what is made stays, the next run goes on from there."""
    process = _process(project)
    if process is None:
        return
    family = [process, *process.children(recursive=True)]
    write_json(project.path / RECORD, read_json(project.path / RECORD) | {"state": "cancelled"})
    for member in family:
        _tell(member, kill=False)
    _, alive = psutil.wait_procs(family, timeout=_GRACE)
    for member in alive:
        _tell(member, kill=True)
    psutil.wait_procs(alive, timeout=_GRACE)
    time.sleep(0.05)
    write_json(project.path / RECORD, read_json(project.path / RECORD) | {"state": "cancelled"})


def _is_starting(project: Project) -> bool:
    """Return whether a run was asked for a moment ago and its process is not on record yet."""
    file = project.path / RECORD
    fresh = file.is_file() and time.time() - file.stat().st_mtime < _GRACE
    return fresh and read_json(file).get("state") == "starting"


def _tell(process: psutil.Process, *, kill: bool) -> None:
    with suppress(psutil.NoSuchProcess):
        process.kill() if kill else process.terminate()


def _process(project: Project) -> psutil.Process | None:
    """Return the process of the run under way: the one on record, not another of its number."""
    file = project.path / RECORD
    record = read_json(file) if file.is_file() else {}
    if not isinstance(record.get("pid"), int):
        return None
    try:
        process = psutil.Process(record["pid"])
        same = abs(process.create_time() - float(record["born"])) < 1.0
        return process if same and process.status() != psutil.STATUS_ZOMBIE else None
    except (psutil.NoSuchProcess, psutil.AccessDenied, ValueError, TypeError):
        return None
