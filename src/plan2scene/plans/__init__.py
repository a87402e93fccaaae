"""Floorplans: readers of every supported plan, checks, and the scene.json writer."""

from __future__ import annotations

from plan2scene.plans.formats import PlanFile as PlanFile
from plan2scene.plans.formats import PlanFormat as PlanFormat
from plan2scene.plans.formats import plan_formats as plan_formats
from plan2scene.plans.formats import read_plan as read_plan
from plan2scene.plans.plan_json import plan_schema as plan_schema
from plan2scene.plans.scene_json import read_scene_json as read_scene_json
from plan2scene.plans.scene_writer import house_to_scene as house_to_scene
from plan2scene.plans.scene_writer import write_scene_json as write_scene_json
from plan2scene.plans.validate import house_faults as house_faults
from plan2scene.plans.validate import validate_house as validate_house
