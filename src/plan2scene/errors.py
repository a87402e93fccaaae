"""Errors that a person can act on."""

from __future__ import annotations


class InputError(ValueError):
    """A fault in what the user gave: one line naming where, what was expected and what was found.

    Parameters
    ----------
    expected, found : str
        Short phrases: ``expected="a photo in photos/"``, ``found="no such file"``.
    file, house, room : str, optional
        Where the fault is; empty parts are left out of the message.

    The phrases stay readable as attributes `expected` and `found`, for a caller that knows more
    about where than the one who raised it.
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


def _one_line(value: object) -> str:
    """Return `value` as text without line breaks or control characters, at most 300 characters."""
    text = "".join(c if c.isprintable() else " " for c in str(value))
    return text if len(text) <= 300 else text[:297] + "..."


class WorkflowError(RuntimeError):
    """The workflow of ``plan2scene run`` failed; its own lines have been printed by then."""
