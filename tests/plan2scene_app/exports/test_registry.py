import json
import sys

import pytest
from typer.testing import CliRunner

from plan2scene.errors import InputError
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.cli import app
from plan2scene_app.exports.registry import RECORD, export_house, exports


@pytest.fixture
def made(gap_house, paint, tmp_path):
    write_scene_json(gap_house, tmp_path / "house.scene.json")
    (tmp_path / "textures").mkdir()
    entries = {}
    for key, tile in paint(gap_house).items():
        (tmp_path / "textures" / f"{key.filename}.png").write_bytes(tile.png)
        entries["/".join(key)] = {"size_m": tile.size_m}
    (tmp_path / "textures" / "textures.json").write_text(json.dumps({"surfaces": entries}))
    return tmp_path


def files_of(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize("name", exports())
def test_command_writes_what_the_registry_says_the_same_bytes_again(made, name):
    if name in ("usd", "ifc"):
        pytest.importorskip({"usd": "pxr", "ifc": "ifcopenshell"}[name])
    run = CliRunner().invoke(app, ["export", str(made), "--to", name])
    assert run.exit_code == 0, run.output
    written = {p.name + "/" * p.is_dir() for p in (made / name).iterdir()}
    assert written == {RECORD, *exports()[name].files}
    assert run.output.split() == [str(made / name / f.rstrip("/")) for f in exports()[name].files]
    first = files_of(made / name)
    assert CliRunner().invoke(app, ["export", str(made), "--to", name]).exit_code == 0
    assert files_of(made / name) == first


def test_an_unknown_form_and_a_folder_of_something_else_are_refused(made):
    with pytest.raises(InputError, match=f"expected one of {', '.join(exports())}, found 'fbx'"):
        export_house(made / "house.scene.json", made / "textures", made / "x", "fbx", house_id="h")
    assert not (made / "x").exists()
    result = CliRunner().invoke(app, ["export", str(made / "textures"), "--to", "map"])
    assert isinstance(result.exception, InputError)
    assert "no house.scene.json" in str(result.exception)


@pytest.mark.parametrize(("name", "module"), [("usd", "pxr"), ("ifc", "ifcopenshell")])
def test_a_missing_package_is_named(made, monkeypatch, name, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r"-m pip install -e '/.*\[exports\]'"):
        export_house(made / "house.scene.json", made / "textures", made / "x", name, house_id="h")


@pytest.mark.parametrize("name", ["house.obj", "house_textures/mine.png", "house_textures/a/b"])
def test_files_that_no_export_wrote_are_kept(made, name):
    mine = made / "x" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    arguments = ["export", str(made), "--to", "obj", "--out", str(made / "x")]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    expected = f"expected an --out folder without files of others, found {mine.name}"
    assert expected in str(result.exception)
    assert [p for p in (made / "x").rglob("*") if p.is_file()] == [mine]
    assert mine.read_text() == "mine"


def test_an_export_replaces_its_own_files_alone(made):
    arguments = ["export", str(made), "--to", "obj", "--out", str(made / "x")]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    (made / "x" / "house_textures" / "mine.png").write_text("mine")
    assert isinstance(CliRunner().invoke(app, arguments).exception, InputError)
    pytest.importorskip("pxr")
    arguments = ["export", str(made), "--to", "usd", "--out", str(made)]
    assert isinstance(CliRunner().invoke(app, arguments).exception, InputError)
    assert (made / "textures" / "textures.json").is_file()
