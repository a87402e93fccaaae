"""Run a command that ends when the process that started it ends, even if that one is killed.

``python -m plan2scene_app.bound_process COMMAND...`` runs the command until it is done, or until
standard input closes. Standard input is a pipe: the starting process holds its other end, and the
system closes that end when the process ends. Then the whole process group gets SIGINT and, after
some seconds, SIGKILL.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType

from plan2scene.errors import WorkflowError


class EndedError(WorkflowError):
    """A signal asked this process to end."""


#: Signals that ask a process to end (SIGHUP is not on Windows).
_SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
#: Seconds from SIGINT to SIGKILL, in which a command can end by itself.
_GRACE = 3.0


def run_bound(
    command: Sequence[str], *, pass_fds: Sequence[int] = (), stderr: int | None = None
) -> int:
    """Run a command that ends when this process ends; return its exit code.

    If a signal asks this process to end, the command is ended first; then EndedError is raised.
    `stderr` is passed to :class:`subprocess.Popen`.
    """
    bound = [sys.executable, "-m", "plan2scene_app.bound_process", *command]
    reading, writing = os.pipe()
    with _signals_as_errors():
        try:
            process = subprocess.Popen(
                bound, stdin=reading, stderr=stderr, pass_fds=pass_fds, start_new_session=True
            )
        finally:
            os.close(reading)
        try:
            process.wait()
        finally:
            os.close(writing)
            code = process.wait()
    if code < 0:  # the wrapper was killed, so its command may still run
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    return code


@contextmanager
def _signals_as_errors() -> Iterator[None]:
    """Raise EndedError at the first signal that asks to end; later signals are ignored."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    told: list[int] = []

    def tell(number: int, _frame: FrameType | None) -> None:
        told.append(number)
        if len(told) == 1:
            name = signal.Signals(number).name
            raise EndedError(f"ended by {name}; the same command goes on from there")

    before = {number: signal.signal(number, tell) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end_with_input(child: subprocess.Popen[bytes]) -> None:
    """Wait until standard input closes, then end the whole process group."""
    while os.read(0, 1):
        pass
    os.killpg(0, signal.SIGINT)
    with suppress(subprocess.TimeoutExpired):
        child.wait(_GRACE)
    os.killpg(0, signal.SIGKILL)


def main() -> int:
    """Run the command in `sys.argv`; return its exit code."""
    for number in _SIGNALS:  # left to the command: a handler, unlike SIG_IGN, is not inherited
        signal.signal(number, lambda *_: None)
    child = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, close_fds=False)
    threading.Thread(target=_end_with_input, args=(child,), daemon=True).start()
    code = child.wait()
    return 128 - code if code < 0 else code


if __name__ == "__main__":
    sys.exit(main())
