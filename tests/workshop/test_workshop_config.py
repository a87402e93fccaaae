import json
from pathlib import Path

import jsonschema
import pytest
import yaml
from snakemake.utils import update_config

WORKSHOP = Path(__file__).parents[2] / "workshop"
SCHEMA = json.loads((WORKSHOP / "schemas" / "config.schema.json").read_text())


def merged(name):
    config = yaml.safe_load((WORKSHOP / "config" / "config.yaml").read_text())
    update_config(config, yaml.safe_load((WORKSHOP / "config" / name).read_text()))
    return config


@pytest.mark.parametrize("path", sorted((WORKSHOP / "config").glob("*.yaml")), ids=lambda p: p.name)
def test_every_config_file_is_valid(path):
    jsonschema.validate(merged(path.name), SCHEMA)
