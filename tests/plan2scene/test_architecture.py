"""The import contract, read from the sources: arrows go down only, nothing imports the workshop."""

import ast
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

CLONE = Path(__file__).parents[2]
LIBRARY = CLONE / "src" / "plan2scene"
APP = CLONE / "src" / "plan2scene_app"
WORKSHOP = CLONE / "workshop" / "src" / "plan2scene_workshop"
#: Packages by layer, from the one above the ground up (docs/architecture.md has the same table).
#: All modules of the library's own folder that are not named here are the ground.
LAYERS = (
    {"plans", "materials", "metrics", "paint"},
    {"photos", "propagation", "mesh"},
    {"textures", "datasets"},
    {"evaluation", "checkpoints"},
    {"config", "workflow"},
)


def sources(package: Path) -> dict[str, Path]:
    """Return a package's modules by dotted name."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(path: Path, *, at_import_time: bool) -> Iterator[tuple[str, str]]:
    """Yield ``("a.b", "")`` for ``import a.b``, ``("a.b", "c")`` for ``from a.b import c``.

    With `at_import_time` not those inside functions and under ``if TYPE_CHECKING``.
    """
    queue: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while queue:
        node = queue.pop()
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: a relative import"
            yield from ((str(node.module), alias.name) for alias in node.names)
        elif not (at_import_time and is_late(node)):
            queue.extend(ast.iter_child_nodes(node))


def is_late(node: ast.AST) -> bool:
    """Return whether what is inside is not run when the module is imported."""
    if isinstance(node, ast.If):
        return "TYPE_CHECKING" in ast.dump(node.test)
    return isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)


def imported_packages(path: Path) -> set[str]:
    """Return the first names of all that a source file imports, anywhere in it."""
    return {module.split(".")[0] for module, _ in imports(path, at_import_time=False)}


def graph(package: Path, *, at_import_time: bool) -> dict[str, set[str]]:
    """Return who imports whom among a package's modules."""
    modules = sources(package)
    found: dict[str, set[str]] = {name: set() for name in modules}
    for name, path in modules.items():
        for module, what in imports(path, at_import_time=at_import_time):
            target = f"{module}.{what}" if f"{module}.{what}" in modules else module
            if target in modules and target != name:
                found[name].add(target)
    return found


def between_packages(modules: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """Return the graph of the parts right below the package; a module there is a part too."""
    parts: dict[str, set[str]] = {}
    for source, targets in modules.items():
        for target in targets:
            a, b = (name.partition(".")[2].partition(".")[0] for name in (source, target))
            if a != b and b:
                parts.setdefault(a, set()).add(b)
    return parts


def cycle(found: Mapping[str, set[str]]) -> list[str]:
    """Return the members of a cycle; none where there is none."""
    try:
        TopologicalSorter(found).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_library_imports_neither_workshop_nor_snakemake():
    forbidden = {"plan2scene_workshop", "snakemake", "mitsuba"}
    modules = sources(LIBRARY) | sources(APP)
    found = {name: imported_packages(path) & forbidden for name, path in modules.items()}
    assert {name: names for name, names in found.items() if names} == {}


def test_core_imports_no_app():
    found = {
        n for n, path in sources(LIBRARY).items() if "plan2scene_app" in imported_packages(path)
    }
    assert found == set()


@pytest.mark.parametrize("package", [LIBRARY, APP, WORKSHOP], ids=lambda path: path.name)
def test_no_cycle(package):
    assert cycle(graph(package, at_import_time=True)) == []
    assert cycle(between_packages(graph(package, at_import_time=False))) == []


def test_arrows_go_down_only():
    layer = {name: i for i, names in enumerate(LAYERS, start=1) for name in names}
    folders = {path.name for path in LIBRARY.iterdir() if (path / "__init__.py").is_file()}
    assert folders == layer.keys() - {"config"}
    parts = between_packages(graph(LIBRARY, at_import_time=False))
    wrong = [
        f"{a} imports {b}"
        for a, targets in parts.items()
        for b in targets
        if b in layer and layer.get(a, 0) <= layer[b]
    ]
    assert wrong == []
