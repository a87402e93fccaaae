"""Floorplans: readers of every supported plan, checks, and the scene.json writer."""

from __future__ import annotations

import logging
from pathlib import Path

from plan2scene.datasets.assignments import check_assignment, read_assignment
from plan2scene.errors import InputError
from plan2scene.floorplans.object_boxes import (
    add_object_boxes,
    check_object_boxes,
    read_object_boxes,
)
from plan2scene.floorplans.parse import parse_json
from plan2scene.floorplans.plan_json import FORMAT, house_of_plan, plan_schema, read_plan_json
from plan2scene.floorplans.r2v import house_of_r2v, read_r2v
from plan2scene.floorplans.scene_json import (
    house_of_scene,
    house_to_scene,
    read_scene_json,
    read_scene_textures,
    write_scene_json,
)
from plan2scene.floorplans.validate import house_faults, validate_house
from plan2scene.house import House
from plan2scene.io import read_text

__all__ = [
    "add_object_boxes",
    "check_object_boxes",
    "house_faults",
    "house_to_scene",
    "import_plan",
    "plan_schema",
    "read_object_boxes",
    "read_plan",
    "read_plan_json",
    "read_r2v",
    "read_scene_json",
    "read_scene_textures",
    "validate_house",
    "write_scene_json",
]

_LOGGER = logging.getLogger("plan2scene")


def read_plan(path: str | Path, house_id: str, metres_per_pixel: float | None = None) -> House:
    """Return the house of any supported plan; what it is, is told by its content.

    Parameters
    ----------
    path : path
        scene.json, this program's plan JSON, or a raster-to-vector text file of either dialect.
    house_id : str
        Name that the house gets.
    metres_per_pixel : float, optional
        Scale of raster-to-vector files, which are in pixels; needed for those only.
    """
    if not Path(path).is_file():
        raise InputError("a plan", "no such file", file=path, house=house_id)
    text = read_text(path)
    if not text.strip():
        raise InputError("a plan", "an empty file", file=path, house=house_id)
    if text.lstrip()[0] not in "{[":
        return house_of_r2v(text, house_id, metres_per_pixel, file=str(path))
    document = parse_json(text, path, house_id)
    if isinstance(document, dict) and str(document.get("format")) == FORMAT:
        return house_of_plan(document, house_id, file=str(path))
    return house_of_scene(document, house_id, file=str(path))


def import_plan(
    path: str | Path,
    output: str | Path,
    *,
    house_id: str,
    metres_per_pixel: float | None = None,
    assignment: str | Path | None = None,
    photos_dir: str | Path | None = None,
    object_boxes: str | Path | None = None,
) -> House:
    """Read, check and write a plan as scene.json; warnings go to the log. Return the house.

    `assignment` is the house's photo table: its rooms and photo names are checked here, so that
    a wrong table stops the house before any photo is worked on. An empty one, or "" for a house
    that has none, is a warning, and so is a photo that `photos_dir` lacks; None asks for no check.
    Boxes of an `object_boxes` file become the house's icons; a faulty file is a warning.
    """
    house = read_plan(path, house_id, metres_per_pixel)
    warnings = validate_house(house, file=path)
    if assignment is not None:
        rows = read_assignment(assignment, house)
        if photos_dir is not None or not rows:
            warnings += check_assignment(house, rows, photos_dir or "", file=assignment)
    if object_boxes:
        house, lines = add_object_boxes(house, object_boxes)
        warnings += lines
    for line in warnings:
        _LOGGER.warning("%s", line)
    write_scene_json(house, output)
    return house
