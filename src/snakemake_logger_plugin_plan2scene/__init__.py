"""``snakemake --logger plan2scene``: a line for each job that is done, a bar on a terminal.

A package of its own, for Snakemake finds plugins by the name of their package; the library does
not know it. A job that fails is a line with what its log says.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Any, TextIO

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

_WIDTH = 30  # of the bar, in characters
#: What a user of the lines need not read: the log file has it.
_LEVEL = logging.ERROR


def _read(log: Path) -> list[str]:
    """Return the lines of a log; none where it is not there."""
    return log.read_text(errors="replace").splitlines() if log.is_file() else []


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
        self._total = self._done = 0
        self._names: dict[int, tuple[str, str]] = {}
        self._started: dict[int, float] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Keep what an event says of a job, and write a line when one is done."""
        event = getattr(record, "event", None)
        if event == LogEvent.RUN_INFO:
            self._total = record.__dict__["stats"].get("total", 0)
        elif event == LogEvent.JOB_INFO:
            fields = record.__dict__
            house = dict(fields.get("wildcards") or {}).get("house", "")
            self._names[fields["jobid"]] = (fields["rule_name"], house)
            self._started.setdefault(fields["jobid"], record.created)
        elif event == LogEvent.JOB_STARTED:
            self._started |= dict.fromkeys(record.__dict__["jobs"], record.created)
        elif event == LogEvent.JOB_FINISHED:
            self._finish(record.__dict__["job_id"], record.created)
        elif event == LogEvent.JOB_ERROR:
            self._fail(record.__dict__)
        elif event is None and record.levelno >= _LEVEL:
            self._write(self.format(record))

    def _finish(self, job: int, now: float) -> None:
        """Write the line of a job that is done."""
        self._done += 1
        rule, house = self._names.pop(job, ("", ""))
        seconds = now - self._started.pop(job, now)
        total = max(self._total, self._done)
        count = f"{self._done:>{len(str(total))}} of {total}"
        self._write(f"{count}  {rule:<15} {house}  {seconds:.1f} s")

    def _fail(self, fields: dict[str, Any]) -> None:
        """Write what a job's log says went wrong, or where to look.

        Of a group that failed every job is named: those without a fault in their log are left out.
        """
        rule, house = self._names.get(fields["jobid"], (fields["rule_name"], ""))
        logs = [Path(name) for name in fields["log"]]
        lines = [line for log in logs for line in _read(log) if line.startswith("ERROR")]
        where = f"see {', '.join(map(str, logs))}" if logs else "no log"
        told = lines[-1] if lines else fields.get("rule_msg") or where
        if lines or not fields["indent"]:
            self._write(f"failed  {rule:<15} {house}  {told}")

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
        """Whether a file is written: no."""
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
