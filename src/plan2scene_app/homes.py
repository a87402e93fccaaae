"""Make many homes in one go: each is a folder or ZIP archive with its plan and photos, unsorted."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from plan2scene.errors import InputError, WorkflowError, one_line_errors
from plan2scene.io import absent
from plan2scene.plans.formats import format_of
from plan2scene.plans.plan_file import PlanFile
from plan2scene_app.bound_process import EndedError
from plan2scene_app.ids import fit_id
from plan2scene_app.out_folder import WORK, is_out_folder
from plan2scene_app.packed_photos import is_packed, photo_files, unpacked
from plan2scene_app.pdf import is_pdf
from plan2scene_app.run import SingleHouse, is_page, run
from plan2scene_app.tracing.drawings import storey_told
from plan2scene_app.workflow.failures import failures

#: Words in the names of pictures of plans; the studio's page has the same (editor/photos.js).
_NAMED = re.compile(r"plan|grundriss|floor|layout|piso|etage", re.IGNORECASE)


def failure_of_home(
    home: Path, out: Path, settings: SingleHouse, *, cores: int, printed: str = "lines"
) -> str:
    """Make one of :func:`homes_in` in the folder `out`, named after it; return why it failed.

    The text is empty if it is made. `settings` are those of every home; its files and names are
    replaced. EndedError if a signal asks this process to end.
    """
    house = fit_id(out.name, "home")
    try:
        with one_line_errors(), unpacked(home) as files:
            folder = files or home
            found = photo_files(folder)
            plan, *storeys = plans_among(found.values(), folder)
            alone = is_pdf(plan) and len(found) == 1  # its photos are in the PDF, too
            request = replace(settings, house=house, name=out.name, plan=plan)
            request = replace(request, storeys=tuple(storeys))
            request = replace(request, photos_dir=plan if alone else folder)
            run(request, out, cores=cores, printed=printed)
    except EndedError:
        raise
    except InputError as error:
        return str(error)
    except WorkflowError as error:
        told = failures(out / WORK / "logs", [house])
        return told[0].removeprefix("failed: ") if told else str(error)
    return ""


def homes_in(folder: Path, out: Path) -> dict[str, Path]:
    """Return the folders and ZIP archives in a folder by the names of their homes, sorted.

    Hidden ones, results of runs and `out` are left out, and an archive beside a folder of its name.
    InputError if there is none.
    """
    if not folder.is_dir():
        raise InputError("a folder with a folder for each home", absent(folder), file=folder)
    paths = [path for path in sorted(folder.iterdir()) if not path.name.startswith(".")]
    homes = {path.stem: path for path in paths if is_packed(path)}
    for path in paths:
        if path.is_dir() and not is_out_folder(path) and path.resolve() != out.resolve():
            homes[path.name] = path
    if not homes:
        raise InputError("a folder with a folder for each home", "none in it", file=folder)
    return dict(sorted(homes.items()))


def plans_among(files: Collection[Path], folder: Path) -> list[Path]:
    """Return the plan among a home's files, or the pictures of its storeys.

    It is the only plan file; else the only picture that is mostly paper, or PDF; else the only one
    of these with a name of plans. Several are storeys if their names tell which. Photos count if
    nothing else is a plan. InputError that names several candidates, or says that there is none.
    """
    plans = [path for path in files if _is_plan(path)]
    drawn = plans or [path for path in files if is_pdf(path) or is_page(path)]
    if len(drawn) != 1:
        drawn = [path for path in drawn or files if _NAMED.search(path.stem)] or drawn
    storeys = {storey_told(path.stem.replace("_", " ")) for path in drawn}
    if len(drawn) == 1 or (drawn and None not in storeys and len(storeys) == len(drawn)):
        return drawn
    names = ", ".join(path.name for path in drawn[:5])
    expected = "one plan, or one picture of each storey, such as plan_ground_floor.jpg"
    raise InputError(expected, names or "none", file=folder)


def _is_plan(path: Path) -> bool:
    """Return whether a file is a plan in a format that holds rooms, no picture."""
    plan = PlanFile(path, "home")
    try:
        return not plan.is_picture and format_of(plan) is not None
    except InputError:
        return False
