"""Where the workflow's files are, and what tables record: hashes of weights, package versions."""

from __future__ import annotations

import hashlib
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def _workflow_folder() -> Path:
    """Return the folder of the Snakefile: the clone's root, or a folder of the installed wheel."""
    clone = PACKAGE.parents[1]
    return clone if (clone / "Snakefile").is_file() else PACKAGE / "_workflow"


WORKFLOW = _workflow_folder()  #: Holds Snakefile, workflow/, config/, envs/ and resources/


def file_hash(path: str | Path) -> str:
    """Return 16 hex digits of a file's SHA-256 (tables record with it which weights made them)."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def package_versions(*packages: str) -> str:
    """Return ``name version`` of installed packages, separated by commas."""
    return ", ".join(f"{name} {version(name)}" for name in packages)
