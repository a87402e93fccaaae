"""The registry of plan formats: told apart by content, and a new one is one entry."""

import sys
from pathlib import Path

import pytest

from plan2scene.errors import InputError
from plan2scene.house import House, Room
from plan2scene.plans import formats
from plan2scene.plans.formats import plan_formats, read_plan
from plan2scene.plans.plan_file import PlanFile, PlanFormat

DOCS = Path(__file__).parents[3] / "docs" / "floorplans.md"


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


def test_the_message_of_another_file_names_every_format(tmp_path):
    path = written(tmp_path, "what is this")
    with pytest.raises(InputError) as caught:
        read_plan(path, "h1")
    names = ", ".join(entry.name for entry in plan_formats())
    assert str(caught.value) == (
        f"file {path}, house h1: expected a plan ({names}), found 'what' at its start"
    )


def test_docs_list_every_format():
    table = DOCS.read_text()
    assert all(f"| {entry.name} |" in table for entry in plan_formats())


def test_a_new_format_is_one_entry(tmp_path, monkeypatch):
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))

    def read(plan):
        side = float(plan.text.split()[1]) * plan.metres_per_pixel
        outline = tuple((x * side, z * side) for x, z in ring)
        return House(plan.house_id, (Room("a", ("Unknown",), (outline,), 2.5),), ())

    square = PlanFormat(
        "square", lambda plan: plan.text.startswith("square"), read, needs_scale=True
    )
    all_formats = plan_formats()
    monkeypatch.setattr(formats, "plan_formats", lambda: (square, *all_formats))
    path = written(tmp_path, "square 10")
    assert read_plan(path, "h1", 0.1).rooms[0].rings[0] == ring
    with pytest.raises(InputError, match="metres_per_pixel above 0 and up to 1 for square"):
        read_plan(path, "h1")


@pytest.mark.parametrize(
    ("start", "package"),
    [("0\nSECTION\n", "ezdxf"), ("ISO-10303-21;\n", "ifcopenshell")],
)
def test_a_missing_package_is_one_line(tmp_path, monkeypatch, start, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError) as caught:
        read_plan(written(tmp_path, start), "h1")
    assert f"expected {package} (pip install 'plan2scene[formats]')" in str(caught.value)


@pytest.mark.parametrize(
    ("start", "what"),
    [
        (b"\x89PNG\r\n\x1a\n\x00", "a PNG picture (plan2scene trace makes a plan of it)"),
        (b"\xff\xd8\xff\xe0\x00", "a JPEG picture (plan2scene trace makes a plan of it)"),
        (b"%PDF-1.7\n\xff", "a PDF"),
        (b"AC1032\x00\xff", "a DWG drawing (save it as DXF)"),
        (b"PK\x05\x06" + b"\x00" * 18, "an empty ZIP archive"),
    ],
)
def test_a_picture_is_named_for_what_it_is(tmp_path, start, what):
    path = tmp_path / "plan.any"
    path.write_bytes(start)
    with pytest.raises(InputError) as caught:
        read_plan(path, "h1")
    assert str(caught.value).startswith(f"file {path}, house h1: expected a plan (")
    assert str(caught.value).endswith(f", found {what}")
