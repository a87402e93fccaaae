import base64
import hashlib
import io
import json
import re

import cv2
import numpy as np
import pytest
from PIL import Image
from places import PLAN
from shapely.geometry import Polygon

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.editor.editor_page import opened, picture_bytes, write_editor
from plan2scene_app.tracing.picture import Frame
from plan2scene_app.tracing.rooms import TracedRoom
from plan2scene_app.tracing.scale import Scale
from plan2scene_app.tracing.trace import TracedPlan

NAME = '</script><script>alert(1)</script>"&'


def block(page, name):
    text = re.search(
        rf'<script type="application/json" id="{name}">(.*?)</script>', page, re.DOTALL
    )
    return json.loads(text[1])


def test_the_policy_allows_the_page_itself_and_nothing_else(tmp_path):
    path = tmp_path / "editor.html"
    write_editor(None, path, house_id=NAME)
    page = path.read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'" and rules["img-src"] == "data: blob:"
    for tag, source in (("style", "style-src"), ('script type="module"', "script-src")):
        raw = re.search(rf"<{tag}>(.*?)</{tag.split()[0]}>", page, re.S)[1]
        digest = base64.b64encode(hashlib.sha256(raw.encode()).digest()).decode()
        assert rules[source] == f"'sha256-{digest}'"
    assert not re.search(r"(src|href)=\"?https?:|@import|\bfetch\(|XMLHttpRequest|WebSocket", page)
    assert "<script>alert" not in page and block(page, "start")["house"] == NAME


def test_a_plan_of_another_format_opens_as_plan_json_and_what_is_none_as_a_picture(tmp_path):
    house = read_plan(PLAN, "home")
    write_scene_json(house, tmp_path / "scene.json")
    write_editor(tmp_path / "scene.json", tmp_path / "editor.html", house_id="home")
    start = block((tmp_path / "editor.html").read_text(encoding="utf-8"), "start")
    again = house_of_plan(start["plan"], "home")
    assert again.rooms == house.rooms and again.doors == house.doors
    Image.new("L", (600, 300), 255).save(tmp_path / "plan.png")
    found = opened(tmp_path / "plan.png", "home")
    assert found["picture"]["width"] == 600
    assert found["notes"] == ["not traced: expected a picture of a floorplan, found an empty page"]


@pytest.mark.parametrize("given", [None, 0.02])
def test_a_picture_lies_underneath(given, tmp_path):
    Image.new("L", (6000, 3000), 255).save(tmp_path / "plan.png")
    out = tmp_path / "editor.html"
    write_editor(tmp_path / "plan.png", out, house_id="home", metres_per_pixel=given, trace=False)
    start = block(out.read_text(encoding="utf-8"), "start")
    picture = start["picture"]
    assert start["scale"]["shown"] * picture["width"] == pytest.approx(6000)
    assert picture["url"].startswith("data:image/png;base64,")
    assert picture["width"] == 2 * picture["height"] <= 6000
    if given:
        assert picture["metres_per_pixel"] * picture["width"] == pytest.approx(6000 * given)
    else:
        assert "metres_per_pixel" not in picture


def test_a_traced_plan_lies_on_its_picture(tmp_path, monkeypatch):
    # A page with a black room of 300 x 200 pixels, seen by the tracer turned by 3 degrees.
    picture = np.full((500, 700, 3), 255, np.uint8)
    picture[150:350, 200:500] = 0
    Image.fromarray(picture).save(tmp_path / "plan.png")
    matrix = cv2.getRotationMatrix2D((350, 250), 3, 0.8)
    frame = Frame(cv2.warpAffine(picture, matrix, (700, 500)), matrix)
    ring = np.array([[200, 150], [500, 150], [500, 350], [200, 350]], float)
    polygon = Polygon(ring @ matrix[:, :2].T + matrix[:, 2])
    room = TracedRoom(1, polygon, "room", "", ("Kitchen",), True, 0.9, ())
    scale = Scale(0.0125, 0.9, "as given")
    plan = TracedPlan(picture, frame, (room,), (), scale, 8.0, 1.0, (0.0, 0.0), 0.9, read=True)
    monkeypatch.setattr("plan2scene_app.tracing.trace.trace_picture", lambda *_, **__: plan)
    found = opened(tmp_path / "plan.png", "home")
    place, scale = found["picture"], found["scale"]
    assert scale["doubt"] == ""
    assert place["metres_per_pixel"] / scale["shown"] == pytest.approx(0.01)  # of the file's pixels
    assert scale["size"] == pytest.approx([310, 215], abs=1)  # the room stands askew
    shown = np.asarray(Image.open(io.BytesIO(picture_bytes(place))).convert("L"))
    corners = np.array(found["plan"]["rooms"][0]["polygon"])
    middle = corners.mean(0)
    for corner in corners:
        for share, colour in ((0.95, 0), (1.05, 255)):
            at = middle + share * (corner - middle)
            column, row = (at - [place["x"], place["z"]]) / place["metres_per_pixel"]
            assert abs(int(shown[round(row), round(column)]) - colour) < 40


def test_only_an_editor_page_is_overwritten(tmp_path):
    out = tmp_path / "editor.html"
    write_editor(None, out, house_id="one")
    write_editor(None, out, house_id="two")
    assert "<h1>two</h1>" in out.read_text(encoding="utf-8")
    out.write_text("<p>mine</p>")
    with pytest.raises(InputError, match="a file of yours"):
        write_editor(None, out, house_id="three")
    assert out.read_text() == "<p>mine</p>"
