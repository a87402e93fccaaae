import json
import re

import pytest
from foreign import LEFT, house

from plan2scene.errors import InputError
from plan2scene.stage_json import FORMS, read_stage_json


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("other", [7, None, "x", [[7]], {"a": 7}, {"surfaces": {"a": {}}}])
def test_other_shapes_are_named_with_what_makes_the_file_anew(form, other, tmp_path):
    path = tmp_path / f"{form}.json"
    path.write_text(json.dumps(LEFT[form]))
    assert read_stage_json(path, form, house=house()) == LEFT[form]
    path.write_text(json.dumps(other))
    line = rf"file {path}: expected {form} as a stage leaves them, found damage \(\$.*`rm '{path}'`"
    with pytest.raises(InputError, match=line):
        read_stage_json(path, form)


@pytest.mark.parametrize(
    ("form", "text", "found"),
    [
        ("light", '{"gains": {"a": [1, 1, NaN]}}', "the number NaN"),
        ("light", '{"gains": {"a": [1, 1, 1e999]}}', r"\$.gains.a\[2\]: inf is greater"),
        ("photo_rooms", '{"a": ["attic"]}', r"\$.a\[0\]: 'attic' is not one of \['living'"),
        ("cameras", json.dumps({"a": LEFT["cameras"]["a.jpg"] | {"room_id": "attic"}}), "attic"),
        ("textures", json.dumps(LEFT["textures"]).replace("2.0", "0"), r"size_m: 0 is less"),
        ("spots", '[["a", "b"', "Expecting"),
    ],
)
def test_wrong_values_and_half_files(form, text, found, tmp_path):
    (tmp_path / "x.json").write_text(text)
    (tmp_path / ".snakemake_timestamp").touch()
    line = rf"house h1: .*{found}.*{re.escape(f'`rm -r {str(tmp_path)!r}`')} and the same command"
    with pytest.raises(InputError, match=line):
        read_stage_json(tmp_path / "x.json", form, house=house())
