"""Hashes of what a job's result depends on: the library's source, weights, contents of files.

Snakemake reruns a rule when its script changes, not when a module that the script imports does.
Rules therefore pass a hash of those modules through ``params`` (``workflow.closures``).
"""

from __future__ import annotations

import ast
import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
#: The core and the app: packages whose imports count by default.
PACKAGES = (PACKAGE, PACKAGE.parent / "plan2scene_app")


def _workflow_folder() -> Path:
    """Return the folder of the Snakefile: the clone's root, or a folder of the installed wheel."""
    clone = PACKAGE.parents[1]
    return clone if (clone / "Snakefile").is_file() else PACKAGE / "_workflow"


WORKFLOW = _workflow_folder()  #: Holds Snakefile, workflow/, config/, envs/ and resources/


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


#: :func:`contents_hash` reads a file of at most so many bytes whole, else pieces of so many bytes.
_WHOLE, _PIECE = 200_000, 4096


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


def file_hash(path: str | Path) -> str:
    """Return 16 hex digits of a file's SHA-256 (tables record with it which weights made them)."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


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


def package_versions(*packages: str) -> str:
    """Return ``name version`` of installed packages, separated by commas."""
    return ", ".join(f"{name} {version(name)}" for name in packages)
