"""Files from strangers are read in a child process of limited time and memory."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from plan2scene.errors import InputError

#: Most seconds and bytes that a file may take: tracing a picture takes 20 s and 0.7 GB.
SECONDS, BYTES = 120.0, 4_000_000_000
#: Children are forked from a process without threads that has imported this.
_PRELOADED = ["plan2scene_app.editor.editor_page"]

P = ParamSpec("P")
T = TypeVar("T")


def limited(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """Return what a function of a module returns, or raise what it raises, in a child process.

    InputError where it takes more than `SECONDS` or `BYTES`, or crashes.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_PRELOADED)
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(
        target=_answer, args=(theirs, BYTES, function, arguments, named), daemon=True
    )
    child.start()
    theirs.close()
    try:
        if not ours.poll(SECONDS):
            raise InputError(f"a file that is read within {SECONDS:g} s", "one that takes longer")
        ok, result = ours.recv()
    except EOFError:
        raise InputError("a file that can be read", "one that its reader crashes of") from None
    finally:
        child.kill()
        child.join()
        ours.close()
    if ok:
        return result
    if isinstance(result, MemoryError):
        expected = f"a file that is read with {BYTES / 1e9:g} GB of memory"
        raise InputError(expected, "one that takes more")
    raise result


def _answer(
    pipe: Connection, most: int, function: Callable[..., Any], arguments: Any, named: Any
) -> None:
    """Send (True, result) or (False, exception)."""
    try:
        import resource
    except ImportError:  # not on Windows
        pass
    else:
        # Not RLIMIT_AS, which counts what a library for GPUs only reserves.
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    try:
        answer = (True, function(*arguments, **named))
    except Exception as error:  # noqa: BLE001 - raised again where it was called
        answer = (False, error.__cause__ if isinstance(error.__cause__, MemoryError) else error)
    pipe.send(answer)
