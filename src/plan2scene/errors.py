"""Errors that a person can act on."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

#: System errors that are not the program's fault, and what the user has to provide.
_SYSTEM = {
    errno.ENOSPC: "free space on the disk",
    errno.EDQUOT: "room within the disk quota",
    errno.EFBIG: "a disk that takes files of this size",
    errno.EROFS: "a place that may be written to",
    errno.EACCES: "permission to read and write",
    errno.EPERM: "permission to read and write",
    errno.EIO: "a disk that works",
    errno.ENOTDIR: "a folder",
    errno.EEXIST: "a folder",
    errno.EISDIR: "a file",
    errno.ENAMETOOLONG: "a shorter name",
    errno.ELOOP: "a path without a circle of links",
    errno.EMFILE: "a higher limit of open files",
    errno.ENFILE: "a higher limit of open files",
    errno.ENOMEM: "free memory",
}
#: What keywords and types of JSON schemas demand of a value.
_DEMANDS = {
    "contains": "an entry {0[const]}",
    "exclusiveMaximum": "less than {}",
    "exclusiveMinimum": "more than {}",
    "maxItems": "at most {} entries",
    "maxLength": "at most {} characters",
    "maximum": "at most {}",
    "minItems": "at least {} entries",
    "minLength": "at least {} characters",
    "minimum": "at least {}",
    "pattern": "only letters, digits, '_', '-' and '.'",
    "uniqueItems": "each entry once",
}
_TYPES = {"array": "a list", "integer": "a whole number", "object": "keys with values"}


class InputError(ValueError):
    """A fault in the user's input: one line says where, what was expected and what was found.

    `expected` and `found` are short phrases ("a photo in photos/", "no such file"). They are also
    attributes, so that a caller that knows the place better can raise the error again. `file`,
    `house` and `room` say where; empty ones are left out of the message.
    """

    def __init__(
        self, expected: str, found: str, *, file: object = "", house: str = "", room: str = ""
    ) -> None:
        self.expected, self.found = expected, found
        where = [
            f"{name} {_one_line(value)}"
            for name, value in (("file", file), ("house", house), ("room", room))
            if str(value)
        ]
        head = ", ".join(where) + ": " if where else ""
        super().__init__(f"{head}expected {_one_line(expected)}, found {_one_line(found)}")

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle the finished message: a worker's error is sent to its parent process."""
        return _as_raised, (type(self), str(self), self.expected, self.found)


def _as_raised(kind: type[InputError], message: str, expected: str, found: str) -> InputError:
    """Rebuild an error from its message and parts, for pickle."""
    error = kind.__new__(kind, message)
    error.expected, error.found = expected, found
    return error


def _one_line(value: object) -> str:
    """Return `value` as text without line breaks or control characters, at most 300 characters."""
    text = "".join(c if c.isprintable() else " " for c in str(value))
    return text if len(text) <= 300 else text[:297] + "..."


def schema_fault(error: Any) -> tuple[str, str]:
    """Return what was expected and what was found, of a ``jsonschema.ValidationError``."""
    place, demand = error.json_path.lstrip("$."), error.validator_value
    found = "nothing" if error.instance is None else repr(error.instance)
    match error.validator:
        case "enum":
            expected = f"one of {', '.join(map(str, demand))}"
        case "required":
            missing = [key for key in demand if key not in error.instance]
            expected, found = f"key {missing[0]!r}", "none"
        case "additionalProperties":
            allowed = list(error.schema["properties"])
            extra = [key for key in error.instance if key not in allowed]
            expected, found = f"only the keys {', '.join(allowed)}", repr(extra[0])
        case "type":
            name = demand if isinstance(demand, str) else demand[0]  # or null
            expected = _TYPES.get(name, f"a {name}")
        case word:
            expected = _DEMANDS.get(word, "{!r}").format(demand)
    return f"{expected} at {place}" if place else expected, found


def system_fault(error: OSError) -> InputError | None:
    """Return a system error as an InputError; None if the program itself is at fault."""
    expected = _SYSTEM.get(error.errno or 0)
    if expected is None:
        return None
    name = error.filename if isinstance(error.filename, str | Path) else ""
    path = Path(name).parent if Path(name).name.startswith(".tmp_") else name
    return InputError(expected, error.strerror or "an error", file=path)


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn a full disk, a missing permission and the like into an InputError."""
    try:
        yield
    except OSError as error:
        fault = system_fault(error)
        if fault is None:
            raise
        raise fault from None


class WorkflowError(RuntimeError):
    """The workflow of ``plan2scene run`` failed; its own messages are already printed."""
