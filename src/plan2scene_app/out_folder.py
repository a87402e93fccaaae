"""The output folder of ``plan2scene run``: one run at a time, and no user's file is overwritten."""

from __future__ import annotations

import errno
import filecmp
import hashlib
import logging
import os
import shutil
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.io import atomic_directory, atomic_path, read_json, write_json

_LOG = logging.getLogger("plan2scene")
#: Folder below the results where the workflow runs.
WORK = "work"
#: Folder in the work folder with the data set of this house: copies of what the user gave.
DATASET_FOLDER = "dataset"
#: File in the work folder that lists what runs delivered; all other files are the user's.
_RECORD = "delivered.json"
#: Lock file in the work folder, held during a run; the system frees it when the run has ended.
_LOCK = "lock"
#: Seconds to wait until the remaining processes of a killed run have ended.
_PATIENCE = 15.0
#: Names of files that Snakemake leaves in the folders it makes.
_BYPRODUCTS = (".snakemake_timestamp", ".tmp_*")


@dataclass(frozen=True)
class OutFolder:
    """An output folder that is locked for this run.

    `lock` is the file descriptor of the lock, -1 on a system without locks. A child process that
    inherits it keeps the folder locked as long as it lives.
    """

    path: Path
    lock: int

    @property
    def work(self) -> Path:
        """Where the workflow runs."""
        return self.path / WORK

    def deliver(self, files: Mapping[str, Path]) -> dict[str, Path]:
        """Copy files and folders to these names, each atomically; return their paths.

        A file that is already there with the same content is not written, so its time stays. One
        that the user changed since it was delivered stays, with a warning.
        """
        targets = {name: self.path / name for name in files}
        edited = [name for name in files if changed_by_hand(self.path, name)]
        names = set(_delivered(self.work)) | set(files)
        digests = _digests(self.work)
        for name, source in files.items():
            if source.is_dir():
                names |= {f"{name}/{path.name}" for path in source.iterdir()}
            elif name not in edited:
                # With the one before: if the copy fails, that file is still there.
                digests[name] = [*digests.get(name, [])[-1:], _digest(source)]
        record = {"files": sorted(names), "digests": dict(sorted(digests.items()))}
        write_json(self.work / _RECORD, record, flush=True)
        for name, source in files.items():
            if name in edited:
                _LOG.warning("%s was changed since the last run: it stays", targets[name])
                continue
            if source.is_dir():
                ignored = shutil.ignore_patterns(*_BYPRODUCTS)
                with atomic_directory(targets[name], flush=True) as folder:
                    shutil.copytree(source, folder, ignore=ignored, dirs_exist_ok=True)
            elif not targets[name].is_file() or not filecmp.cmp(
                source, targets[name], shallow=False
            ):
                with atomic_path(targets[name], flush=True) as temporary:
                    shutil.copyfile(source, temporary)
        return targets


def is_out_folder(path: Path) -> bool:
    """Return whether a folder is the output folder of a run."""
    return (path / WORK / _LOCK).is_file()


def changed_by_hand(path: Path, name: str) -> bool:
    """Return whether a file of an output folder is no longer what the last run delivered."""
    digests = _digests(path / WORK).get(name)
    file = path / name
    return digests is not None and file.is_file() and _digest(file) not in digests


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _digests(work: Path) -> dict[str, list[str]]:
    """Return SHA-256 of what the last two runs delivered, by the file's name."""
    record = work / _RECORD
    content = read_json(record) if record.is_file() else {}
    digests = content.get("digests") if isinstance(content, dict) else None
    return dict(digests) if isinstance(digests, dict) else {}


@contextmanager
def claimed_folder(path: Path, names: Sequence[str], inputs: Sequence[Path]) -> Iterator[OutFolder]:
    """Yield the output folder, locked until the block ends; make it if it does not exist.

    If a killed run left Snakemake's own lock in the work folder, it is removed. This is safe
    because no other run can use the folder while this lock is held.

    Parameters
    ----------
    path : path
        The output folder.
    names : sequence of str
        Names of the files and folders that will be delivered.
    inputs : sequence of path
        Files and folders that the run reads.

    Raises
    ------
    InputError
        If `path` is a file or an input, another run works in it, or a file at one of the names is
        an input or was not delivered by an earlier run.
    """
    if path.exists() and not path.is_dir():
        raise InputError("a folder for the results", "a file", file=path)
    _refuse_users_files(path, names, inputs)
    work = path / WORK
    work.mkdir(parents=True, exist_ok=True)
    with _locked(work / _LOCK, path) as lock:
        _refuse_users_files(path, names, inputs)
        if not (work / _RECORD).is_file():
            write_json(work / _RECORD, {"files": []})
        shutil.rmtree(work / ".snakemake" / "locks", ignore_errors=True)
        yield OutFolder(path, lock)


def _delivered(work: Path) -> list[str]:
    """Return the names of the files that earlier runs delivered."""
    record = work / _RECORD
    content = read_json(record) if record.is_file() else {}
    names = content.get("files") if isinstance(content, dict) else None
    if not isinstance(names, list):
        raise InputError("the record of an earlier run", "another file", file=record)
    return [str(name) for name in names]


def _refuse_users_files(path: Path, names: Sequence[str], inputs: Sequence[Path]) -> None:
    """Raise InputError if a delivery would overwrite a file that no earlier run delivered."""
    work = path / WORK
    if os.path.lexists(work) and not (work / _LOCK).is_file() and (work.is_file() or _full(work)):
        raise InputError("a folder 'work' of an earlier run, or none", "another one", file=work)
    targets = [path / name for name in (*names, WORK)]
    for source in inputs:
        real = source.resolve()
        for target in targets:
            if real in (path.resolve(), target.resolve()) or target.resolve() in real.parents:
                raise InputError("an --out folder that doesn't overwrite the input", str(source))
    delivered = set(_delivered(work)) if (work / _RECORD).is_file() else set()
    for name in names:
        target = path / name
        present = [name] if os.path.lexists(target) else []
        if target.is_dir() and not target.is_symlink():
            present += [f"{name}/{entry.name}" for entry in target.iterdir()]
        foreign = sorted(set(present) - delivered)
        if foreign:
            raise InputError("an --out folder without files of yours", foreign[-1], file=path)


def _full(folder: Path) -> bool:
    return any(folder.iterdir())


def _own_name() -> bytes:
    return f"{socket.gethostname()} {os.getpid()}\n".encode()


def _holder_is_gone(handle: int) -> bool:
    """Return whether the process named in a lock file ran on this machine and has ended."""
    host, _, number = os.pread(handle, 300, 0).decode(errors="replace").rpartition(" ")
    if host != socket.gethostname() or not number.strip().isdecimal():
        return False
    try:
        os.kill(int(number), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        return False
    return False


def _wait_for(lock: Callable[[], None], handle: int, path: Path) -> None:
    """Lock an open file; InputError if another run holds it.

    If the named holder has ended, wait up to `_PATIENCE` for the processes that it left.
    """
    deadline = time.monotonic() + _PATIENCE
    told = False
    while True:
        try:
            lock()
        except BlockingIOError:
            if time.monotonic() > deadline or not _holder_is_gone(handle):
                expected = "an --out folder in which no other run works"
                raise InputError(expected, "a run that is under way", file=path) from None
            if not told:
                _LOG.warning("%s: waiting until the processes of a killed run have ended", path)
            told = True
            time.sleep(0.1)
        else:
            return


@contextmanager
def _locked(file: Path, path: Path) -> Iterator[int]:
    """Hold a lock file while the block runs; InputError if another process holds it.

    The process writes its host and number into the file.

    The package `filelock` is not used: its release also unlocks the file for the children that
    inherited the lock. The folder must stay locked until Snakemake has ended, even if this process
    was killed.
    """
    try:
        import fcntl
    except ImportError:  # not on Windows
        yield -1
        return
    handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            _wait_for(partial(fcntl.flock, handle, fcntl.LOCK_EX | fcntl.LOCK_NB), handle, path)
        except OSError as error:
            if error.errno not in (errno.ENOLCK, errno.ENOTSUP):
                raise
            _LOG.warning("%s has no locks: start one run at a time into it", path)
        os.ftruncate(handle, 0)
        os.pwrite(handle, _own_name(), 0)
        yield handle
    finally:
        os.close(handle)
