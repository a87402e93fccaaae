"""Read files from strangers in a child process with limited time and memory."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from plan2scene.errors import InputError

#: Limits of time (seconds) and memory (bytes): tracing a picture takes 20 s and 0.7 GB.
SECONDS, BYTES = 120.0, 4_000_000_000
#: Modules that the fork server imports. Children are forked from it because it has no threads.
_PRELOADED = ["plan2scene_app.studio.plan_source", "plan2scene_app.tracing.drawings"]
_PRELOADED += [
    f"plan2scene_app.plan_formats.{name}"
    for name in ("cubicasa", "dxf", "ifc", "roomplan", "sweet_home", "zind")
]

P = ParamSpec("P")
T = TypeVar("T")


def limited(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """Call a function in a child process; return its result or raise its exception.

    The function must be defined at the top level of a module. InputError if it takes more than
    `SECONDS` or `BYTES`, or if the child crashes.
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
        raise InputError("a file that can be read", "one on which its reader crashes") from None
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
    """Call the function with at most `most` bytes; send (True, result) or (False, exception)."""
    try:
        import resource
    except ImportError:  # not on Windows
        pass
    else:
        # Not RLIMIT_AS: it also counts address space that GPU libraries reserve but do not use.
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    try:
        answer = (True, function(*arguments, **named))
    except Exception as error:  # noqa: BLE001 - raised again where it was called
        answer = (False, error.__cause__ if isinstance(error.__cause__, MemoryError) else error)
    pipe.send(answer)
