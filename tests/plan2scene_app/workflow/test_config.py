import math

import pytest
import yaml
from places import ROOT
from snakemake.utils import update_config

from plan2scene.errors import InputError
from plan2scene_app.run import shipped_config
from plan2scene_app.workflow.config import check_config, config_schema


def merged(name):
    """Return the demo's with the keys of another file in it, one by one as Snakemake does."""
    config = shipped_config()
    update_config(config, yaml.safe_load((ROOT / "config" / name).read_text()))
    return config


@pytest.mark.parametrize("path", sorted((ROOT / "config").glob("*.yaml")), ids=lambda p: p.name)
def test_every_config_file_is_valid(path):
    check_config(merged(path.name))


@pytest.mark.parametrize("section", ["photos", "textures", "dataset", "crops"])
def test_unknown_keys_are_refused(section):
    config = merged("benchmark.yaml")
    config[section]["no_such_key"] = 1
    with pytest.raises(InputError, match="no_such_key"):
        check_config(config)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("methods", ["magic"]),
        ("house", {"method": "magic"}),
        ("study", {"pairs": [["magic", "crop"]]}),
    ],
)
def test_a_method_that_nobody_registered_is_refused_in_one_line(key, value):
    config = shipped_config()
    config[key] = config[key] | value if isinstance(value, dict) else value
    with pytest.raises(InputError, match=rf"{key}.*'magic' is not one of") as error:
        check_config(config)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("key", ["photos.fov_deg", "crops.metres", "photos.camera_height_m"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_finite_number_is_one_line(key, value):
    config = merged("benchmark.yaml")
    section, name = key.split(".")
    config[section][name] = [value] if name == "metres" else value
    with pytest.raises(InputError, match=rf"{key}.*(nan|inf)"):
        check_config(config)


@pytest.mark.parametrize("value", ["data{x}", "a\0b", "a\nb"])
def test_a_path_that_snakemake_could_not_take_is_one_line(value):
    config = merged("benchmark.yaml")
    config["dataset"]["root"] = value
    with pytest.raises(InputError, match=r"dataset\.root: .*braces or control"):
        check_config(config)


def test_aliases_of_aliases_are_refused_at_once():
    bomb: list = ["lol"]
    for _ in range(40):
        bomb = [bomb] * 10
    endless: list = []
    endless.append(endless)
    for value in (bomb, endless, [[]] * 20_000):
        with pytest.raises(InputError, match="at most 10000 values, found more"):
            check_config(merged("benchmark.yaml") | {"methods": value})


def defaults(schema):
    found = {}
    for name, part in schema.get("properties", {}).items():
        value = part["default"] if "default" in part else defaults(part)
        if value != {} or "default" in part:
            found[name] = value
    return found


def test_the_advanced_settings_are_the_defaults_of_the_schema():
    advanced = yaml.safe_load((ROOT / "config" / "advanced.yaml").read_text())
    assert advanced == defaults(config_schema())
