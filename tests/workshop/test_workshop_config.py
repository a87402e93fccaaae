"""The workshop's configuration files, their schema and their documentation agree."""

import json
from dataclasses import fields
from pathlib import Path
from types import NoneType
from typing import Literal, get_args, get_origin, get_type_hints

import jsonschema
import pytest
import yaml
from snakemake.utils import update_config

from plan2scene_workshop.features.training import FeaturesSettings
from plan2scene_workshop.plans.settings import PlanSettings
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.texture.data import MaterialSettings
from plan2scene_workshop.texture.settings import TextureSettings

WORKSHOP = Path(__file__).parents[2] / "workshop"
SCHEMA = json.loads((WORKSHOP / "schemas" / "config.schema.json").read_text())

#: Key of ``training`` -> what its keys set.
SETTINGS = {
    "materials": MaterialSettings,
    "texture": TextureSettings,
    "naivesynth": TextureSettings,
    "features": FeaturesSettings,
    "segmentation": SegmentationSettings,
    "plans": PlanSettings,
    "propagation": PropagationSettings,
}
_TYPES = {int: "integer", float: "number", bool: "boolean", str: "string", NoneType: "null"}


def training_schema() -> dict:
    """Return the schema of ``training``: every setting may be given, no other key."""
    sections = {name: section_schema(settings) for name, settings in SETTINGS.items()}
    sections["propagation_houses"] = {"type": "integer", "minimum": 2}
    return {
        "type": "object",
        "additionalProperties": False,
        "required": sorted(sections),
        "properties": sections,
    }


def section_schema(settings) -> dict:
    """Return the schema of the fields of a settings dataclass; numbers are not negative."""
    hints = get_type_hints(settings)
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {field.name: value_schema(hints[field.name]) for field in fields(settings)},
    }


def value_schema(hint) -> dict:
    """Return the schema of a value of a type: a simple one, a choice, or one or null."""
    if get_origin(hint) is Literal:
        return {"enum": list(get_args(hint))}
    names = [_TYPES[kind] for kind in get_args(hint) or (hint,)]
    limits = {"minimum": 0} if names[0] in ("integer", "number") else {}
    return {"type": names[0] if len(names) == 1 else names, **limits}


def merged(name: str) -> dict:
    """Return config.yaml with the keys of another file in it, one by one as Snakemake does."""
    config = yaml.safe_load((WORKSHOP / "config" / "config.yaml").read_text())
    update_config(config, yaml.safe_load((WORKSHOP / "config" / name).read_text()))
    return config


@pytest.mark.parametrize("path", sorted((WORKSHOP / "config").glob("*.yaml")), ids=lambda p: p.name)
def test_every_config_file_is_valid(path):
    jsonschema.validate(merged(path.name), SCHEMA)


@pytest.mark.parametrize("section", ["training", "synthetic"])
def test_unknown_keys_are_refused(section):
    config = merged("config.yaml")
    config[section]["no_such_key"] = 1
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(config, SCHEMA)


def test_training_section_is_that_of_the_settings():
    expected = training_schema()
    found = SCHEMA["properties"]["training"]
    assert found == expected, f"the schema's section training is to be {json.dumps(expected)}"


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("texture", "no_such_key", 1),
        ("features", "steps", "many"),
        ("naivesynth", "statistics", "vgg"),
        ("segmentation", "batch", 0.5),
        ("materials", "folder", 3),
    ],
)
def test_settings_of_a_wrong_name_or_type_are_refused(section, key, value):
    config = merged("config.yaml")
    config["training"][section][key] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(config, SCHEMA)


def test_every_key_is_documented():
    text = (WORKSHOP / "README.md").read_text()
    for section, schema in SCHEMA["properties"].items():
        for name in schema.get("properties", {}) or [""]:
            key = f"{section}.{name}" if name else section
            assert f"`{key}" in text, key
