"""A rule's hash of source covers what its script imports: change a module and it runs again."""

import re
from pathlib import Path

import pytest

from plan2scene.provenance import PACKAGES, _dependencies, _module_file

WORKFLOW = Path(__file__).parents[2] / "workflow"
RULES = {
    block.split(":")[0]: block
    for path in WORKFLOW.glob("rules/*.smk")
    for block in re.split(r"^rule ", path.read_text(), flags=re.MULTILINE)[1:]
    if "script:" in block
}
#: Of the rule that reads plans, whose hash each plan's format decides.
PLAN_CODE = '"plan2scene.datasets.import_plan"'
#: The frame of every script: it decides nothing about a result.
FRAME = "plan2scene.workflow.jobs"


@pytest.mark.parametrize("rule", sorted(RULES))
def test_the_hash_covers_what_the_script_imports(rule):
    (arguments,) = re.findall(r"code_hash\(([^)]*)\)", RULES[rule]) or [PLAN_CODE]
    (script,) = re.findall(r'"\.\./scripts/(\w+\.py)"', RULES[rule])
    text = (WORKFLOW / "scripts" / script).read_text()
    imported = set(re.findall(r"^from (plan2scene[\w.]*) import", text, re.MULTILINE)) - {FRAME}
    hashed = re.findall(r'"(.+?)"', arguments)
    covered = set().union(*(_dependencies(name, PACKAGES) for name in hashed))
    assert imported
    assert {name for name in imported if _module_file(name, PACKAGES) not in covered} == set()
