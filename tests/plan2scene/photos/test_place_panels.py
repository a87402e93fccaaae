"""The panels that show where a photo was taken agree with its pose."""

import cv2
import numpy as np
from box_room import DEEP, SIZE, WIDE, box_house, rendered
from views import camera_looking

from plan2scene.photos.contact_sheet.panels import (
    DOOR_INK,
    FRUSTUM,
    OWN_ROOM,
    WINDOW_INK,
    edges_panel,
    plan_panel,
)
from plan2scene.photos.labels.palette import DOOR
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.pose import Pose

EYE = (1.0, 1.5, 1.8)
SHAPES = room_shapes(box_house())


def pose():
    camera = camera_looking(SIZE, heading_deg=-100.0, pitch_deg=6.0, focal=150.0)
    return Pose("room", EYE, camera, 0.9)


def pixels_of(picture, colour):
    """Rows and columns of a colour."""
    return np.argwhere((picture == colour).all(axis=-1))


def test_the_plan_shows_the_eye_where_it_is():
    picture = plan_panel(SHAPES, pose(), (200, 300))
    room = pixels_of(picture, OWN_ROOM)
    top, left = room.min(axis=0)
    bottom, right = room.max(axis=0)
    row, column = pixels_of(picture, FRUSTUM).mean(axis=0)
    assert abs((column - left) / (right - left) - EYE[0] / WIDE) < 0.03
    assert abs((row - top) / (bottom - top) - EYE[2] / DEEP) < 0.05


def test_the_plan_of_a_photo_that_is_not_located_has_no_frustum():
    picture = plan_panel(SHAPES, None, (200, 300))
    assert len(pixels_of(picture, DOOR_INK))
    assert len(pixels_of(picture, WINDOW_INK))
    assert not len(pixels_of(picture, FRUSTUM))
    assert not len(pixels_of(picture, OWN_ROOM))


def test_the_edges_lie_on_the_borders_of_the_door():
    here = pose()
    labels = rendered(box_house(), here.camera, np.array(EYE))
    assert (labels == DOOR).mean() > 0.02
    picture = edges_panel(np.full((*SIZE, 3), 120, np.uint8), here, SHAPES)
    drawn = pixels_of(picture, DOOR_INK)
    door = (labels == DOOR).astype(np.uint8)
    border = cv2.morphologyEx(door, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8)) > 0
    assert len(drawn) > 30
    assert border[drawn[:, 0], drawn[:, 1]].mean() > 0.95
