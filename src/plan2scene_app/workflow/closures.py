"""What the result of a job depends on: the modules of its script, plugins, contents of files.

Snakemake reruns a rule when its script changes, not when a module that the script imports does.
Rules therefore pass a hash of those modules through ``params``.

python -m plan2scene_app.workflow.closures           # how many modules each rule depends on
python -m plan2scene_app.workflow.closures textures  # which
"""

from __future__ import annotations

import ast
import hashlib
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from plan2scene.plans import formats
from plan2scene.plans.plan_file import PlanFormat
from plan2scene.plugins import Plugin, distribution, is_ours, loaded
from plan2scene.provenance import PACKAGE, WORKFLOW
from plan2scene.textures import methods
from plan2scene.textures.methods import TextureMethod
from plan2scene_app.exports import registry

#: The core and the app: packages whose imports count by default.
PACKAGES = (PACKAGE, PACKAGE.parent / "plan2scene_app")
#: Package that only runs the scripts; their results do not depend on it.
_RUNNER = "plan2scene_app.workflow"
_SCRIPTS = WORKFLOW / "workflow" / "scripts"
#: :func:`contents_hash` reads a file of at most so many bytes whole, else pieces of so many bytes.
_WHOLE, _PIECE = 200_000, 4096


@cache
def _module_file(module: str, packages: tuple[Path, ...]) -> Path | None:
    """Return the source file of ``plan2scene.x.y`` (a package gives its ``__init__.py``)."""
    top, *parts = module.split(".")
    for package in packages:
        base = package.joinpath(*parts)
        for candidate in (base.with_suffix(".py"), base / "__init__.py"):
            if package.name == top and candidate.is_file():
                return candidate
    return None


@cache
def _source(file: Path) -> str:
    return file.read_text(encoding="utf-8")


@cache
def _digest(file: Path) -> bytes:
    return hashlib.sha256(file.read_bytes()).digest()


@cache
def imports(file: Path) -> frozenset[str]:
    """Return the dotted names that a source file imports, inside functions too.

    ``from a import b`` gives both ``a`` and ``a.b``, because ``b`` may be a module. Relative
    imports are ignored: our packages have none.
    """
    names: set[str] = set()
    for statement in _statements(ast.parse(_source(file)).body):
        if isinstance(statement, ast.Import):
            names.update(alias.name for alias in statement.names)
        elif isinstance(statement, ast.ImportFrom) and statement.module:
            names.add(statement.module)
            names.update(f"{statement.module}.{alias.name}" for alias in statement.names)
    return frozenset(names)


def _statements(body: Sequence[ast.AST]) -> Iterator[ast.AST]:
    """Yield statements and the statements inside them; an expression cannot contain an import."""
    for statement in body:
        yield statement
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from _statements(getattr(statement, part, ()))


@cache
def closure(module: str, packages: tuple[Path, ...] = PACKAGES) -> Mapping[str, Path]:
    """Return name to file for `module` and all that it imports from `packages`, directly or not."""
    file_by_name: dict[str, Path] = {}
    queue = [module]
    while queue:
        name = queue.pop()
        file = None if name in file_by_name else _module_file(name, packages)
        if file is not None:
            file_by_name[name] = file
            queue.extend(imports(file))
    return file_by_name


def _data_files(module: Path) -> set[Path]:
    """Return the files beside a module that its source names: tables, schemas, pages."""
    source = _source(module)
    return {path for path in _files_beside(module.parent) if f'"{path.name}"' in source}


@cache
def _files_beside(folder: Path) -> tuple[Path, ...]:
    """Return the files of a package's folder that are not Python modules."""
    return tuple(path for path in folder.iterdir() if path.suffix not in ("", ".py"))


@cache
def code_hash(*modules: str, packages: tuple[Path, ...] = PACKAGES) -> str:
    """Return 16 hex digits over the sources of `modules` and all they import in `packages`.

    Modules have full names (``"plan2scene.textures.seams"``); ValueError for one that is not there.
    `packages` are folders, whose name is their import name. A data file beside a module counts as
    source if the module's source names it.
    """
    files: set[Path] = set()
    for module in modules:
        found = closure(module, packages).values()
        if not found:
            raise ValueError(f"no module {module}")
        files.update(found, *map(_data_files, found))
    names = {
        f"{package.name}/{file.relative_to(package).as_posix()}": file
        for package in packages
        for file in files
        if file.is_relative_to(package)
    }
    digest = hashlib.sha256()
    for name in sorted(names):
        digest.update(name.encode() + b"\0" + _digest(names[name]))
    return digest.hexdigest()[:16]


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


@cache
def _code_of(group: str, kind: type[Plugin], *names: str) -> list[str]:
    """Return strings that change with the code of these plugins, for the params of a rule.

    For our own plugins it is the hash of the module, for others their package's name and version.
    """
    entries = [loaded(group, kind)[name][0] for name in names]
    return [code_hash(entry.module) if is_ours(entry) else distribution(entry) for entry in entries]


def reader_code(suffix: str) -> list[str]:
    """Return strings that change with the code of the readers of this suffix (if none, of all)."""
    named = [item.name for item in formats.plan_formats() if suffix in item.suffixes]
    every = loaded(formats.GROUP, PlanFormat)
    return _code_of(formats.GROUP, PlanFormat, *(named or every))


def method_code(*names: str) -> list[str]:
    """Return strings that change whenever the code of these texture methods changes."""
    return _code_of(methods.GROUP, TextureMethod, *names)


def export_code(name: str) -> list[str]:
    """Return strings that change when the code of an export changes."""
    return _code_of(registry.GROUP, registry.Export, name)


def contents_hash(paths: Iterable[str | Path]) -> str:
    """Return 16 hex digits that depend on the contents of files, not on their time stamps.

    Folders and missing files are skipped. Of a file above `_WHOLE` bytes only the size and three
    pieces are read, so that the files of thousands of houses take seconds.
    """
    digest = hashlib.sha256()
    for path in paths:
        if not Path(path).is_file():
            continue
        with Path(path).open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            digest.update(f"{size}\n".encode())
            if size <= _WHOLE:
                digest.update(file.read(_WHOLE))
            else:
                for place in (0, size // 2, size - _PIECE):
                    file.seek(place)
                    digest.update(file.read(_PIECE))
    return digest.hexdigest()[:16]


def _report(asked: list[str]) -> str:
    """Return the modules of the rules in `asked`; if that is empty, the number for each rule."""
    if asked:
        return "\n".join(name for rule in asked for name in rule_modules(rule))
    return "\n".join(f"{rule:20} {len(rule_modules(rule)):4}" for rule in rules())


if __name__ == "__main__":
    sys.stdout.write(_report(sys.argv[1:]) + "\n")
