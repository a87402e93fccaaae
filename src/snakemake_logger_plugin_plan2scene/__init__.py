"""``snakemake --logger plan2scene``: a line for each finished job, a progress bar on a terminal.

It is a package of its own because Snakemake finds plugins by the name of their package; the library
does not import it. A failed job gives a line with the error in its log. With
``--logger-plan2scene-events FILE`` the events are also appended to a file, for programs:

- ``{"event": "planned", "jobs": {rule: count}}``
- ``{"event": "started", "rule": rule, "house": house}``
- ``{"event": "finished", "rule": rule, "house": house, "seconds": s, "warnings": [line]}``
- ``{"event": "failed", "rule": rule, "house": house, "message": line}``
- ``{"event": "error", "message": line}`` for an error of the whole run
"""

import json
import logging
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional, TextIO

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent
from snakemake_interface_logger_plugins.settings import LogHandlerSettingsBase

_WIDTH = 30  # of the bar, in characters
#: Other messages of Snakemake are printed from this level on; the log file has them all.
_LEVEL = logging.ERROR


@dataclass
class LogHandlerSettings(LogHandlerSettingsBase):
    """Options ``--logger-plan2scene-*``; Snakemake reads their types from the annotations."""

    events: Optional[Path] = field(  # noqa: UP045 - Snakemake knows no other form
        default=None,
        metadata={"help": "File that events are appended to, one JSON object a line."},
    )


@dataclass
class _Job:
    """A job that was announced."""

    rule: str
    house: str
    logs: list[Path]
    started: float  #: seconds since the epoch

    def lines(self, level: str) -> list[str]:
        """Return the lines of the job's logs at a level, without the level's name."""
        lines = [line for log in self.logs if log.is_file() for line in _read(log)]
        return [line.removeprefix(f"{level} ") for line in lines if line.startswith(f"{level} ")]


def _read(log: Path) -> list[str]:
    return log.read_text(errors="replace").splitlines()


class LogHandler(LogHandlerBase):
    """Writes a line for each finished job: its number of the total, rule, house, seconds.

    Attributes
    ----------
    stream : text file
        Where lines are written; the bar is drawn only if it is a terminal.
    """

    stream: TextIO

    def __post_init__(self) -> None:
        self.stream = sys.stderr
        self._events = self.settings.events if self.settings else None
        self._total = self._done = 0
        self._stopped = False
        self._jobs: dict[int, _Job] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Record what an event says about a job, and write a line when a job ends."""
        event, fields = getattr(record, "event", None), record.__dict__
        if event == LogEvent.RUN_INFO:
            planned = dict(fields["stats"])
            self._total = planned.pop("total", 0)
            self._report("planned", jobs=planned)
        elif event == LogEvent.JOB_INFO:
            job = self._jobs[fields["jobid"]] = self._job(fields, record.created)
            self._report("started", rule=job.rule, house=job.house)
        elif event == LogEvent.JOB_FINISHED:
            self._finish(fields["job_id"], record.created)
        elif event == LogEvent.JOB_ERROR:
            self._fail(fields, record.created)
        elif event is None and "on user request" in record.getMessage():
            self._stopped = True  # the command itself tells the user
        elif event == LogEvent.ERROR and self._jobs:
            return  # of a job: its own event has been told
        elif event in (None, LogEvent.ERROR) and record.levelno >= _LEVEL:
            self._write(self.format(record))
            self._report("error", message=self.format(record))

    def _job(self, fields: dict[str, Any], now: float) -> _Job:
        house = dict(fields.get("wildcards") or {}).get("house", "")
        return _Job(fields["rule_name"], house, [Path(log) for log in fields.get("log") or ()], now)

    def _finish(self, number: int, now: float) -> None:
        """Write the line of a finished job."""
        self._done += 1
        job = self._jobs.pop(number, _Job("", "", [], now))
        seconds = now - job.started
        total = max(self._total, self._done)
        count = f"{self._done:>{len(str(total))}} of {total}"
        self._write(f"{count}  {job.rule:<15} {job.house}  {seconds:.1f} s")
        values = {"rule": job.rule, "house": job.house, "seconds": round(seconds, 3)}
        self._report("finished", **values, warnings=job.lines("WARNING"))

    def _fail(self, fields: dict[str, Any], now: float) -> None:
        """Write the error in a failed job's log, or where the log is.

        Snakemake reports every job of a failed group; jobs without an error in their log are
        left out.
        """
        job = self._jobs.get(fields["jobid"]) or self._job(fields, now)
        logs = [Path(log).resolve() for log in fields["log"]]
        errors = _Job(job.rule, job.house, logs, now).lines("ERROR")
        where = f"see {', '.join(map(str, logs))}" if logs else "no log"
        message = errors[-1] if errors else fields.get("rule_msg") or where
        if errors or not (fields["indent"] or self._stopped):
            self._write(f"failed  {job.rule:<15} {job.house}  {'ERROR ' * bool(errors)}{message}")
            self._report("failed", rule=job.rule, house=job.house, message=message)

    def _report(self, event: str, **values: Any) -> None:
        """Append an event to the file of events."""
        if self._events is not None:
            with Path(self._events).open("a", encoding="utf-8") as file:
                file.write(json.dumps({"event": event} | values) + "\n")

    def _write(self, line: str) -> None:
        """Write a line, above the bar if there is one."""
        if not self.stream.isatty():
            print(line, file=self.stream, flush=True)
            return
        filled = _WIDTH * self._done // max(self._total, 1)
        bar = f"[{'#' * filled}{'.' * (_WIDTH - filled)}]"
        # The cursor stays at the start of the bar, so that the next output overwrites it.
        end = "\n" if self._done >= self._total else "\r"
        print(f"\x1b[K{line}\n{bar}", end=end, file=self.stream, flush=True)

    @property
    def writes_to_stream(self) -> bool:
        """Whether it replaces Snakemake's own lines: yes."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """Whether it replaces Snakemake's log file: no."""
        return False

    @property
    def has_filter(self) -> bool:
        """Whether it filters the records itself: yes."""
        return True

    @property
    def has_formatter(self) -> bool:
        """Whether it formats messages itself: no."""
        return False

    @property
    def needs_rulegraph(self) -> bool:
        """Whether it needs the graph of rules: no."""
        return False
