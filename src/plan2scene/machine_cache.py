"""Files that are made once per machine: a folder of the user's, each keyed by what it depends on.

Safe for several processes at once: a file appears whole or not at all, and two that make the same
one make the same bytes. Where the folder cannot be used, work goes on without it.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from plan2scene.io import atomic_path

_LOG = logging.getLogger("plan2scene")
#: Names the folder where it is set; empty: nothing is kept.
VARIABLE = "PLAN2SCENE_CACHE"


def cache_folder() -> Path | None:
    """Return the folder, there or not; None where the user wants none."""
    if VARIABLE in os.environ:
        return Path(os.environ[VARIABLE]) if os.environ[VARIABLE] else None
    if sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "plan2scene"


def made_once(output: str | Path, key: object, make: Callable[[Path], None]) -> None:
    """Write `output`: what `make` wrote for this `key` before, else what it writes now.

    Parameters
    ----------
    output : path
        Written atomically; its suffix is that of the kept file.
    key : JSON value
        All that the bytes depend on: settings, and the hash of the code.
    make : callable
        Writes the file to the path that it is given.
    """
    kept = _kept(Path(output).suffix, key)
    if kept is not None and (whole := _whole(kept)) is not None:
        with atomic_path(output) as temporary:
            temporary.write_bytes(whole)
        _LOG.info("taken from %s", kept)
        return
    make(Path(output))
    if kept is not None:
        _keep(Path(output), kept)


def _kept(suffix: str, key: object) -> Path | None:
    """Return where the file of a key is kept."""
    try:
        folder = cache_folder()
    except RuntimeError:  # no home
        return None
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:24]
    return None if folder is None else folder / f"{name}{suffix}"


def _whole(kept: Path) -> bytes | None:
    """Return a kept file's bytes; None where there is none or it is not as it was written."""
    try:
        data = kept.read_bytes()
        digest = _digest_file(kept).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return None
    return data if hashlib.sha256(data).hexdigest() == digest else None


def _keep(made: Path, kept: Path) -> None:
    """Keep a file with its digest; a folder that takes none is no fault."""
    try:
        digest = hashlib.sha256(made.read_bytes()).hexdigest()
        with atomic_path(kept) as temporary:
            shutil.copyfile(made, temporary)
        with atomic_path(_digest_file(kept)) as temporary:
            temporary.write_text(digest, encoding="ascii")
    except OSError as error:
        _LOG.info("nothing kept in %s: %s", kept.parent, error.strerror)


def _digest_file(kept: Path) -> Path:
    return kept.with_name(f"{kept.name}.sha256")
