from graphlib import CycleError, TopologicalSorter

import pytest
from places import ROOT

from plan2scene_app.workflow.closures import imports

LIBRARY = ROOT / "src" / "plan2scene"
APP = ROOT / "src" / "plan2scene_app"
WORKSHOP = ROOT / "workshop" / "src" / "plan2scene_workshop"
#: Packages by layer, from the one above the ground up (docs/architecture.md has the same table).
#: All modules of the library's own folder that are not named here are the ground.
LAYERS = (
    {"plans", "materials", "metrics", "paint"},
    {"photos", "propagation", "mesh"},
    {"textures", "datasets"},
    {"evaluation", "checkpoints"},
)


def sources(package):
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imported_packages(path):
    """Return the first names of all that a source file imports, anywhere in it."""
    return {name.split(".")[0] for name in imports(path)}


def graph(package):
    modules = sources(package)
    return {name: (imports(path) & modules.keys()) - {name} for name, path in modules.items()}


def between_packages(modules):
    """Return the graph of the parts right below the package; a module there is a part too."""
    parts: dict[str, set[str]] = {}
    for source, targets in modules.items():
        for target in targets:
            a, b = (name.partition(".")[2].partition(".")[0] for name in (source, target))
            if a != b and b:
                parts.setdefault(a, set()).add(b)
    return parts


def cycle(found):
    try:
        TopologicalSorter(found).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_nothing_imports_what_lies_above_it():
    forbidden = {"plan2scene_workshop", "snakemake", "mitsuba"}
    modules = sources(LIBRARY) | sources(APP)
    found = {name: imported_packages(path) & forbidden for name, path in modules.items()}
    assert {name: names for name, names in found.items() if names} == {}
    found = {n for n, p in sources(LIBRARY).items() if "plan2scene_app" in imported_packages(p)}
    assert found == set()


@pytest.mark.parametrize("package", [LIBRARY, APP, WORKSHOP], ids=lambda path: path.name)
def test_no_cycle(package):
    modules = graph(package)
    assert cycle(between_packages(modules)) == []
    others = {a: {b for b in found if not a.startswith(f"{b}.")} for a, found in modules.items()}
    assert cycle(others) == []


def test_arrows_go_down_only():
    layer = {name: i for i, names in enumerate(LAYERS, start=1) for name in names}
    folders = {path.name for path in LIBRARY.iterdir() if (path / "__init__.py").is_file()}
    assert folders == layer.keys()
    wrong = [
        f"{a} imports {b}"
        for a, targets in between_packages(graph(LIBRARY)).items()
        for b in targets
        if b in layer and layer.get(a, 0) <= layer[b]
    ]
    assert wrong == []
