from dataclasses import replace

import numpy as np
import pytest
from box_room import SIZE, box_house, rendered
from masks_folder import write_masks
from views import camera_looking

from plan2scene.house import FROM_PHOTOS, USUAL
from plan2scene.photos.camera.calibration import canonical
from plan2scene.photos.locate.locate_photos import Shot
from plan2scene_app.heights.ceilings import ceiling_height, measure_ceilings, with_ceilings

VIEWS = [
    (230.0, (0.6, 1.5, 2.9)),
    (60.0, (4.2, 1.3, 0.7)),
    (-80.0, (1.4, 1.6, 1.2)),
    (140.0, (4.4, 1.4, 2.8)),
]
FOCAL = SIZE[1] / 2 / np.tan(np.radians(90.0) / 2)
DRAWN = replace(with_ceilings(box_house(), 2.8), heights=USUAL)


def shots(height, rooms=("room",)):
    true, every = with_ceilings(box_house(), height), {}
    for number, (heading, eye) in enumerate(VIEWS):
        camera = camera_looking(SIZE, heading_deg=heading, pitch_deg=4.0, focal=FOCAL)
        labels = rendered(true, camera, np.array(eye))
        every[f"{number}.jpg"] = Shot(camera.with_rotation(canonical(camera.matrix)), labels, rooms)
    return every


@pytest.mark.parametrize("height", [2.3, 2.5, 2.75, 3.1])
def test_photos_tell_the_height(height):
    assert ceiling_height(DRAWN, shots(height)) == pytest.approx(height, abs=0.09)


def test_rooms_need_not_be_told_and_photos_without_a_camera_tell_nothing():
    every = shots(2.3, ("room", "store"))
    found = ceiling_height(DRAWN, every)
    assert found == pytest.approx(2.3, abs=0.09)
    assert ceiling_height(DRAWN, every, threads=2) == found
    every = {
        name: replace(shot, camera=replace(shot.camera, fallback=True))
        for name, shot in shots(2.3).items()
    }
    assert ceiling_height(DRAWN, every) is None


def test_a_plan_that_tells_its_heights_keeps_them(tmp_path):
    photos = shots(2.3)
    cameras = {name: shot.camera.to_json() for name, shot in photos.items()}
    write_masks(tmp_path, {name[0]: shot.labels for name, shot in photos.items()}, cameras)
    table = {name: ["room"] for name in photos}
    told = with_ceilings(box_house(), 2.8)
    assert measure_ceilings(told, table, tmp_path) is told
    found = measure_ceilings(DRAWN, table, tmp_path)
    assert found.heights == FROM_PHOTOS
    assert {room.height for room in found.rooms} == {wall.height for wall in found.walls}
    assert found.rooms[0].height == pytest.approx(2.3, abs=0.09)
