from dataclasses import replace

import pytest
from box_room import VIEWS, box_house, shot
from masks_folder import write_masks

from plan2scene.house import FROM_PHOTOS, USUAL
from plan2scene_app.heights.ceilings import ceiling_height, measure_ceilings, with_ceilings

DRAWN = replace(with_ceilings(box_house(), 2.8), heights=USUAL)


def shots(height, rooms=("room",)):
    true, lens = with_ceilings(box_house(), height), dict(pitch_deg=4.0, fov_deg=90.0, rooms=rooms)
    return {f"{k}.jpg": shot(true, *view, **lens)[0] for k, view in enumerate(VIEWS[:4])}


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
