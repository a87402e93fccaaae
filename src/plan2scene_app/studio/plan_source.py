"""The plan file that was uploaded to a project, and the values with which it is read.

``plan_source`` is the file. ``plan_source.json`` holds the values that the user gave for it (scale
and layers of a DXF), with the names of the configuration's ``floorplans``. ``two_points`` is the
scale that was set by two points in the editor; it takes precedence over ``metres_per_pixel``. The
page receives the plan that is read and saves it as ``plan.json`` in metres.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import png_bytes
from plan2scene.io import atomic_path, read_json, write_json
from plan2scene.plans.formats import format_of, one_line
from plan2scene.plans.plan_file import PlanFile, Unscaled
from plan2scene_app.editor.editor_page import opened, picture_bytes
from plan2scene_app.packed_photos import unpack_photos
from plan2scene_app.pdf import is_pdf
from plan2scene_app.plan_formats.dxf import LAYERS, MAX_PATTERN
from plan2scene_app.run import photos_in
from plan2scene_app.studio.limited import limited
from plan2scene_app.studio.projects import PICTURE, Project
from plan2scene_app.tracing.drawings import page_of_storeys
from plan2scene_app.tracing.picture import read_plan_picture

SOURCE, READING = "plan_source", "plan_source.json"
#: Allowed scales (metres per pixel or unit) and widths of a house (metres).
SCALES, WIDTHS = (1e-6, 1000.0), (1.0, 500.0)
#: Values of a file that was just uploaded.
_NOTHING: dict[str, Any] = {
    "metres_per_pixel": None,
    "two_points": None,
    "dxf_layers": {},
    "picture": None,
}


class UnreadPlanError(InputError):
    """A plan that cannot be read yet: a scale or layers may help; `reading` tells which."""

    def __init__(self, fault: InputError, reading: Mapping[str, Any]) -> None:
        super().__init__(fault.expected, fault.found)
        self.reading = reading


def read_upload(
    project: Project, content: bytes, parts: Sequence[tuple[str, int]] = ()
) -> dict[str, Any]:
    """Store an uploaded file and return its plan in the editor's form (:func:`opened`).

    If `content` holds pictures of single storeys one after the other, `parts` are their names and
    their sizes in bytes. They are stored as one page. Photos that a PDF contains are added to the
    project; ``photos`` are their names.
    InputError for a file that is not a plan; it is not stored. UnreadPlanError if a scale or layers
    may help to read it; it is stored.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plan"
        if len(parts) > 1:
            content = _page_of(content, parts, Path(folder))
        file.write_bytes(content)
        try:
            start = _opened(project, file, _NOTHING)
        except UnreadPlanError:
            _keep(project, content, _NOTHING)
            raise
        photos, notes = _add_photos(project, file, Path(folder)) if is_pdf(file) else ([], [])
    _keep(project, content, _NOTHING | {"picture": start.get("scale")})
    return start | {"photos": photos, "notes": [*start.get("notes", ()), *notes]}


def _add_photos(project: Project, pdf: Path, folder: Path) -> tuple[list[str], list[str]]:
    """Add the photos that a PDF contains to the project.

    Return their names, and a note for each that is left out: the plan is read all the same.
    """
    (unpacked := folder / "photos").mkdir()
    try:
        names = photos_in(unpacked, []) if limited(unpack_photos, pdf, unpacked) else []
    except InputError:  # drawings and pages only, or too large a file
        return [], []
    added, notes = [], []
    for name in names:
        try:
            project.add_photo(name, (unpacked / name).read_bytes())
            added.append(name)
        except InputError as fault:
            notes.append(f"photo {name} of this file is left out: {fault}")
    return added, notes


def _page_of(content: bytes, parts: Sequence[tuple[str, int]], folder: Path) -> bytes:
    """Return the PNG of one page with the pictures that `content` holds one after the other."""
    ends = np.cumsum([size for _, size in parts])
    if ends[-1] != len(content):
        raise InputError(f"pictures of {ends[-1]} bytes in all", f"{len(content)}")
    paths = [folder / str(number) for number in range(len(parts))]
    for path, (_, size), end in zip(paths, parts, ends, strict=True):
        path.write_bytes(content[end - size : end])
    return png_bytes(limited(page_of_storeys, paths, [name for name, _ in parts]))


def read_again(project: Project, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Read the stored file with these values and return it; store the values if that succeeds."""
    file = _file(project)
    values = _values(project, changes)
    start = _opened(project, file, values)
    write_json(project.path / READING, values | {"picture": start.get("scale")})
    return start


def keep_two_points(project: Project) -> None:
    """Store the scale that two points in the editor gave the picture, or remove it after an undo.

    If the stored values cannot be read, they stay as they are: reading the plan reports the error.
    """
    try:
        values = _kept(project)
    except InputError:
        return
    if not is_kept(project) or values["picture"] is None:
        return
    place = project.state()["place"] or {}
    file_pixels = values["picture"]["shown"]
    scale = place["metres_per_pixel"] / file_pixels if place.get("measured") else None
    if scale != values["two_points"]:
        write_json(project.path / READING, values | {"two_points": scale})


def is_kept(project: Project) -> bool:
    """Return whether a project has a stored plan file."""
    return (project.path / SOURCE).is_file()


def reading_of(project: Project) -> dict[str, Any]:
    """Return which scale and layers the user can set for the stored file, and those set so far."""
    return _reading(_file(project), project.name, _kept(project))


def _opened(project: Project, file: Path, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a file's plan in the editor's form; store its picture, if any, in the project."""
    try:
        scale, layers = values["metres_per_pixel"], values["dxf_layers"]
        start = limited(opened, file, project.name, scale, layers)
    except InputError as error:
        fault = InputError(error.expected, error.found)
        try:
            reading = _reading(file, project.name, values)
        except InputError:
            raise fault from None
        raise UnreadPlanError(fault, reading) from None
    if "picture" in start:
        with atomic_path(project.path / PICTURE) as temporary:
            temporary.write_bytes(picture_bytes(start["picture"]))
    return start


def _keep(project: Project, content: bytes, values: Mapping[str, Any]) -> None:
    with atomic_path(project.path / SOURCE, flush=True) as temporary:
        temporary.write_bytes(content)
    write_json(project.path / READING, values)


def _file(project: Project) -> Path:
    if not is_kept(project):
        raise InputError("a plan file that was opened in this home", "none")
    return project.path / SOURCE


def _kept(project: Project) -> dict[str, Any]:
    """Return the stored values, checked, because other programs may have changed them."""
    file = project.path / READING
    document = read_json(file) if file.is_file() else {}
    try:
        if not isinstance(document, dict):
            raise InputError("a JSON object", "other JSON")
        scales = {key: document.get(key) for key in ("metres_per_pixel", "two_points")}
        return {
            **{
                k: None if s is None else _number(s, "the scale", SCALES) for k, s in scales.items()
            },
            "dxf_layers": _layers(document.get("dxf_layers") or {}),
            "picture": _picture(document.get("picture")),
        }
    except InputError as error:
        raise InputError(error.expected, error.found, file=READING) from None


def _picture(document: Any) -> dict[str, Any] | None:
    """Return the stored facts of the picture (size, doubt, shown), checked."""
    if document is None:
        return None
    size = document.get("size") if isinstance(document, dict) else ()
    if size is not None and not (isinstance(size, list) and len(size) == 2):
        raise InputError("size, doubt and shown of the picture", repr(document)[:60])
    sides = [_number(side, "pixels of the plan", (0.0, 1e6)) for side in size or ()]
    file_pixels = _number(document.get("shown"), "pixels of the file for one shown", (1e-3, 1e3))
    return {"size": sides or None, "doubt": str(document.get("doubt", "")), "shown": file_pixels}


def _look(file: Path, house: str, values: Mapping[str, Any]) -> tuple[str, Unscaled]:
    """Return a file's format and size; InputError if the user cannot set its scale or layers."""
    plan = PlanFile(file, house, dxf_layers=values["dxf_layers"])
    if plan.is_picture:
        read_plan_picture(file)  # no scale helps to read what is no picture of a plan
        picture = values["picture"] or {}
        size = picture.get("size")
        return "picture", Unscaled("pixel", tuple(size) if size else None)
    plan_format = format_of(plan)
    if plan_format is None or plan_format.look is None:
        raise InputError("a plan whose scale or layers may be given", "one that contains both")
    with one_line(plan, plan_format):
        return plan_format.name, plan_format.look(plan)


def _reading(file: Path, house: str, values: Mapping[str, Any]) -> dict[str, Any]:
    name, look = limited(_look, file, house, values)
    return {
        "format": name,
        "unit": look.unit,
        "size": look.size,
        "names": [asdict(entry) for entry in look.names],
        "patterns": LAYERS if name == "DXF" else {},
        "metres_per_pixel": values["two_points"] or values["metres_per_pixel"],
        "dxf_layers": values["dxf_layers"],
        "doubt": "" if values["two_points"] else (values["picture"] or {}).get("doubt", ""),
    }


def _values(project: Project, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that a user gave for the stored file, checked.

    Instead of a scale, the user can give the ``width`` of the house if its drawn width is known.
    """
    scale, width = changes.get("metres_per_pixel"), changes.get("width")
    values = _kept(project) | {"dxf_layers": _layers(changes.get("dxf_layers") or {})}
    if scale is not None and width is not None:
        raise InputError("the scale or the width of the house", "both")
    _, look = limited(_look, _file(project), project.name, values)
    if width is not None:
        metres = _number(width, "a width of the house in metres", WIDTHS)
        if look.size is None or not look.size[0] > 0:
            raise InputError("metres of a pixel or unit", "a width, of a drawing of unknown size")
        scale = metres / look.size[0]
    if scale is not None:
        scale = _number(scale, f"metres of a {look.unit}", SCALES)
        longest = scale * max(look.size or (WIDTHS[0] / scale,))
        if not 0.999 * WIDTHS[0] <= longest <= 1.001 * WIDTHS[1]:
            expected = f"a scale that makes the house {WIDTHS[0]:g} to {WIDTHS[1]:g} m long"
            raise InputError(expected, f"{longest:.4g} m")
    return values | {"metres_per_pixel": scale, "two_points": None}


def _number(value: Any, what: str, limits: tuple[float, float]) -> float:
    """Return a finite number within limits."""
    low, high = limits
    number = value if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    if not low <= number <= high:
        raise InputError(f"{what}, {low:g} to {high:g}", repr(value))
    return float(number)


def _layers(patterns: Any) -> dict[str, str]:
    """Return patterns of DXF layers, checked, without empty ones, for which defaults are used."""
    if not isinstance(patterns, dict) or not set(patterns) <= set(LAYERS):
        raise InputError(f"patterns of {', '.join(LAYERS)}", "others")
    for kind, pattern in patterns.items():
        if not isinstance(pattern, str) or len(pattern) > MAX_PATTERN:
            expected = f"a pattern of at most {MAX_PATTERN} letters for {kind}"
            raise InputError(expected, repr(pattern)[:60])
    return {kind: pattern for kind, pattern in patterns.items() if pattern}
