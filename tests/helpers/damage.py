"""Damage to parsed JSON: what replaces a value, and where the values are."""

from __future__ import annotations

from typing import Any

#: What a stranger's file may hold in the place of anything.
VALUES = [None, True, 0, -1, 1e308, 5, 10**400, "x", "", [], {}, [1], [[1]], {"a": 1}]


def places(value: Any) -> list[tuple[Any, Any]]:
    """Return (container, key) of everything inside a JSON value."""
    keys = value if isinstance(value, dict) else range(len(value))
    found = []
    for key in keys:
        found.append((value, key))
        if isinstance(value[key], dict | list):
            found += places(value[key])
    return found
