"""What colours planes of photos show, and what is read of them."""

import numpy as np
import pytest
from views import camera_looking

from plan2scene.colour import srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.paint.observations import (
    SHARES,
    equal_shares,
    read_colours,
    relit,
    write_colours,
)
from plan2scene.photos.crops.colours import colours_of_photo, surface_colours
from plan2scene.photos.crops.filter import strong_edges
from plan2scene.photos.planes.planes import PhotoPlane, Plane

SIZE = (120, 160)


def floor_plane(mask):
    return Plane("floor", 0, (0.0, 1.0, 0.0), -1.5, mask, "plan")


def test_shares_are_equal_parts_by_weight_from_dark_to_bright():
    linear = np.repeat(np.linspace(0.0, 1.0, 320)[::-1, None], 3, axis=1)
    even = equal_shares(linear, np.ones(320))
    expected = np.linspace(0, 1, 320).reshape(SHARES, 10).mean(axis=1)
    np.testing.assert_allclose(even[:, 0], expected, atol=1e-6)
    heavy = equal_shares(linear, np.where(linear[:, 0] > 0.5, 9.0, 1.0))
    assert (heavy[:, 0] > 0.5).mean() == pytest.approx(0.9, abs=0.05)
    # One pixel that weighs nearly all fills the shares that others leave empty.
    lone = equal_shares(np.array([[0.1] * 3, [0.7] * 3]), np.array([1e-9, 1.0]))
    assert (lone > 0.69).mean() > 0.95


def test_steep_views_count_more_and_lamps_not_at_all():
    camera = camera_looking(SIZE, heading_deg=0.0, pitch_deg=35.0, focal=110.0)
    mask = np.zeros(SIZE, bool)
    mask[70:] = True
    image = np.full((*SIZE, 3), 90, np.uint8)
    image[70:85] = 255
    (seen,) = colours_of_photo(
        image, camera, [PhotoPlane(("a", "b"), floor_plane(mask))], "p.jpg", [mask]
    )
    assert seen.rooms == ("a", "b") and seen.colours.max() < 0.12
    flat = camera_looking(SIZE, heading_deg=0.0, pitch_deg=5.0, focal=110.0)
    (far,) = colours_of_photo(image, flat, [PhotoPlane(("a",), floor_plane(mask))], "p.jpg", [mask])
    assert far.weight < 2 * seen.weight  # one room has all of it
    speck = np.zeros(SIZE, bool)
    speck[:5, :5] = True
    planes = [PhotoPlane(("a",), floor_plane(speck))]
    assert colours_of_photo(image, camera, planes, "p.jpg", [speck]) == []


def test_colours_of_hidden_photos_are_not_read(tmp_path):
    camera = camera_looking(SIZE, heading_deg=0.0, pitch_deg=35.0, focal=110.0)
    mask = np.zeros(SIZE, bool)
    mask[60:] = True
    image = np.full((*SIZE, 3), 128, np.uint8)
    planes = [PhotoPlane(("a", "b"), floor_plane(mask))]
    seen = [
        item
        for photo in ("p.jpg", "q.jpg")
        for item in colours_of_photo(image, camera, planes, photo, [mask])
    ]
    half = relit(seen, {"q.jpg": np.array([0.5, 1.0, 9.0])})
    write_colours(
        tmp_path / "colours.parquet", half, dataset="d", house_id="h", colours="corrected"
    )
    found, one_light = read_colours(tmp_path / "colours.parquet", ["p.jpg"])
    assert one_light
    assert set(found) == {SurfaceKey("a", "floor"), SurfaceKey("b", "floor")}
    ((photo, weight, colours),) = found[SurfaceKey("a", "floor")]
    assert photo == "q.jpg" and weight == seen[0].weight
    np.testing.assert_allclose(colours[:, 0], seen[0].colours[:, 0] / 2, atol=1e-6)
    np.testing.assert_allclose(colours[:, 2], 1.0)
    write_colours(tmp_path / "colours.parquet", [], dataset="d", house_id="h")
    assert read_colours(tmp_path / "colours.parquet", []) == ({}, False)


def test_surface_colours_leave_lamps_and_specks_aside():
    image = np.full((240, 320, 3), 128, np.uint8)
    labels = np.zeros((240, 320), np.uint8)
    labels[:120] = 3
    image[:120] = (180, 170, 160)
    image[20:60, 20:60] = 255
    labels[200:204, 10:14] = 1
    found = surface_colours(image, labels, "a.png", ["r1", "r2"], strong_edges(image))
    assert {(item.room_id, item.surface) for item in found} == {
        ("r1", "ceiling"),
        ("r2", "ceiling"),
    }
    expected = srgb_to_linear(np.array([180, 170, 160], np.uint8))
    np.testing.assert_allclose(found[0].colour, expected, atol=1e-6)
