"""Floorplans: readers of every supported plan, checks, and the scene.json writer."""

from __future__ import annotations

from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.floorplans.object_boxes import (
    add_object_boxes,
    check_object_boxes,
    read_object_boxes,
)
from plan2scene.floorplans.parse import parse_json
from plan2scene.floorplans.plan_json import FORMAT, house_of_plan, plan_schema, read_plan_json
from plan2scene.floorplans.r2v import house_of_r2v, read_r2v
from plan2scene.floorplans.scene_json import house_of_scene, read_scene_json
from plan2scene.floorplans.scene_textures import read_scene_textures
from plan2scene.floorplans.scene_writer import house_to_scene, write_scene_json
from plan2scene.floorplans.validate import house_faults, validate_house
from plan2scene.house import House
from plan2scene.io import read_text

__all__ = [
    "add_object_boxes",
    "check_object_boxes",
    "house_faults",
    "house_to_scene",
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
