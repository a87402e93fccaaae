import os
import sys

import pytest
from plan_drawing import refusal

from plan2scene.errors import InputError
from plan2scene.plans.formats import plan_formats, read_plan
from plan2scene.plans.plan_file import PlanFile
from plan2scene.provenance import WORKFLOW
from plan2scene_app.workflow.planning import may_lack_heights


def written(tmp_path, text):
    path = tmp_path / "plan.any"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ('{"format": "plan2scene-plan"}', "plan2scene-plan JSON"),
        ('\n {"arch": {}}', "scene.json"),
        ("[]", "scene.json"),
        ("256 256\n1\n", "raster-to-vector text"),
        (" 1.5 2 3 4 wall", "raster-to-vector text"),
    ],
)
def test_content_tells_the_format(tmp_path, text, name):
    plan = PlanFile(written(tmp_path, text), "h1")
    assert next(entry.name for entry in plan_formats() if entry.sniff(plan)) == name


@pytest.mark.parametrize(
    ("start", "package"), [("0\nSECTION\n", "ezdxf"), ("ISO-10303-21;\n", "ifcopenshell")]
)
def test_a_missing_package_is_one_line(tmp_path, monkeypatch, start, package):
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / f"{package}.py").write_text(f"raise ModuleNotFoundError(name={package!r})")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))  # of a reader in a process of its own
    with pytest.raises(InputError) as caught:
        read_plan(written(tmp_path, start), "h1")
    assert f"-m pip install -e '{WORKFLOW}[formats]')" in str(caught.value)


@pytest.mark.parametrize(
    ("start", "what"),
    [
        (b"\x89PNG\r\n\x1a\n\x00", "a PNG picture (plan2scene trace makes a plan of it)"),
        (b"\xff\xd8\xff\xe0\x00", "a JPEG picture (plan2scene trace makes a plan of it)"),
        (b"%PDF-1.7\n\xff", "a PDF (plan2scene trace makes a plan of it)"),
        (b"AC1032\x00\xff", "a DWG drawing (save it as DXF)"),
        (b"\xd0\xcf\x11\xe0" + b"\x00" * 18, "a binary file"),
        (b"PK\x05\x06" + b"\x00" * 18, "an empty ZIP archive"),
        (b"PK\x03\x04" + b"\x00" * 90, "a damaged file of Sweet Home 3D or another ZIP archive"),
    ],
)
def test_a_picture_is_named_for_what_it_is(tmp_path, start, what):
    path = tmp_path / "plan.any"
    path.write_bytes(start)
    line = refusal(path)
    assert line.startswith(": expected a plan (") and line.endswith(f", found {what}")


def test_a_pipe_is_no_plan(tmp_path):
    path = tmp_path / "plan.json"
    os.mkfifo(path)
    with pytest.raises(InputError, match="expected a file, found no plain file"):
        _ = PlanFile(path, "h1").is_picture
    with pytest.raises(InputError, match="expected a file, found a folder"):
        read_plan(tmp_path, "h1")


@pytest.mark.parametrize(
    ("name", "text", "may"),
    [
        ("p.json", '{"format": "plan2scene-plan"}', True),
        ("p.scene.json", '{"format": "sceneState"}', False),
        ("p.dxf", "0", True),
        ("p.txt", "5 5", False),
    ],
)
def test_a_file_s_name_and_start_say_whether_it_may_lack_heights(tmp_path, name, text, may):
    (tmp_path / name).write_text(text)
    assert may_lack_heights(tmp_path / name) == may
