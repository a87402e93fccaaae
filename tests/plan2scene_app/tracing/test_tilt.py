import cv2
import numpy as np
import pytest
from flat_picture import PPM, flat_picture

from plan2scene.images import write_png
from plan2scene_app.tracing.picture import read_plan_picture
from plan2scene_app.tracing.sheet import SHEET
from plan2scene_app.tracing.tilt import find_tilt

HOUSE = np.array([[0.8, 0.8], [9.2, 0.8], [9.2, 6.2], [0.8, 6.2]]) * PPM  # corners of its walls
SIZE = (1200, 900)


def seen_from_aside(page, degrees):  # a photo of a large page's middle, the house's corners in it
    edge = max(page.shape[:2])
    large = cv2.copyMakeBorder(page, edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=(255,) * 3)
    high, wide = large.shape[:2]
    x, y, z = np.radians(degrees)
    turn = cv2.Rodrigues(np.array([x, y, 0.0]))[0] @ cv2.Rodrigues(np.array([0.0, 0.0, z]))[0]

    def place(points):
        flat = (points - [wide / 2, high / 2]) / edge
        rays = np.c_[flat, np.full(len(flat), 0.0)] @ turn.T + [0, 0, 0.85]
        return rays[:, :2] / rays[:, 2:] * SHEET.focal * SIZE[0] + np.array(SIZE) / 2

    own = np.array([[0, 0], [wide, 0], [wide, high], [0, high]], np.float32)
    move = cv2.getPerspectiveTransform(own, place(own).astype(np.float32))
    photo = cv2.warpPerspective(large, move, SIZE, flags=cv2.INTER_AREA, borderValue=(255,) * 3)
    light = np.linspace(0.6, 0.95, SIZE[0])[None, :, None]
    return (photo * light).astype(np.uint8), place(HOUSE + edge)


def sides(corners):
    return np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)


@pytest.mark.parametrize("degrees", [(12, 0, 0), (0, -9, 3), (8, 6, -5)])
def test_the_page_is_seen_from_above(degrees, tmp_path):
    photo, corners = seen_from_aside(flat_picture(), degrees)
    sheet = find_tilt(photo)
    found = cv2.perspectiveTransform(corners[None], np.linalg.inv(sheet.to_picture))[0]
    usual = sides(HOUSE) / sides(HOUSE).mean()
    assert sides(found) / sides(found).mean() == pytest.approx(usual, rel=0.02)
    directions = np.roll(found, -1, axis=0) - found
    angles = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))
    assert (angles + 45) % 90 - 45 == pytest.approx(0, abs=0.5)
    write_png(tmp_path / "close.png", photo)
    picture = read_plan_picture(tmp_path / "close.png")
    assert picture.sheet is not None and picture.image[:5].min() > 240  # white paper around it


def test_a_page_seen_from_above_or_without_lines_stays():
    photo, _ = seen_from_aside(flat_picture(), (0, 0, 4))
    assert find_tilt(photo) is None
    assert find_tilt(np.full((300, 300, 3), 255, np.uint8)) is None
