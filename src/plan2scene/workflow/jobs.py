"""The frame of a workflow script: its log, and one clear line when the user's input is at fault."""

from __future__ import annotations

import ctypes
import gc
import logging
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plan2scene.errors import InputError, told_in_a_line

#: Parameters of glibc's mallopt(3).
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
#: New objects after which circles among them are looked for: a job makes few, and by Python's own
#: number (700) the search takes a twentieth of a job's time, most of it while modules are loaded.
_NEW_OBJECTS = 100_000


def keep_freed_memory() -> None:
    """Let this process keep memory that it frees, for the arrays to come (glibc; else nothing).

    By default every large array is mapped anew and its pages are faulted in again, which is a
    third of the time that decoding takes.
    """
    if sys.platform != "linux":
        return
    allocator = getattr(ctypes.CDLL(None), "mallopt", None)
    if allocator is not None:
        allocator(_MMAP_THRESHOLD, 2**30)
        allocator(_TRIM_THRESHOLD, 2**31 - 1)


@contextmanager
def job(log: str | Path | None = None) -> Iterator[logging.Logger]:
    """Log to file `log` (and warnings to stderr); an InputError becomes one line and exit code 1.

    Control-C ends it without a word (130).

    >>> with job(snakemake.log[0]) as logger:  # doctest: +SKIP
    ...     logger.info("12 crops")
    """
    keep_freed_memory()
    usual = gc.get_threshold()
    gc.set_threshold(_NEW_OBJECTS, *usual[1:])
    logger = logging.getLogger("plan2scene")
    logger.setLevel(logging.INFO)
    handlers: list[logging.Handler] = [logging.StreamHandler(sys.stderr)]
    handlers[0].setLevel(logging.WARNING)
    if log is not None:
        Path(log).parent.mkdir(parents=True, exist_ok=True)
        handlers.append(logging.FileHandler(log, mode="w", encoding="utf-8"))
    for handler in handlers:
        handler.setFormatter(logging.Formatter("%(levelname)s %(message)s"))
        logger.addHandler(handler)
    try:
        with told_in_a_line():
            yield logger
    except InputError as error:
        logger.error("%s", error)
        raise SystemExit(1) from None
    except KeyboardInterrupt:
        raise SystemExit(128 + signal.SIGINT) from None
    except Exception:
        logger.exception("unexpected failure")
        raise
    finally:
        gc.set_threshold(*usual)
        for handler in handlers:
            logger.removeHandler(handler)
            handler.close()
