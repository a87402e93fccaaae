from functools import cache

import cv2
import numpy as np
import pytest
from views import camera_looking

from plan2scene.camera import Camera, as_rows
from plan2scene.photos.camera.calibration import canonical, estimate_camera
from plan2scene.photos.camera.exif import ExifFocal
from plan2scene.photos.camera.lines import CAMERA


def rotation_of(heading_deg, pitch_deg, roll_deg):
    r = np.radians(roll_deg)
    bank = np.array([[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]])
    upright = camera_looking((2, 2), heading_deg=heading_deg, pitch_deg=pitch_deg, focal=1.0)
    return bank @ upright.matrix


@cache
def checker_room(pose, fov_deg, size=(480, 640), eye=(0.3, 1.5, -1.2)):
    """Ray-cast checkerboards on the inside of a box (4x supersampled); returns an sRGB photo."""
    box, cell = (4.0, 2.6, 5.0), 0.5
    height, width = size
    focal = width / 2 / np.tan(np.radians(fov_deg) / 2)
    place = (2 * width, 2 * height, 2 * focal, width - 0.5, height - 0.5)
    rays = Camera(*place, as_rows(rotation_of(*pose))).rays_at(*np.indices((2 * height, 2 * width)))
    eye = np.array(eye)
    low = np.array([-box[0] / 2, 0.0, -box[2] / 2])
    high = np.array([box[0] / 2, box[1], box[2] / 2])
    with np.errstate(divide="ignore"):
        reach = np.where(rays > 0, (high - eye) / rays, (low - eye) / rays)
    axis = reach.argmin(axis=-1)
    point = eye + rays * reach.min(axis=-1, keepdims=True)
    cells = np.floor((point - low) / cell + 1e-6).astype(int)
    cells[np.arange(3) == axis[..., None]] = 0
    odd = cells.sum(axis=-1) % 2
    base = np.array([90, 150, 200])[axis]
    grey = np.where(odd, base, base + 40).astype(np.float32)
    grey = cv2.resize(grey, (width, height), interpolation=cv2.INTER_AREA)
    return np.repeat(grey.round().astype(np.uint8)[..., None], 3, axis=2), focal


def angle_deg(a, b):
    """Angle between rotations, degrees, up to the Manhattan frame's quarter turns."""
    turned = canonical(a).T @ canonical(b)
    return float(np.degrees(np.arccos(np.clip((np.trace(turned) - 1) / 2, -1, 1))))


POSES = [
    (30.0, 5.0, 1.0, 60.0),
    (-20.0, 12.0, -2.0, 75.0),
    (40.0, -6.0, 0.0, 85.0),
    (-35.0, 3.0, 3.0, 50.0),
]


@pytest.mark.parametrize(("heading", "pitch", "roll", "fov"), POSES)
def test_rotation_and_focal_of_a_checkered_room(heading, pitch, roll, fov):
    truth = rotation_of(heading, pitch, roll)
    image, focal = checker_room((heading, pitch, roll), fov)
    camera = estimate_camera(image)
    assert not camera.fallback and camera.focal_source == "vanishing_points"
    assert angle_deg(camera.matrix, truth) < 0.5 and abs(camera.focal_px / focal - 1) < 0.02


def test_of_a_one_point_view_exif_tells_the_focal_length():
    truth = rotation_of(0.0, 0.0, 0.0)
    image, _ = checker_room((0.0, 0.0, 0.0), 85.0, eye=(0.0, 1.3, -2.0))
    camera = estimate_camera(image)
    assert not camera.fallback and angle_deg(camera.matrix, truth) < 1.0
    assert camera.confidence < CAMERA.high_confidence
    image, focal = checker_room((0.0, 0.0, 0.0), 70.0, eye=(0.0, 1.3, -2.0))
    camera = estimate_camera(image, exif=ExifFocal(focal))
    assert camera.focal_source == "exif" and camera.focal_px == pytest.approx(focal, abs=1e-3)
    assert angle_deg(camera.matrix, truth) < 0.5
    assert camera.confidence >= CAMERA.high_confidence


def test_exif_goes_before_vanishing_points_unless_they_contradict_it():
    image, focal = checker_room((30.0, 5.0, 1.0), 60.0)
    near = estimate_camera(image, exif=ExifFocal(1.08 * focal))
    assert near.focal_source == "exif"
    assert near.focal_px == pytest.approx(1.08 * focal, abs=1e-3)
    far = estimate_camera(image, exif=ExifFocal(1.5 * focal))
    assert far.focal_source == "vanishing_points" and abs(far.focal_px / focal - 1) < 0.02
    told = estimate_camera(image, exif=ExifFocal(1.5 * focal, told=True))
    assert told.focal_px == pytest.approx(1.5 * focal, abs=1e-3)
    cropped = estimate_camera(image, exif=ExifFocal(1.08 * focal, cropped=True))
    assert cropped.focal_source == "vanishing_points"
    assert abs(cropped.focal_px / focal - 1) < 0.02


def test_no_lines_fall_back_to_the_constant_field_of_view():
    camera = estimate_camera(np.full((120, 160, 3), 128, np.uint8), fov_deg=60.0)
    assert camera.fallback and camera.focal_source == "config" and camera.confidence == 0.0
    assert camera.focal_px == pytest.approx(80 / np.tan(np.radians(30)), abs=1e-3)
    np.testing.assert_array_equal(camera.matrix, np.diag([-1.0, -1.0, 1.0]))
