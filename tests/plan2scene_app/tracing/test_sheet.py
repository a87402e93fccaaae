import json

import cv2
import numpy as np
import pytest
from flat_picture import PPM, flat_picture

from plan2scene.images import write_png
from plan2scene_app.tracing import trace
from plan2scene_app.tracing.sheet import find_sheet, in_even_light
from plan2scene_app.tracing.trace import write_trace

PHOTO = (900, 1200)


def photographed(page, pitch, yaw, roll, focal=0.75):
    """Return a photo (h, w, 3) of a page on a table, and the page's corners (4, 2) in it."""
    height, width = PHOTO
    high, wide = page.shape[:2]
    size = np.array([[-wide, -high], [wide, -high], [wide, high], [-wide, high]]) / (2 * wide)
    turn = cv2.Rodrigues(np.radians([[pitch], [yaw], [0.0]]))[0]
    turn = cv2.Rodrigues(np.radians([[0.0], [0.0], [roll]]))[0] @ turn
    points = np.c_[size, np.zeros(4)] @ turn.T + [0, 0, 1.2]
    corners = points[:, :2] / points[:, 2:] * focal * width + [width / 2, height / 2]
    own = np.array([[0, 0], [wide, 0], [wide, high], [0, high]], np.float32)
    move = cv2.getPerspectiveTransform(own, corners.astype(np.float32))
    table = np.full((height, width, 3), (70, 60, 50), np.uint8)
    photo = cv2.warpPerspective(
        page, move, (width, height), table, cv2.INTER_AREA, cv2.BORDER_TRANSPARENT
    )
    light = np.linspace(0.6, 1.0, width)[None, :, None] * [1.0, 0.97, 0.9]
    noise = np.random.default_rng(0).normal(0, 2, photo.shape)
    return np.clip(photo * light + noise, 0, 255).astype(np.uint8), corners


@pytest.mark.parametrize("tilt", [(0, 0, 3), (20, -10, 4), (-25, 5, -8), (5, 25, 0)])
def test_a_photographed_sheet_is_seen_from_above_in_even_light(tilt):
    page = flat_picture()
    photo, corners = photographed(page, *tilt)
    sheet = find_sheet(photo)
    off = np.linalg.norm(sheet.corners - corners, axis=1)
    assert (off < 0.015 * PHOTO[1]).all()  # a thin edge is cut off
    assert sheet.size[0] / sheet.size[1] == pytest.approx(page.shape[1] / page.shape[0], rel=0.03)
    flat = cv2.resize(sheet.straightened(photo), page.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert flat[10:30, 10:-10].min() > 235
    assert np.median(flat[round(0.9 * PPM), round(1.2 * PPM) : round(5 * PPM)], axis=0).max() < 40
    larger = sheet.enlarged(2.0)
    assert larger.size == (2 * sheet.size[0], 2 * sheet.size[1])
    assert larger.corners + 0.5 == pytest.approx(2 * (sheet.corners + 0.5))


def test_a_page_without_edges_gets_even_light():
    page = cv2.resize(flat_picture(), None, fx=2, fy=2)
    rows, columns = (np.linspace(0, 1, side) for side in page.shape[:2])
    light = (0.55 + 0.3 * columns[None] + 0.1 * rows[:, None])[..., None] * [1.0, 0.95, 0.85]
    even = in_even_light((page * light).astype(np.uint8))
    assert even[(page == 255).all(axis=2)].min() > 245 and even[(page == 0).all(axis=2)].max() < 6
    room = cv2.GaussianBlur(
        np.random.default_rng(0).integers(0, 256, page.shape, np.uint8), (0, 0), 9
    )
    for other in (page, 255 - page, room):
        assert in_even_light(other) is other


def test_the_bars_of_a_screenshot_are_cut_off():
    screen = np.full((600, 700, 3), 30, np.uint8)
    screen[100:450, 120:620] = flat_picture()
    sheet = find_sheet(screen)
    true = np.array([[120, 100], [619, 100], [619, 449], [120, 449]])
    assert sheet.corners == pytest.approx(true, abs=5)
    assert sheet.size[0] / sheet.size[1] == pytest.approx(500 / 350, rel=0.02)


def test_pictures_without_a_sheet_stay_as_they_are():
    flat = flat_picture()
    framed = flat.copy()
    cv2.rectangle(framed, (0, 0), (flat.shape[1] - 1, flat.shape[0] - 1), (0, 0, 0), 3)
    round_table = np.full((400, 600, 3), 40, np.uint8)
    cv2.circle(round_table, (300, 200), 190, (250, 250, 250), -1)
    noise = np.random.default_rng(0).integers(0, 256, (300, 400, 3), np.uint8)
    empty = np.full((300, 300, 3), 255, np.uint8)
    strip = np.full((200, 900, 3), 40, np.uint8)
    strip[40:160, 60:840] = 250
    panels = np.full((400, 1100, 3), 90, np.uint8)  # two storeys on a dark page
    panels[25:375, 25:525] = flat
    panels[50:295, 600:950] = cv2.resize(flat, (350, 245))
    blueprint = np.full((400, 500, 3), 60, np.uint8)
    cv2.rectangle(blueprint, (60, 50), (440, 350), (240, 240, 240), 16)
    plans = (flat, 255 - flat, blueprint, framed, panels)
    for picture in (*plans, round_table, noise, empty, 0 * empty, strip):
        assert find_sheet(picture) is None


def test_a_photo_of_a_plan_becomes_the_same_plan(tmp_path, monkeypatch):
    monkeypatch.setattr(trace, "reader_installed", lambda: False)
    page = cv2.resize(flat_picture(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    photo, corners = photographed(page, 18, -8, 3)
    write_png(tmp_path / "photo.png", photo)
    plan, lines = write_trace(tmp_path / "photo.png", tmp_path / "plan.json")
    assert any("straightened" in line for line in lines)
    areas = [room.polygon.area for room in plan.rooms]
    assert len(areas) == 2 and areas[0] / areas[1] == pytest.approx(4.06 / 3.94, rel=0.05)
    assert sorted(o.kind for o in plan.openings) == ["door", "door", "window"]
    place = json.loads((tmp_path / "plan.json").read_text())["picture"]
    width, height = place["sheet"]["size"]
    own = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    back = cv2.getPerspectiveTransform(own, np.array(place["sheet"]["corners"], np.float32))
    seen = cv2.perspectiveTransform(np.array([[place["origin"]]]), back)[0, 0]
    drawn = np.array([[0, 0], [10, 0], [10, 7], [0, 7]], np.float32)
    move = cv2.getPerspectiveTransform(drawn, corners.astype(np.float32))
    true = cv2.perspectiveTransform(np.array([[[0.9, 0.9]]]), move)[0, 0]
    assert seen == pytest.approx(true, abs=6)
