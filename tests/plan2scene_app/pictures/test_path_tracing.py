from dataclasses import replace

import numpy as np
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.pictures import path_tracing
from plan2scene_app.pictures.room_views import camera_in

pytest.importorskip("embreex")


def test_a_room_is_lit_and_shows_its_floor(gap_house, monkeypatch):
    pytest.importorskip("mitsuba")
    monkeypatch.setattr(path_tracing, "VARIANTS", ("scalar_rgb",))
    monkeypatch.setattr(path_tracing, "SETTINGS", replace(path_tracing.SETTINGS, samples=4))
    mi = path_tracing.load_mitsuba()
    red = TileTexture(png_bytes(np.full((4, 4, 3), (220, 30, 30), np.uint8)), 1.0)
    parts = assemble(gap_house).parts
    scene = path_tracing.TracedScene(mi, gap_house, parts, {SurfaceKey("b", "floor"): red})
    small = camera_in(gap_house, "b", Rays.of(parts)).resized((58, 87))
    picture = scene.draw(small)
    assert picture.shape == (58, 87, 3) and np.isfinite(picture).all()
    low = picture[-12:].reshape(-1, 3).mean(axis=0)
    assert low[0] > 4 * low[1]  # the floor
    assert picture.mean() > 0.02
    np.testing.assert_array_equal(picture, scene.draw(small))


def test_without_mitsuba_a_line_says_so(monkeypatch, caplog):
    monkeypatch.setitem(__import__("sys").modules, "mitsuba", None)
    assert path_tracing.load_mitsuba() is None and "[render]'" in caplog.text
