"""``snakemake --logger plan2scene``: a line for each job that is done, a bar on a terminal.

A package of its own, for Snakemake finds plugins by the name of their package; the library does
not know it. A job that fails is a line with what its log says. ``--logger-plan2scene-events FILE``
also writes what happens as JSON lines, for programs:

- ``{"event": "planned", "jobs": {rule: count}}``
- ``{"event": "started", "rule": rule, "house": house}``
- ``{"event": "finished", "rule": rule, "house": house, "seconds": s, "warnings": [line]}``
- ``{"event": "failed", "rule": rule, "house": house, "message": line}``
- ``{"event": "error", "message": line}`` of the run as a whole
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
#: What a user of the lines need not read: the log file has it.
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
        """Return what the job's logs say at a level, without its name."""
        lines = [line for log in self.logs if log.is_file() for line in _read(log)]
        return [line.removeprefix(f"{level} ") for line in lines if line.startswith(f"{level} ")]


def _read(log: Path) -> list[str]:
    return log.read_text(errors="replace").splitlines()


class LogHandler(LogHandlerBase):
    """Lines of finished jobs: how many of how many, rule, house, seconds.

    Attributes
    ----------
    stream : text file
        Where lines go; the bar is drawn where it is a terminal.
    """

    stream: TextIO

    def __post_init__(self) -> None:
        self.stream = sys.stderr
        self._events = self.settings.events if self.settings else None
        self._total = self._done = 0
        self._stopped = False
        self._jobs: dict[int, _Job] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Keep what an event says of a job, and write a line when one is done."""
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
            self._stopped = True  # whoever stopped it is told by the command
        elif event is None and record.levelno >= _LEVEL:
            self._write(self.format(record))
            self._report("error", message=self.format(record))

    def _job(self, fields: dict[str, Any], now: float) -> _Job:
        house = dict(fields.get("wildcards") or {}).get("house", "")
        return _Job(fields["rule_name"], house, [Path(log) for log in fields.get("log") or ()], now)

    def _finish(self, number: int, now: float) -> None:
        """Write the line of a job that is done."""
        self._done += 1
        job = self._jobs.pop(number, _Job("", "", [], now))
        seconds = now - job.started
        total = max(self._total, self._done)
        count = f"{self._done:>{len(str(total))}} of {total}"
        self._write(f"{count}  {job.rule:<15} {job.house}  {seconds:.1f} s")
        values = {"rule": job.rule, "house": job.house, "seconds": round(seconds, 3)}
        self._report("finished", **values, warnings=job.lines("WARNING"))

    def _fail(self, fields: dict[str, Any], now: float) -> None:
        """Write what a job's log says went wrong, or where to look.

        Of a group that failed every job is named: those without a fault in their log are left out.
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
        """Write a line, above the bar where there is one."""
        if not self.stream.isatty():
            print(line, file=self.stream, flush=True)
            return
        filled = _WIDTH * self._done // max(self._total, 1)
        bar = f"[{'#' * filled}{'.' * (_WIDTH - filled)}]"
        # What a job writes next begins on the bar.
        end = "\n" if self._done >= self._total else "\r"
        print(f"\x1b[K{line}\n{bar}", end=end, file=self.stream, flush=True)

    @property
    def writes_to_stream(self) -> bool:
        """Whether Snakemake's own lines are left out: yes."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """Whether a file takes the place of Snakemake's log: no."""
        return False

    @property
    def has_filter(self) -> bool:
        """Whether it decides itself what it takes: yes."""
        return True

    @property
    def has_formatter(self) -> bool:
        """Whether it formats messages itself: no."""
        return False

    @property
    def needs_rulegraph(self) -> bool:
        """Whether the graph of rules is wanted: no."""
        return False
