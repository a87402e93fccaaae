"""What all workflow scripts share: a log, and one clear line for a fault in the user's input."""

from __future__ import annotations

import logging
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plan2scene.errors import InputError, one_line_errors


@contextmanager
def job(log: str | Path, *, warn: bool = True) -> Iterator[logging.Logger]:
    """Log to file `log`, and errors to stderr; an InputError becomes one line and exit code 1.

    Warnings go to stderr, too, if `warn` is set.

    Control-C ends it without a message (exit code 130).

    >>> with job(snakemake.log[0]) as logger:  # doctest: +SKIP
    ...     logger.info("12 crops")
    """
    logger = logging.getLogger("plan2scene")
    logger.setLevel(logging.INFO)
    Path(log).parent.mkdir(parents=True, exist_ok=True)
    faults = logging.StreamHandler(sys.stderr)
    faults.setLevel(logging.WARNING if warn else logging.ERROR)
    handlers = faults, logging.FileHandler(log, mode="w", encoding="utf-8")
    for handler in handlers:
        handler.setFormatter(logging.Formatter("%(levelname)s %(message)s"))
        logger.addHandler(handler)
    try:
        with one_line_errors():
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
        for handler in handlers:
            logger.removeHandler(handler)
            handler.close()
