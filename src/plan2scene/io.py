"""Files: atomic writes, checked reading of text and JSON, Parquet with metadata.

Temporary files lie beside their target. Their names contain the id of the process that writes them,
so that the next writer can remove what a killed process left. Large packages are imported by the
functions that need them: a job without tables never loads pandas.
"""

from __future__ import annotations

import csv
import hashlib
import json
import os
import re
import secrets
import shutil
import socket
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plan2scene.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

#: Temporary files of another machine count as abandoned after this many seconds.
_STALE_AFTER = 7 * 24 * 3600.0
_NAME = re.compile(r"\.tmp_[0-9a-f]{8}_([0-9a-f]{8})_(\d+)_[0-9a-f]{8}(\..*)?")


@cache
def _machine() -> str:
    """Return 8 hex digits that identify this machine, its boot and this process's pid namespace."""
    parts = [socket.gethostname()]
    boot, space = Path("/proc/sys/kernel/random/boot_id"), Path("/proc/self/ns/pid")
    if boot.is_file():
        parts.append(boot.read_text(encoding="ascii"))
    if space.is_symlink():
        parts.append(str(space.readlink()))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:8]


def _start(target: Path) -> str:
    """Return the start of a target's temporary names; it is short even if the target's is long."""
    return f".tmp_{hashlib.sha256(target.name.encode(errors='surrogateescape')).hexdigest()[:8]}_"


def _prepared(path: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Return a path and an unused name beside it; remove what killed writers of the path left."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    _remove_stale(target)
    return target, _temporary_beside(target)


def _temporary_beside(target: Path) -> Path:
    """Return an unused name in the target's folder, with the target's suffix."""
    name = f"{_start(target)}{_machine()}_{os.getpid()}_{secrets.token_hex(4)}"
    suffix = target.suffix if len(target.suffix) <= 20 else ""
    return target.with_name(name + suffix)


def _remove_stale(target: Path) -> None:
    """Remove the temporary files and folders that killed processes left while writing `target`.

    Files of a running process are kept, and files of another machine for `_STALE_AFTER` seconds.
    """
    for path in target.parent.glob(f"{_start(target)}*"):
        match = _NAME.fullmatch(path.name)
        if match and _is_stale(path, match[1], int(match[2])):
            _remove(path)


def _is_stale(path: Path, machine: str, pid: int) -> bool:
    """Return whether a temporary path is abandoned: no process can still be writing it."""
    if machine == _machine():
        try:
            os.kill(pid, 0)
        except (ProcessLookupError, OverflowError):
            return True
        except PermissionError:
            return False
        return False
    try:
        return time.time() - path.lstat().st_mtime > _STALE_AFTER
    except OSError:
        return False


def _remove(path: Path) -> None:
    """Remove a file, link or folder; ignore one that is gone or cannot be removed."""
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
    except OSError:
        return


def _replace_directory(new: Path, target: Path) -> None:
    """Put directory `new` in the place of `target`.

    `target` is always complete or absent. It is absent between two renames. A process that is
    killed there leaves no target and both directories under temporary names; the next write of the
    same target removes them.
    """
    if not os.path.lexists(target):
        new.replace(target)
        return
    old = _temporary_beside(target)
    target.replace(old)
    try:
        new.replace(target)
    except BaseException:
        old.replace(target)
        raise
    _remove(old)


#: Text inputs (plans, tables) above this many bytes are refused before they are read.
MAX_TEXT_BYTES = 256_000_000
#: Most bytes of a file name and of a path in a table; longer names can still be built from them.
MAX_NAME_BYTES, MAX_PATH_BYTES = 240, 1000
#: File endings that :func:`absent` tries if a photo is missing.
_PHOTO_ENDS = (".jpg", ".JPG", ".jpeg", ".JPEG", ".png", ".PNG")
SCHEMA_VERSION = 1  #: Version of every Parquet schema in docs/conventions.md


def _flush(path: Path) -> None:
    """Wait until a file's contents, or a folder's names, are on the disk."""
    if os.name == "nt" and path.is_dir():
        return  # Windows cannot open folders
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def atomic_path(path: str | os.PathLike[str], *, flush: bool = False) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` when the block succeeds.

    Temporary files that killed writers of the same file left are removed first. The file gets the
    mode that the umask gives, whatever mode the block sets. With `flush` the contents and then the
    name are forced to the disk, so that a power cut leaves either the old file or the new one.
    """
    target, temporary = _prepared(path)
    try:
        temporary.touch()
        mode = stat.S_IMODE(temporary.stat().st_mode)
        yield temporary
        temporary.chmod(mode)
        if flush:
            _flush(temporary)
        temporary.replace(target)
        if flush:
            _flush(target.parent)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def atomic_directory(path: str | os.PathLike[str], *, flush: bool = False) -> Iterator[Path]:
    """Yield an empty temporary directory; it replaces directory `path` when the block succeeds.

    The old directory stays until the new one replaces it; for a moment neither exists
    (:func:`_replace_directory`). `flush` forces all its files to the disk (:func:`atomic_path`).
    """
    target, temporary = _prepared(path)
    try:
        temporary.mkdir()
        yield temporary
        for inside in (*temporary.rglob("*"), temporary) if flush else ():
            _flush(inside)
        _replace_directory(temporary, target)
        if flush:
            _flush(target.parent)
    finally:
        _remove(temporary)


def read_text(path: str | os.PathLike[str]) -> str:
    """Return a UTF-8 text file (byte-order mark dropped); InputError when it can't be read."""
    file = Path(path)
    try:
        if file.stat().st_size > MAX_TEXT_BYTES:
            found = f"{file.stat().st_size} bytes"
            raise InputError(f"at most {MAX_TEXT_BYTES} bytes", found, file=file)
        return file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("UTF-8 text", f"another encoding ({error.reason})", file=file) from None
    except OSError as error:
        raise InputError("a readable file", error.strerror or "an error", file=file) from None


def read_csv(path: str | os.PathLike[str]) -> list[list[str]]:
    """Return the rows of a table, their cells without spaces around them; InputError if damaged.

    Commas separate the cells, or what spreadsheets of some countries write: semicolons or tabs.
    """
    lines = read_text(path).splitlines()
    mark = next((mark for mark in ",;\t" if lines and mark in lines[0]), ",")
    try:
        return [[c.strip() for c in row] for row in csv.reader(lines, delimiter=mark, strict=True)]
    except csv.Error as error:
        raise InputError("a CSV table", str(error), file=path) from None


def read_json(path: str | os.PathLike[str]) -> Any:
    """Return a parsed JSON file; InputError names the line of a syntax error."""
    text = read_text(path)
    try:
        return json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError("JSON", f"a syntax error ({error})", file=path) from None


def write_json(path: str | os.PathLike[str], value: Any, *, flush: bool = False) -> None:
    """Write JSON by :func:`write_text`: indented, keys in the given order, a final newline."""
    write_text(path, json.dumps(value, indent=1, allow_nan=False) + "\n", flush=flush)


def write_text(path: str | os.PathLike[str], text: str, *, flush: bool = False) -> None:
    """Write UTF-8 text by :func:`atomic_path`."""
    with atomic_path(path, flush=flush) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_csv(
    path: str | os.PathLike[str], frame: pd.DataFrame, *, float_format: str | None = None
) -> None:
    """Write a table without its index atomically as CSV."""
    write_text(path, frame.to_csv(index=False, lineterminator="\n", float_format=float_format))


def safe_join(
    folder: str | os.PathLike[str], name: str, *, file: object = "", house_id: str = ""
) -> Path:
    """Return folder/name for a name from a table.

    InputError if the path would leave the folder, if the name is too long, or if it has characters
    that some operating system or Snakemake (braces are wildcards in its paths) does not accept.
    """
    bad = (
        not name
        or name != name.strip()
        or any(not c.isprintable() or c in '\\:*?"<>|{}' for c in name)
        or name.startswith("/")
        or any(part in ("", ".", "..") for part in name.split("/"))
    )
    if bad:
        expected = (
            "a plain file name without '..', a leading '/', end spaces or any of \\:*?\"<>|{}"
        )
        raise InputError(expected, repr(name), file=file, house=house_id)
    longest = max(len(os.fsencode(part)) for part in name.split("/"))
    if longest > MAX_NAME_BYTES or len(os.fsencode(name)) > MAX_PATH_BYTES:
        expected = f"a file name of at most {MAX_NAME_BYTES} bytes"
        raise InputError(expected, f"{name[:40]}... of {longest}", file=file, house=house_id)
    return Path(folder) / name


def absent(path: Path) -> str:
    """Describe a missing file; if a file differs from it only in the ending, name that one."""
    ends = dict.fromkeys((path.suffix.lower(), path.suffix.upper(), *_PHOTO_ENDS))
    names = [path.stem + end for end in ends if path.stem + end != path.name]
    near = next((name for name in names if path.with_name(name).is_file()), None)
    return f"no such file, but {near}" if near else "no such file"


def write_parquet(
    path: str | os.PathLike[str], frame: pd.DataFrame, metadata: Mapping[str, object]
) -> None:
    """Write a table atomically as Parquet, with `metadata` and the schema version in its header."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pandas(frame, preserve_index=False)
    extra = {"schema_version": SCHEMA_VERSION, **metadata}
    own = {b"plan2scene": json.dumps(extra, sort_keys=True).encode()}
    table = table.replace_schema_metadata({**(table.schema.metadata or {}), **own})
    with atomic_path(path) as temporary:
        pq.write_table(table, temporary, compression="zstd")


def read_parquet(path: str | os.PathLike[str]) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Return a table and the metadata that :func:`write_parquet` gave it.

    InputError for a damaged file; the message says how to make the file again.
    """
    import pyarrow.parquet as pq

    with _whole(path):
        table = pq.ParquetFile(path).read()
        frame = table.to_pandas()
    return frame, _own_metadata(table.schema.metadata, path)


def read_parquet_metadata(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the metadata that :func:`write_parquet` gave a table, without its rows."""
    import pyarrow.parquet as pq

    with _whole(path):
        metadata = pq.read_schema(path).metadata
    return _own_metadata(metadata, path)


@contextmanager
def _whole(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn pyarrow's errors about a damaged file into an InputError."""
    import pyarrow as pa

    try:
        yield
    except FileNotFoundError:
        raise
    except (pa.ArrowException, OSError, ValueError, KeyError, TypeError) as error:
        what = f"damage ({error}): {how_to_make_anew(path)}"
        raise InputError("a whole Parquet file", what, file=path) from None


def how_to_make_anew(path: str | os.PathLike[str]) -> str:
    """Say in words how to make a damaged file of a stage again.

    If a stage made the file's whole folder (Snakemake's time stamp is in it), remove the folder.
    """
    folder = Path(path).parent
    rm = f"rm -r '{folder}'" if (folder / ".snakemake_timestamp").is_file() else f"rm '{path}'"
    return f"`{rm}` and the same command again make it anew"


def _own_metadata(
    schema_metadata: Mapping[bytes, bytes] | None, path: str | os.PathLike[str]
) -> dict[str, Any]:
    """Return this program's part of a file's metadata; InputError where it has none."""
    raw = (schema_metadata or {}).get(b"plan2scene")
    if raw is None:
        raise InputError("a Parquet file of this program", "no plan2scene metadata", file=path)
    try:
        metadata: dict[str, Any] = json.loads(raw)
        version = metadata.get("schema_version")
    except (ValueError, AttributeError, RecursionError):
        raise InputError("a Parquet file of this program", "other metadata", file=path) from None
    if version != SCHEMA_VERSION:
        raise InputError(f"schema version {SCHEMA_VERSION}", str(version), file=path)
    return metadata
