"""Temporary names beside a target: whose they are, so that what a killed process left can go."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import socket
import time
from functools import cache
from pathlib import Path

#: What another machine left is taken for stale after this many seconds.
STALE_AFTER = 7 * 24 * 3600.0
_NAME = re.compile(r"\.tmp_[0-9a-f]{8}_([0-9a-f]{8})_(\d+)_[0-9a-f]{8}(\..*)?")


@cache
def _machine() -> str:
    """Return 8 hex digits that name this machine, its start and this process's pid namespace."""
    parts = [socket.gethostname()]
    boot, space = Path("/proc/sys/kernel/random/boot_id"), Path("/proc/self/ns/pid")
    if boot.is_file():
        parts.append(boot.read_text(encoding="ascii"))
    if space.is_symlink():
        parts.append(str(space.readlink()))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:8]


def _start(target: Path) -> str:
    """Return how the temporary names of a target begin; short, however long its own name is."""
    return f".tmp_{hashlib.sha256(target.name.encode(errors='surrogateescape')).hexdigest()[:8]}_"


def temporary_beside(target: Path) -> Path:
    """Return a name that nothing has, in the target's folder and with its suffix."""
    name = f"{_start(target)}{_machine()}_{os.getpid()}_{secrets.token_hex(4)}"
    suffix = target.suffix if len(target.suffix) <= 20 else ""
    return target.with_name(name + suffix)


def remove_stale(target: Path) -> None:
    """Remove the temporary files and folders that killed processes left while writing `target`.

    Those of a process that lives are kept, as are those of other machines for `STALE_AFTER`.
    """
    for path in target.parent.glob(f"{_start(target)}*"):
        match = _NAME.fullmatch(path.name)
        if match and _is_stale(path, match[1], int(match[2])):
            remove(path)


def _is_stale(path: Path, machine: str, pid: int) -> bool:
    """Return whether no process can be writing a temporary path any more."""
    if machine == _machine():
        try:
            os.kill(pid, 0)
        except (ProcessLookupError, OverflowError):
            return True
        except PermissionError:
            return False
        return False
    try:
        return time.time() - path.lstat().st_mtime > STALE_AFTER
    except OSError:
        return False


def remove(path: Path) -> None:
    """Remove a file, link or folder; one that is gone already, or cannot go, is left."""
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    except OSError:
        return


def replace_directory(new: Path, target: Path) -> None:
    """Put directory `new` in the place of `target`.

    `target` is always whole or absent. It is absent between two renames: a process that is killed
    there leaves no target, and both directories under temporary names, which the next write of
    the same target removes.
    """
    if not os.path.lexists(target):
        new.replace(target)
        return
    old = temporary_beside(target)
    target.replace(old)
    try:
        new.replace(target)
    except BaseException:
        old.replace(target)
        raise
    remove(old)
