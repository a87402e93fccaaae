"""The config schema's section ``training``, as the settings of the models say.

    python -m plan2scene_workshop.schema

writes it into ``workshop/schemas/config.schema.json``; a test compares the two.
"""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from plan2scene_workshop.features.settings import FeaturesSettings
from plan2scene_workshop.propagation.training import PropagationSettings
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.texture.data import MaterialSettings
from plan2scene_workshop.texture.settings import TextureSettings

SCHEMA = Path(__file__).parents[2] / "schemas" / "config.schema.json"
#: Key of ``training`` -> what its keys set.
SETTINGS: dict[str, type] = {
    "materials": MaterialSettings,
    "texture": TextureSettings,
    "naivesynth": TextureSettings,
    "features": FeaturesSettings,
    "segmentation": SegmentationSettings,
    "propagation": PropagationSettings,
}
_TYPES = {int: "integer", float: "number", bool: "boolean", str: "string", NoneType: "null"}


def training_schema() -> dict[str, Any]:
    """Return the schema of ``training``: every setting may be given, no other key."""
    sections: dict[str, Any] = {name: _section(settings) for name, settings in SETTINGS.items()}
    sections["propagation_houses"] = {"type": "integer", "minimum": 2}
    return {
        "type": "object",
        "additionalProperties": False,
        "required": sorted(sections),
        "properties": sections,
    }


def _section(settings: type) -> dict[str, Any]:
    """Return the schema of the fields of a settings dataclass; numbers are not negative."""
    hints = get_type_hints(settings)
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {field.name: _value(hints[field.name]) for field in fields(settings)},
    }


def _value(hint: Any) -> dict[str, Any]:
    """Return the schema of a value of a type: a simple one, a choice, or one or null."""
    if get_origin(hint) is Literal:
        return {"enum": list(get_args(hint))}
    names = [_TYPES[kind] for kind in get_args(hint) or (hint,)]
    limits = {"minimum": 0} if names[0] in ("integer", "number") else {}
    return {"type": names[0] if len(names) == 1 else names, **limits}


def main() -> None:
    """Write the section into the schema file."""
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    schema["properties"]["training"] = training_schema()
    SCHEMA.write_text(json.dumps(schema, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
