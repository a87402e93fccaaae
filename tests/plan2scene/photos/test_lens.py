from dataclasses import replace

import pytest

from plan2scene.camera import Camera
from plan2scene.photos.camera.lens import lenses_of, with_shared_lenses

KNOWN = Camera(
    *(1600, 1200, 800.0, 799.5, 599.5),
    rotation=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    focal_source="vanishing_points",
    confidence=0.97,
)


def told(name, exif):
    """What a photo whose own lines say nothing is estimated as."""
    source = "config" if exif.cropped else "exif"
    return replace(KNOWN, focal_px=exif.focal_px, focal_source=source, confidence=0.4)


def test_the_lens_of_most_photos_is_found_and_a_second_one():
    wide, tele = [0.50, 0.51, 0.49, 0.505], [0.80, 0.81, 0.79]
    assert lenses_of(wide) == pytest.approx([0.5025])
    assert lenses_of([*wide, *tele, 1.2]) == pytest.approx([0.5025, 0.80])
    assert lenses_of([0.4, 0.5, 0.6, 0.8, 1.0]) == []
    assert lenses_of([*tele, 0.3, 0.4, 0.5, 0.6]) == []


def test_unsure_photos_get_the_lens_of_the_others_or_their_median():
    cameras = {n: replace(KNOWN, focal_px=f) for n, f in zip("abc", (800, 810, 805), strict=True)}
    lost = replace(KNOWN, focal_px=1385.6, focal_source="config", confidence=0.1)
    cameras["lost"] = lost
    cameras["portrait"] = replace(lost, width=1200, height=1600)
    cameras["other model"] = lost
    cameras["zoomed"] = replace(KNOWN, focal_px=1500.0, confidence=0.6)
    models = dict.fromkeys(cameras, "phone") | {"other model": "camera"}
    made = with_shared_lenses(cameras, models, told)
    for name in ("lost", "portrait"):
        assert made[name].focal_px == pytest.approx(805.0)
        assert made[name].focal_source == "shared"
    for name in ("a", "other model", "zoomed"):
        assert made[name] == cameras[name]
    cameras = {n: replace(KNOWN, focal_px=f) for n, f in zip("abc", (600, 800, 1100), strict=True)}
    cameras["lost"] = replace(KNOWN, focal_px=1385.6, focal_source="config", confidence=0.1)
    made = with_shared_lenses(cameras, dict.fromkeys(cameras, ""), told)
    assert (made["lost"].focal_px, made["lost"].focal_source) == (800.0, "config")
