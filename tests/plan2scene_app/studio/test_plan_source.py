import json
import math
import os
import time

import numpy as np
import pytest
from unscaled_drawings import dxf, svg

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene_app.studio import limited as limits
from plan2scene_app.studio.plan_source import UnreadPlanError, read_again, read_upload, reading_of


def asked(project, content):
    with pytest.raises(UnreadPlanError) as found:
        read_upload(project, content)
    return str(found.value), found.value.reading


def size(plan):
    return np.ptp(np.concatenate([room["polygon"] for room in plan["rooms"]]), axis=0)


def test_a_drawing_without_a_unit_is_read_with_scale_and_layers(project):
    pytest.importorskip("ezdxf")
    line, reading = asked(project, dxf())
    assert "$INSUNITS" in line and reading["unit"] == "unit"
    assert reading["size"] is None  # none of the layers is of walls
    told = {(n["name"], n["count"], n["kind"]) for n in reading["names"]}
    assert told == {("W1", 5, ""), ("F.frame (1)", 1, "")}
    found = read_again(project, {"width": 8, "dxf_layers": {"walls": "W1", "doors": ""}})
    assert size(found["plan"]) == pytest.approx([8, 4], abs=0.2)
    assert len(found["plan"]["rooms"]) == 2
    kept = json.loads((project.path / "plan_source.json").read_text())
    assert kept["metres_per_pixel"] == pytest.approx(0.001)
    assert kept["dxf_layers"] == {"walls": "W1"}
    values = (kept["metres_per_pixel"], kept["dxf_layers"])
    assert len(read_plan(project.path / "plan_source", "home", *values).rooms) == 2
    again = reading_of(project)
    assert again["size"] == pytest.approx((8000, 4000))
    assert {n["name"]: n["kind"] for n in again["names"]}["W1"] == "walls"


def test_a_width_stands_for_the_scale_of_an_svg(project):
    line, reading = asked(project, svg())
    assert line.startswith("expected metres_per_pixel up to 1")
    assert (reading["unit"], reading["size"], reading["names"]) == ("pixel", (800, 400), [])
    assert size(read_again(project, {"width": 10.0})["plan"]) == pytest.approx([10, 5], rel=0.03)
    assert reading_of(project)["metres_per_pixel"] == pytest.approx(10 / 800)
    # A plan with another scale is read by that one, not by what was given for the last.
    asked(project, svg())
    assert reading_of(project)["metres_per_pixel"] is None


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        *(
            ({"metres_per_pixel": value}, "metres of a pixel")
            for value in (0, -0.01, True, float("inf"), float("nan"), 10**400)
        ),
        ({"metres_per_pixel": "0.01"}, "found '0.01'"),
        ({"metres_per_pixel": 0.0001}, "1 to 500 m long, found 0.08 m"),
        ({"metres_per_pixel": 0.9}, "1 to 500 m long, found 720 m"),
        ({"width": 1e6}, "a width of the house in metres"),
        ({"metres_per_pixel": 0.01, "width": 8}, "found both"),
        *(({"dxf_layers": layers}, "patterns of rooms") for layers in (["walls"], {"roofs": "R"})),
        *(({"dxf_layers": {"walls": w}}, "a pattern of at most") for w in (3, "x" * 301)),
    ],
)
def test_values_are_checked_before_anything_is_kept(project, given, expected):
    asked(project, svg())
    before = (project.path / "plan_source.json").read_bytes()
    with pytest.raises(InputError) as found:
        read_again(project, given)
    assert expected in str(found.value)
    assert (project.path / "plan_source.json").read_bytes() == before


@pytest.mark.parametrize(
    "broken",
    [
        "[]",
        "{",
        '{"dxf_layers": ["W"]}',
        '{"metres_per_pixel": "wide"}',
        '{"picture": 3}',
        '{"picture": {"size": [1, "x"]}}',
        '{"picture": {"size": null, "shown": 0}}',
        '{"two_points": -1}',
    ],
)
def test_values_that_others_broke_are_one_line_until_the_next_upload(project, broken):
    asked(project, svg())
    (project.path / "plan_source.json").write_text(broken)
    for ask in (reading_of, lambda p: read_again(p, {"width": 10})):
        with pytest.raises(InputError, match=r"plan_source\.json: expected"):
            ask(project)
    asked(project, svg())
    assert reading_of(project)["size"] == (800, 400)


@pytest.mark.parametrize("content", [b"no plan at all", b"\0\0\0 ftypmp42 a video"])
def test_what_is_no_plan_is_not_kept(project, content):
    asked(project, svg())
    with pytest.raises(InputError) as found:
        read_upload(project, content)
    assert not isinstance(found.value, UnreadPlanError)
    assert (project.path / "plan_source").read_bytes() == svg()


@pytest.mark.parametrize(
    ("function", "arguments", "found"),
    [
        (math.sqrt, (4.0,), 2.0),
        (time.sleep, (60.0,), "within 1 s, found one that takes longer"),
        (np.ones, (250_000_000,), "with 1 GB of memory, found one that takes more"),
        (os.abort, (), "crashes"),
    ],
)
def test_a_file_is_read_within_limits(monkeypatch, function, arguments, found):
    monkeypatch.setattr(limits, "SECONDS", 1.0 if function is time.sleep else 5.0)
    monkeypatch.setattr(limits, "BYTES", 1_000_000_000)
    if isinstance(found, float):
        assert limits.limited(function, *arguments) == found
        return
    with pytest.raises(InputError, match=found):
        limits.limited(function, *arguments)
