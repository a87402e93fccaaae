"""Floorplans: readers of every supported plan, checks, and the scene.json writer."""

from __future__ import annotations

from plan2scene.floorplans.formats import FORMATS, PlanFile, PlanFormat, read_plan
from plan2scene.floorplans.object_boxes import (
    add_object_boxes,
    check_object_boxes,
    read_object_boxes,
)
from plan2scene.floorplans.plan_json import plan_schema
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.floorplans.scene_writer import house_to_scene, write_scene_json
from plan2scene.floorplans.validate import house_faults, validate_house

__all__ = [
    "FORMATS",
    "PlanFile",
    "PlanFormat",
    "add_object_boxes",
    "check_object_boxes",
    "house_faults",
    "house_to_scene",
    "plan_schema",
    "read_object_boxes",
    "read_plan",
    "read_scene_json",
    "validate_house",
    "write_scene_json",
]
