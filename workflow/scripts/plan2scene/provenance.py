"""What a job's result depends on beyond its input files: the library's source.

Snakemake reruns a rule when its script changes, not when a module that the script imports does.
Rules therefore pass :func:`code_hash` of the modules they use through ``params``.
"""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).parent


def _module_file(module: str) -> Path | None:
    """Return the source file of ``plan2scene.x.y`` (a package gives its ``__init__.py``)."""
    base = PACKAGE.joinpath(*module.split(".")[1:])
    for candidate in (base.with_suffix(".py"), base / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


def _imports(file: Path) -> set[str]:
    """Return the plan2scene modules that a source file imports, at any depth of nesting."""
    found: set[str] = set()
    folder = ["plan2scene", *file.relative_to(PACKAGE).parts[:-1]]
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = folder[: len(folder) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            found.add(module)
            found.update(f"{module}.{alias.name}" for alias in node.names)
    return {name for name in found if name.split(".")[0] == "plan2scene"}


@cache
def _dependencies(module: str) -> tuple[Path, ...]:
    """Return the files of `module` and of all that it imports, transitively, sorted."""
    seen: dict[str, Path] = {}
    queue = [module]
    while queue:
        name = queue.pop()
        file = None if name in seen else _module_file(name)
        if file is None:
            continue
        seen[name] = file
        queue.extend(_imports(file))
    return tuple(sorted(set(seen.values())))


@cache
def code_hash(*modules: str) -> str:
    """Return 16 hex digits over the sources of `modules` and all they import in the library.

    Parameters
    ----------
    modules : str
        Names below the package: ``"textures.seams"``. Raises ValueError for one that is not there.
    """
    files: set[Path] = set()
    for module in modules:
        found = _dependencies(f"plan2scene.{module}")
        if not found:
            raise ValueError(f"no module plan2scene.{module}")
        files.update(found)
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.relative_to(PACKAGE).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def file_hash(path: str | Path) -> str:
    """Return 16 hex digits of a file's SHA-256 (names the weights that made a table)."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def package_versions(*packages: str) -> str:
    """Return ``name version`` of installed packages, separated by commas."""
    return ", ".join(f"{name} {version(name)}" for name in packages)
