from importlib.metadata import entry_points

import pytest

from plan2scene.plans.formats import GROUP
from plan2scene_app.workflow.closures import rule_modules, rules

CLOSURES = {rule: set(rule_modules(rule)) for rule in rules()}


def users(module):
    return {rule for rule, modules in CLOSURES.items() if module in modules}


def test_a_module_is_part_of_the_rules_that_it_can_change_alone():
    assert len(CLOSURES["textures"]) < 60
    assert not [name for name in CLOSURES["textures"] if name.startswith("plan2scene.mesh")]
    # Each plan's own reader joins these by its suffix.
    assert "plan2scene_app.plan_formats.dxf" not in CLOSURES["floorplan"]
    for name in ("sheet", "panels"):
        assert users(f"plan2scene_app.contact_sheet.{name}") == {"contact_sheet"}
    drawn = {"house", "pictures", "lit_house", "export_house", "study_house"}
    assert users("plan2scene.mesh.joinery") == drawn


def test_plan_readers_are_of_the_plan_alone():
    readers = {e.module for e in entry_points(group=GROUP)} - {"plan2scene.plans.scene_json"}
    assert {"plan2scene_app.plan_formats.dxf", "plan2scene_app.plan_formats.ifc"} <= readers
    for reader in (*readers, "plan2scene.plans.formats"):
        assert users(reader) <= {"floorplan", "trace"}, reader


@pytest.mark.parametrize("rule", CLOSURES)
def test_every_rule_hangs_on_its_script_s_modules(rule):
    assert CLOSURES[rule]
    assert not [name for name in CLOSURES[rule] if name.startswith("plan2scene_app.workflow")]
