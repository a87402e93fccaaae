"""JSON files that stages write for other stages: their schemas, and the function that reads them.

A file that is incomplete or was changed by another program is an error of one line, with the
command that makes the file again. So no stage gets a value that it does not expect.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import how_to_make_anew, read_text


def _object(form: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of an object whose values all have one form."""
    return {"type": "object", "additionalProperties": form}


def _list(form: Mapping[str, Any], length: int | None = None) -> dict[str, Any]:
    """Return the form of a list whose values all have one form, with a given length if any."""
    size = {} if length is None else {"minItems": length, "maxItems": length}
    return {"type": "array", "items": form, **size}


def _record(required: Mapping[str, Any], **optional: Mapping[str, Any]) -> dict[str, Any]:
    """Return the form of an object with required and optional keys; other keys are allowed."""
    properties = {**required, **optional}
    return {"type": "object", "required": list(required), "properties": properties}


_TEXT = {"type": "string"}
_NUMBER = {"type": "number", "minimum": -1e6, "maximum": 1e6}
_POSITIVE = {"type": "number", "exclusiveMinimum": 0, "maximum": 1e6}
#: Id of a room of the plan.
_ROOM = {"$ref": "#/$defs/room"}
_SHARE = {"type": "number", "minimum": 0, "maximum": 1}
_SIDE = {"type": "integer", "minimum": 1, "maximum": 100_000}
_CAMERA = _record(
    {
        "width": _SIDE,
        "height": _SIDE,
        "focal_px": _POSITIVE,
        "cx": _NUMBER,
        "cy": _NUMBER,
        "rotation": _list(_list(_NUMBER, 3), 3),
    },
    confidence=_SHARE,
    room_id={"anyOf": [{"type": "null"}, _ROOM]},
    position={"anyOf": [{"type": "null"}, _list(_NUMBER, 3)]},
    located=_SHARE,
    rooms=_object(_SHARE) | {"propertyNames": {"anyOf": [{"const": ""}, _ROOM]}},
)
_TILE = _record(
    {"size_m": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1000}},
    observed={"type": ["boolean", "null"]},
    substance={"type": ["string", "null"]},
    source=_TEXT,
    material=_TEXT,
    crops=_list(_TEXT),
    origin_m=_list(_NUMBER, 2),
    evidence={"type": "object"},
)
_MAP = _record({"origin_m": _list(_NUMBER, 2), "extent_m": _list(_POSITIVE, 2)}, pattern=_TEXT)
_SURFACES = {"propertyNames": {"pattern": "/"}}

#: The form (JSON Schema) of each kind of file; docs/conventions.md explains them.
FORMS: dict[str, dict[str, Any]] = {
    "cameras": _object(_CAMERA),
    "kinds": _record({"source": _TEXT, "photos": _object(_list(_SHARE, 6))}),
    "likeness": _list(
        {
            **_list({}, 3),
            "prefixItems": [_TEXT, _TEXT, {"type": "number", "minimum": -1, "maximum": 1}],
        }
    ),
    "spots": _list({**_list({}, 3), "prefixItems": [_TEXT, _TEXT, {"enum": [0, 1, 2, 3]}]}),
    "warnings": _list(_TEXT),
    "photo_rooms": _object(_list(_ROOM)),
    "light": _record({"gains": _object(_list(_POSITIVE, 3))}),
    "textures": _record({"surfaces": _object(_TILE) | _SURFACES}),
    "maps": _record({"surfaces": _object(_MAP) | _SURFACES}),
    "doors": _object(_list({"type": "integer", "minimum": 0, "maximum": 255}, 3)),
    "trim": _object(_list({"type": "integer", "minimum": 0, "maximum": 255}, 3)),
    "sheet": _record({"photos": _list(_TEXT)}),
}


def read_stage_json(path: str | os.PathLike[str], form: str, *, house: House | None = None) -> Any:
    """Return a stage's JSON file; InputError if it does not have its form (:data:`FORMS`).

    With `house`, the rooms that the file names must be rooms of the house.
    """
    from jsonschema import Draft202012Validator
    from jsonschema.exceptions import best_match

    def refuse(word: str) -> None:
        raise ValueError(f"the number {word}")

    room = {"type": "string"} if house is None else {"enum": [room.id for room in house.rooms]}
    validator = Draft202012Validator(FORMS[form] | {"$defs": {"room": room}})
    try:
        value = json.loads(read_text(path), parse_constant=refuse)
        error = best_match(validator.iter_errors(value))
        fault = error and f"{error.json_path}: {error.message}"
    except InputError as other:
        fault = other.found
    except (ValueError, RecursionError) as other:
        fault = str(other)
    if fault:
        expected = f"{form} as a stage leaves them"
        found = f"damage ({fault[:120]}): {how_to_make_anew(path)}"
        raise InputError(expected, found, file=path, house=house.id if house else "")
    return value
