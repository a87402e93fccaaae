import sys

import pytest
from typer.testing import CliRunner

from plan2scene.errors import InputError
from plan2scene_app.cli import app
from plan2scene_app.exports.registry import RECORD, export_house, exports


def files_of(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize("name", exports())
def test_command_writes_what_the_registry_says_the_same_bytes_again(textured, name):
    if name in ("usd", "ifc"):
        pytest.importorskip({"usd": "pxr", "ifc": "ifcopenshell"}[name])
    run = CliRunner().invoke(app, ["export", str(textured), "--to", name])
    assert run.exit_code == 0, run.output
    written = {p.name + "/" * p.is_dir() for p in (textured / name).iterdir()}
    assert written == {RECORD, *exports()[name].files}
    assert run.output.split() == [
        str(textured / name / f.rstrip("/")) for f in exports()[name].files
    ]
    first = files_of(textured / name)
    assert CliRunner().invoke(app, ["export", str(textured), "--to", name]).exit_code == 0
    assert files_of(textured / name) == first


def test_an_unknown_form_and_a_folder_of_something_else_are_refused(textured):
    with pytest.raises(InputError, match=f"expected one of {', '.join(exports())}, found 'fbx'"):
        export_house(
            textured / "house.scene.json",
            textured / "textures",
            textured / "x",
            "fbx",
            house_id="h",
        )
    assert not (textured / "x").exists()
    result = CliRunner().invoke(app, ["export", str(textured / "textures"), "--to", "map"])
    assert isinstance(result.exception, InputError)
    assert "no house.scene.json" in str(result.exception)


@pytest.mark.parametrize(("name", "module"), [("usd", "pxr"), ("ifc", "ifcopenshell")])
def test_a_missing_package_is_named(textured, monkeypatch, name, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=r"-m pip install -e '/.*\[exports\]'"):
        export_house(
            textured / "house.scene.json", textured / "textures", textured / "x", name, house_id="h"
        )


@pytest.mark.parametrize("name", ["house.obj", "house_textures/mine.png", "house_textures/a/b"])
def test_files_that_no_export_wrote_are_kept(textured, name):
    mine = textured / "x" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    arguments = ["export", str(textured), "--to", "obj", "--out", str(textured / "x")]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    expected = f"expected an --out folder without files of yours, found {mine.name}"
    assert expected in str(result.exception)
    assert [p for p in (textured / "x").rglob("*") if p.is_file()] == [mine]
    assert mine.read_text() == "mine"


def test_an_export_replaces_its_own_files_alone(textured):
    arguments = ["export", str(textured), "--to", "obj", "--out", str(textured / "x")]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    (textured / "x" / "house_textures" / "mine.png").write_text("mine")
    assert isinstance(CliRunner().invoke(app, arguments).exception, InputError)
    pytest.importorskip("pxr")
    arguments = ["export", str(textured), "--to", "usd", "--out", str(textured)]
    assert isinstance(CliRunner().invoke(app, arguments).exception, InputError)
    assert (textured / "textures" / "textures.json").is_file()
