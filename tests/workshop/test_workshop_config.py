"""The workshop's configuration files, their schema and their documentation agree."""

import json
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest
import yaml
from snakemake.utils import update_config

from plan2scene_workshop.features.training import FeaturesTraining
from plan2scene_workshop.propagation.training import PropagationSettings
from plan2scene_workshop.segmentation.loop import Settings
from plan2scene_workshop.texture.run import TextureData
from plan2scene_workshop.texture.settings import TextureTraining

WORKSHOP = Path(__file__).parents[2] / "workshop"
SCHEMA = json.loads((WORKSHOP / "schemas" / "config.schema.json").read_text())
TRAINING = SCHEMA["properties"]["training"]["properties"]


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


@pytest.mark.parametrize(
    ("section", "settings"),
    [
        ("texture", TextureTraining),
        ("naivesynth", TextureTraining),
        ("texture_data", TextureData),
        ("features", FeaturesTraining),
        ("segmentation", Settings),
        ("propagation", PropagationSettings),
    ],
)
def test_training_keys_are_the_fields_of_the_settings(section, settings):
    known = {field.name for field in fields(settings)} - (
        {"seed", "cache"} if settings is TextureData else set()
    )
    assert set(TRAINING[section]["propertyNames"]["enum"]) == known


def test_every_key_is_documented():
    text = (WORKSHOP / "README.md").read_text()
    for section, schema in SCHEMA["properties"].items():
        for name in schema.get("properties", {}) or [""]:
            key = f"{section}.{name}" if name else section
            assert f"`{key}" in text, key
