"""A plan and what its data set says of it, checked and written as scene.json."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path

from plan2scene.datasets.assignments import check_assignment, read_assignment
from plan2scene.house import House
from plan2scene.plans import add_object_boxes, read_plan, validate_house, write_scene_json

_LOGGER = logging.getLogger("plan2scene")


def import_plan(
    path: str | Path,
    output: str | Path,
    *,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
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
    house = read_plan(path, house_id, metres_per_pixel, dxf_layers)
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
