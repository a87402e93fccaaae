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


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        *((f"{name}.odd", 1, "odd") for name in ("photos", "textures", "dataset", "crops")),
        ("methods", ["magic"], r": expected one of crop, .* at methods\[0\], found 'magic'"),
        ("house.method", "magic", r"one of crop, .* at house\.method, found 'magic'"),
        ("study.pairs", [["magic", "crop"]], r"one of .* at study\.pairs\[0\]\[0\], found 'magic'"),
        ("drops", [0.6], r"an entry 0\.0 at drops, found \[0\.6\]"),
        ("photos.camera_height_m", "1,5", r"a number at photos\.camera_.*, found '1,5'"),
        *(
            (key, value, rf"{key.removesuffix('.0')}.*(nan|inf)")
            for key in ("photos.fov_deg", "crops.metres.0", "photos.camera_height_m")
            for value in (math.nan, math.inf, -math.inf)
        ),
        *(("dataset.root", v, r"braces and .* at dataset\.root") for v in ("a{x}", "a\0b", "a\nb")),
    ],
)
def test_a_wrong_setting_is_one_line(key, value, told):
    part = config = merged("benchmark.yaml")
    *sections, name = key.split(".")
    for section in sections:
        part = part[section]
    part[0 if name == "0" else name] = value
    with pytest.raises(InputError, match=told) as error:
        check_config(config)
    assert "\n" not in str(error.value)


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
