import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from flat_picture import PPM, flat_picture
from PIL import Image, ImageDraw
from typer.testing import CliRunner

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.plans.formats import read_plan
from plan2scene_app.cli import app
from plan2scene_app.tracing import lettering, trace
from plan2scene_app.tracing import picture as pictures
from plan2scene_app.tracing.lettering import TextLine, read_lines
from plan2scene_app.tracing.trace import traced_files, write_trace


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "flat.png"
    write_png(path, flat_picture())
    return path


@pytest.fixture
def texts(monkeypatch):
    lines = [
        TextLine("Wohnzimmer", (150.0, 200.0), (80.0, 12.0), 0.99),
        TextLine("20,0 m²", (150.0, 220.0), (60.0, 12.0), 0.99),
        TextLine("Küche 19.4 m2", (350.0, 200.0), (90.0, 12.0), 0.99),
    ]
    monkeypatch.setattr(trace, "reader_installed", lambda: True)
    monkeypatch.setattr(trace, "lines_of", lambda image, told: lines)


def test_a_drawing_becomes_a_plan_by_the_command_the_same_again(picture, texts, tmp_path):
    out, again = tmp_path / "plan.json", tmp_path / "again.json"
    plan, _ = write_trace(picture, out)
    done = CliRunner().invoke(app, ["trace", str(picture), "--out", str(again)])
    assert done.exit_code == 0, done.output
    assert "2 rooms" in done.output and str(again) in done.output
    for one, other in zip(traced_files(out), traced_files(again), strict=True):
        assert one.read_bytes() == other.read_bytes()
    house = read_plan(out, "flat")
    assert [(room.id, room.name, room.types) for room in house.rooms] == [
        ("wohnzimmer", "Wohnzimmer", ("Reception",)),
        ("kuche", "Küche", ("Kitchen",)),
    ]
    areas = {room.id: room.polygon.area * plan.metres**2 for room in plan.rooms}
    assert areas["wohnzimmer"] == pytest.approx(4.06 * 5.12, rel=0.05)
    assert plan.scale.confidence > 0.6
    assert plan.metres * plan.frame.zoom == pytest.approx(1 / PPM, rel=0.02)
    place = json.loads(out.read_text())["picture"]
    assert place["file"] == picture.name and abs(place["turned"]) < 1
    pixels = [np.divide(house.rooms[0].rings[0][k], place["metres_per_pixel"]) for k in (0, 1)]
    corner = plan.in_file(np.array(plan.rooms[0].polygon.exterior.coords[:2]))
    assert pixels + np.array(place["origin"]) == pytest.approx(corner, abs=3)
    assert len([door for door in house.doors if door.room_b is not None]) == 1
    assert all(path.is_file() for path in traced_files(out))
    # What nothing is drawn of reaches the ceiling.
    full = replace(plan, openings=tuple(replace(o, full=True) for o in plan.openings))
    assert {o["top"] for o in trace.plan_document(full)["openings"]} == {house.rooms[0].height}


def test_light_lines_on_dark_paper_are_read_as_dark_ones(texts, tmp_path):
    paper = np.array([20, 40, 90])  # a blueprint's
    picture = (paper + (255 - flat_picture()) / 255 * (255 - paper)).astype(np.uint8)
    write_png(tmp_path / "flat.png", picture)
    plan, _ = write_trace(tmp_path / "flat.png", tmp_path / "plan.json")
    areas = {room.id: room.polygon.area * plan.metres**2 for room in plan.rooms}
    assert set(areas) == {"wohnzimmer", "kuche"}
    assert areas["wohnzimmer"] == pytest.approx(4.06 * 5.12, rel=0.05)
    assert sum(opening.kind == "door" for opening in plan.openings) >= 1
    np.testing.assert_array_equal(plan.picture, picture)  # shown as it is


def test_a_sketch_of_two_large_rooms_without_windows_is_traced(tmp_path):
    image = np.full((350, 500, 3), 255, np.uint8)
    cv2.rectangle(image, (40, 40), (460, 310), (0, 0, 0), -1)
    for corners in ((50, 50, 249, 299), (256, 50, 449, 299), (249, 100, 256, 145)):
        cv2.rectangle(image, corners[:2], corners[2:], (255, 255, 255), -1)
    cv2.rectangle(image, (100, 300), (145, 311), (255, 255, 255), -1)
    write_png(tmp_path / "sketch.png", image)
    plan, _ = write_trace(tmp_path / "sketch.png", tmp_path / "plan.json")
    assert len(plan.rooms) == 2 and any(opening.other for opening in plan.openings)


def test_without_a_reader_the_scale_is_a_guess_that_is_said(picture, monkeypatch, tmp_path):
    monkeypatch.setattr(trace, "reader_installed", lambda: False)
    _, lines = write_trace(picture, tmp_path / "plan.json")
    assert any("a guess" in line and "--metres-per-pixel" in line for line in lines)
    assert any("[trace]'" in line for line in lines)


def test_text_is_read(tmp_path):
    pytest.importorskip("rapidocr")
    image = np.full((200, 500, 3), 255, np.uint8)
    cv2.putText(image, "Bedroom", (60, 80), cv2.FONT_HERSHEY_SIMPLEX, 1, (0, 0, 0), 2)
    cv2.putText(image, "14.5 m2", (280, 160), cv2.FONT_HERSHEY_SIMPLEX, 1, (0, 0, 0), 2)
    found = {line.text.replace(" ", ""): line for line in read_lines(image)}
    assert set(found) == {"Bedroom", "14.5m2"}
    assert found["Bedroom"].middle == pytest.approx((120, 70), abs=12)
    assert not found["Bedroom"].upright
    alone = np.full((300, 400, 3), 255, np.uint8)
    cv2.line(alone, (20, 150), (380, 150), (0, 0, 0), 4)
    assert read_lines(alone) == []  # a picture without text is no letter as large as itself


@pytest.mark.parametrize("turns", [1, -1])
def test_text_of_a_turned_plan_is_read(turns, monkeypatch):
    pytest.importorskip("rapidocr")
    small = replace(lettering.SETTINGS, text_px=(700, 700))  # reads in a third of the time
    monkeypatch.setattr(lettering, "SETTINGS", small)
    image = np.full((520, 240, 3), 255, np.uint8)
    for text, y in (("OH", 50), ("Kitchen", 200), ("MH", 350), ("WC", 500)):
        cv2.putText(image, text, (30, y), cv2.FONT_HERSHEY_SIMPLEX, 1.2, (0, 0, 0), 2)
    found = {line.text: line for line in read_lines(np.ascontiguousarray(np.rot90(image, turns)))}
    assert set(found) == {"OH", "Kitchen", "MH", "WC"} and found["Kitchen"].upright
    x, y = found["OH"].middle
    assert (y if turns == -1 else 240 - y) == pytest.approx(60, abs=15)
    assert (520 - x if turns == -1 else x) == pytest.approx(38, abs=15)
    if turns == 1:
        assert "OH" in {line.text for line in read_lines(image)}  # upside down it is HO


def _noise(height=400, width=600):
    small = np.random.default_rng(0).integers(0, 256, (height // 20, width // 20, 3), np.uint8)
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)


def _letter():
    image = np.full((260, 500, 3), 255, np.uint8)
    for row in range(5):
        text = "This is a page of text alone"
        cv2.putText(image, text, (30, 60 + 45 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (0, 0, 0), 1)
    return image


@pytest.mark.parametrize(
    ("image", "found"),
    [
        (np.full((300, 400, 3), 255, np.uint8), "an empty page"),
        (np.full((50, 400, 3), 255, np.uint8), "400x50"),
        (_noise(), "a photo ("),
        (_letter(), "no room that walls close"),
    ],
    ids=["empty", "small", "photo", "text"],
)
def test_what_is_no_plan_is_one_line(tmp_path, monkeypatch, image, found):
    if image.shape[0] == 260:  # letters alone: they are read, and painted over
        pytest.importorskip("rapidocr")
    else:
        monkeypatch.setattr(trace, "reader_installed", lambda: False)
    path = tmp_path / "other.png"
    write_png(path, image)
    with pytest.raises(InputError) as caught:
        write_trace(path, tmp_path / "plan.json")
    assert found in str(caught.value) and "\n" not in str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == ["other.png"]


def test_blank_paper_is_cut_before_a_large_picture_is_made_smaller(tmp_path):
    page = Image.new("1", (12_000, 9_000), 1)
    ImageDraw.Draw(page).rectangle((6000, 2000, 9999, 3999), outline=0, width=60)
    page.save(tmp_path / "small.png")
    found = pictures.read_plan_picture(tmp_path / "small.png")
    assert found.shrunk == 3  # 6 with all the paper
    left = (6000 - 240, 2000 - 240)  # a fiftieth of the longer side is left
    assert found.corner == pytest.approx(left, abs=6)
    rows, columns = np.nonzero(found.image.max(2) < 60)
    for axis, places in enumerate((columns, rows)):
        ends = np.array([places.min(), places.max() + 1]) * found.shrunk + found.corner[axis]
        assert ends == pytest.approx([(6000, 10_000), (2000, 4000)][axis], abs=5)


def test_walls_drawn_as_two_lines_part_the_same_rooms(tmp_path, monkeypatch):
    monkeypatch.setattr(trace, "lines_of", lambda image, told: [])
    page = flat_picture().repeat(2, 0).repeat(2, 1)
    page[cv2.erode((page.max(2) < 60).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0] = 255
    write_png(tmp_path / "flat.png", page)
    plan = trace.trace_picture(tmp_path / "flat.png")
    assert len(plan.rooms) == 2
    assert sorted(opening.kind for opening in plan.openings) == ["door", "door", "window"]
