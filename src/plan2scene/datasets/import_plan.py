"""Import a plan, with its data set's facts about it: check it and write it as scene.json.

Object boxes of Rent3D++ give the places of the furniture icons that are drawn in a plan.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plan2scene.datasets.assignments import check_assignment, read_assignment
from plan2scene.errors import InputError
from plan2scene.house import USUAL, House, IconBox
from plan2scene.io import read_text
from plan2scene.plans.formats import read_plan
from plan2scene.plans.parse import Source, parse_json
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.plans.usual_windows import with_usual_windows
from plan2scene.plans.validate import validate_house

_MARGIN = 0.5  #: Metres that a box may reach beyond the rooms (icons are drawn over walls)


def read_object_boxes(path: str | Path, house_id: str) -> tuple[IconBox, ...]:
    """Return the boxes of an ``objectaabb.json`` in file order, corners sorted, in metres.

    ``{"objects": [{"type", "bound_box": {"p1": [x, z], "p2": [x, z]}}]}``. Raises InputError for
    a file of another form.
    """
    if not Path(path).is_file():
        raise InputError("object boxes", "no such file", file=path, house=house_id)
    source = Source(str(path), house_id)
    document = source.mapping(parse_json(read_text(path), path, house_id), "object boxes")
    if "objects" not in document:
        raise source.fault("a list objects", ", ".join(document) or "an empty object")
    boxes = []
    for entry in source.items(document["objects"], "objects"):
        item = source.mapping(entry, "an object")
        (x0, z0), (x1, z1) = source.box(item, "an object")
        kind = item.get("type")
        if not isinstance(kind, str) or not kind:
            raise source.fault("a type of each object", repr(kind))
        boxes.append(IconBox(kind, (min(x0, x1), min(z0, z1)), (max(x0, x1), max(z0, z1))))
    return tuple(boxes)


def add_object_boxes(house: House, path: str | Path) -> tuple[House, list[str]]:
    """Return the house with the boxes of a file as its icons, and warnings.

    The plan's own icons come first. The file's boxes are put on the lowest level. There is a
    warning for a file that cannot be read (textures do not need it), and for a box that has no
    extent or is off the plan.
    """
    try:
        boxes = read_object_boxes(path, house.id)
    except InputError as error:
        return house, [str(error)]
    points = [point for room in house.rooms for ring in room.rings for point in ring]
    low = [min(point[axis] for point in points) - _MARGIN for axis in (0, 1)]
    high = [max(point[axis] for point in points) + _MARGIN for axis in (0, 1)]
    warnings = []
    for box in boxes:
        found = f"{box.type} from {box.p1} to {box.p2}"
        if box.p1[0] >= box.p2[0] or box.p1[1] >= box.p2[1]:
            expected = "object boxes with an extent"
        elif any(box.p1[a] < low[a] or box.p2[a] > high[a] for a in (0, 1)):
            expected = "object boxes within the plan"
        else:
            continue
        warnings.append(str(InputError(expected, found, file=path, house=house.id)))
    level = house.levels[0].id if house.levels else ""
    icons = (replace(box, level=level) for box in boxes)
    return replace(house, icons=tuple(dict.fromkeys((*house.icons, *icons)))), warnings


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
    traced: bool = False,
    name: str = "",
) -> House:
    """Read, check and write a plan as scene.json; warnings go to the log. Return the house.

    `assignment` is the house's photo table: its rooms and photo names are checked here, so that
    a wrong table stops the house before any photo is processed. There is a warning for an empty
    table, for "" (the house has none), and for photos missing in `photos_dir`; None skips the
    check. `traced` is passed to :func:`.assignments.read_assignment`. `name` is what people call
    the house, if its plan does not say. A drawing without windows gets usual ones
    (:mod:`plan2scene.plans.usual_windows`). The boxes in file `object_boxes` become the house's
    icons; a faulty file is only a warning.
    """
    house = read_plan(path, house_id, metres_per_pixel, dxf_layers)
    house = replace(house, name=house.name or name)
    warnings = validate_house(house, file=path)
    if house.heights == USUAL:  # a drawing
        house = with_usual_windows(house)
    if assignment is not None:
        rows = read_assignment(assignment, house, traced=traced)
        if photos_dir is not None or not rows:
            warnings += check_assignment(house, rows, photos_dir or "", file=assignment)
    if object_boxes:
        house, lines = add_object_boxes(house, object_boxes)
        warnings += lines
    for line in warnings:
        _LOGGER.warning("%s", line)
    write_scene_json(house, output)
    return house
