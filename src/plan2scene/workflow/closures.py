"""The modules that a rule's result depends on: all that its script imports, directly or not.

python -m plan2scene.workflow.closures           # how many modules each rule depends on
python -m plan2scene.workflow.closures textures  # which
"""

from __future__ import annotations

import sys
from functools import cache

from plan2scene.provenance import WORKFLOW, closure, code_hash, imports

#: Package that only runs the scripts; their results do not depend on it.
_RUNNER = "plan2scene.workflow"
_SCRIPTS = WORKFLOW / "workflow" / "scripts"


def rules() -> list[str]:
    """Return the rules that have a script."""
    return sorted(path.stem for path in _SCRIPTS.glob("*.py"))


@cache
def _imported(rule: str) -> tuple[str, ...]:
    """Return the modules that the script of a rule imports itself."""
    names = sorted(name for name in imports(_SCRIPTS / f"{rule}.py") if closure(name))
    return tuple(name for name in names if not name.startswith(_RUNNER))


def rule_modules(rule: str) -> list[str]:
    """Return the names of all modules that a rule depends on.

    Modules of other packages' plugins (plan formats, texture methods, exports) are not included;
    for them the package's version counts.
    """
    return sorted({name for module in _imported(rule) for name in closure(module)})


@cache
def rule_code(rule: str) -> str:
    """Return the hash of all modules that a rule depends on."""
    return code_hash(*_imported(rule))


def _report(asked: list[str]) -> str:
    """Return the modules of the rules in `asked`; if that is empty, the number for each rule."""
    if asked:
        return "\n".join(name for rule in asked for name in rule_modules(rule))
    return "\n".join(f"{rule:20} {len(rule_modules(rule)):4}" for rule in rules())


if __name__ == "__main__":
    sys.stdout.write(_report(sys.argv[1:]) + "\n")
