"""The registry of plan formats, which :func:`read_plan` and its messages use.

A format is an entry point of the group :data:`GROUP` that names a :class:`PlanFormat`. Formats of
other packages are found in the same way (docs/extending.md).
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from plan2scene.errors import InputError, WorkflowError, system_fault
from plan2scene.house import House
from plan2scene.plans.plan_file import PlanFile, PlanFormat
from plan2scene.plugins import installed, plugins

_LOG = logging.getLogger("plan2scene")
GROUP = "plan2scene.plan_formats"  #: Entry points of this group name a :class:`PlanFormat`


def plan_formats() -> tuple[PlanFormat, ...]:
    """Return all registered formats in the order in which they are tried."""
    return tuple(sorted(plugins(GROUP, PlanFormat).values(), key=lambda item: item.fallback))


def format_of(plan: PlanFile) -> PlanFormat | None:
    """Return the format of a file by its content; None if no format accepts it."""
    for entry in plan_formats():
        with one_line(plan, entry):
            if entry.sniff(plan):
                return entry
    return None


@contextmanager
def one_line(plan: PlanFile, plan_format: PlanFormat) -> Iterator[None]:
    """Turn errors that a format's reader did not foresee into an InputError of one line.

    An InputError that names no file gets this one. Any other exception (except errors of the
    system, missing packages and WorkflowError) becomes an InputError that names its type and has it
    as its cause. The traceback goes to the log at level INFO: the reader has a fault, too.
    """
    try:
        with installed(plan_format.needs, plan.house_id):
            yield
    except InputError as error:
        if str(error).startswith("expected "):
            raise plan.fault(error.expected, error.found) from error.__cause__
        raise
    except (ModuleNotFoundError, WorkflowError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and system_fault(error) is not None:
            raise
        _LOG.info("%s, read as %s", plan.path, plan_format.name, exc_info=True)
        found = f"{type(error).__name__}: {error} (not foreseen: please report it with the file)"
        raise plan.fault(f"{plan_format.name} that can be read", found) from error


def read_plan(
    path: str | Path,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
) -> House:
    """Return the house of a plan in one of :func:`plan_formats`; its content decides which.

    Parameters are those of :class:`PlanFile`; a format in pixels needs its scale.
    """
    plan = PlanFile(Path(path), house_id, metres_per_pixel, dxf_layers)
    if not plan.path.exists():
        raise plan.fault("a plan", "no such file")
    if not plan.head.strip():
        raise plan.fault("a plan", "an empty file")
    plan_format = format_of(plan)
    if plan_format is None:
        names = ", ".join(entry.name for entry in plan_formats())
        start = plan.binary + (" (plan2scene trace makes a plan of it)" * plan.is_picture)
        start = start or f"{(plan.text.split() or ['?'])[0][:40]!r} at its start"
        raise plan.fault(f"a plan ({names}) or a PNG or JPEG picture of one", start)
    if plan_format.needs_scale and not 0 < (metres_per_pixel or 0) <= 1:
        expected = f"metres_per_pixel above 0 and up to 1 for {plan_format.name}"
        raise plan.fault(expected, str(metres_per_pixel))
    with one_line(plan, plan_format):
        return plan_format.read(plan)
