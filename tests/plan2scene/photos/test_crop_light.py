"""Light of a house's photos: what the estimate recovers, and what it leaves alone."""

import numpy as np
import pytest

from plan2scene.colour import delta_e_2000, rgb_to_lab, srgb_to_linear
from plan2scene.photos.crops.light import (
    MAX_BALANCE,
    MAX_EXPOSURE,
    SurfaceColour,
    estimate_light,
    gains_of,
    relight,
    surface_colours,
)

WHITE, GREEN, OAK = (0.83, 0.82, 0.8), (0.35, 0.5, 0.4), (0.3, 0.2, 0.1)


def photo(name, light, *, room="r", ceiling=WHITE, wall=GREEN, floor=OAK):
    colours = {"ceiling": ceiling, "wall": wall, "floor": floor}
    return [
        SurfaceColour(name, room, kind, tuple(np.array(value) * np.array(light)))
        for kind, value in colours.items()
        if value is not None
    ]


def error(colour, truth):
    from plan2scene.colour import linear_to_srgb

    lab = rgb_to_lab(linear_to_srgb(np.clip(np.stack([colour, truth]), 0, 1)))
    return float(delta_e_2000(lab[0], lab[1]))


def test_a_blue_photo_does_not_give_blue_walls():
    blue, warm = np.array([0.55, 0.65, 0.9]), np.array([0.9, 0.75, 0.55])
    light = estimate_light(photo("blue", blue) + photo("warm", warm))
    for name, true in (("blue", blue), ("warm", warm)):
        gains = gains_of(light[name], white_balance=True, exposure=True)
        assert error(np.array(GREEN) * true * gains, np.array(GREEN)) < 3.0
        assert error(np.array(GREEN) * true, np.array(GREEN)) > 9.0


def test_a_photo_without_ceiling_is_tied_to_others_by_its_wall():
    warm = np.array([0.9, 0.7, 0.45])
    seen = photo("whole", (0.7, 0.7, 0.7))
    alone = photo("part", warm, ceiling=None, floor=None)
    tied = estimate_light(seen + alone)["part"]
    apart = estimate_light(seen + photo("part", warm, room="x", ceiling=None, floor=None))["part"]
    true = warm[0] / warm[2]
    assert abs(np.log(tied[0] / tied[2] / true)) < 0.5 * abs(np.log(apart[0] / apart[2] / true))


def test_one_surface_that_disagrees_is_counted_less():
    truth = np.array([0.7, 0.7, 0.7])
    photos = [p for k in range(4) for p in photo(f"p{k}", truth)]
    odd = photo("odd", truth, wall=(0.6, 0.1, 0.1))  # another room seen through a door
    light = estimate_light(photos + odd)
    # A third of the discrepancy (log 3.5 to log 5) would be a plain mean's share.
    assert np.abs(np.log(light["odd"] / light["p0"])).max() < 0.3


def test_gains_are_bounded_and_switchable():
    light = np.array([1e-3, 0.5, 3.0])
    assert gains_of(light, white_balance=False, exposure=False) == pytest.approx(np.ones(3))
    balance = np.log(gains_of(light, white_balance=True, exposure=False))
    assert balance.mean() == pytest.approx(0.0, abs=1e-12)
    assert balance[0] - balance[1] == pytest.approx(MAX_BALANCE)
    brightness = np.log(gains_of(np.full(3, 0.1), white_balance=True, exposure=True))
    assert brightness == pytest.approx(np.full(3, MAX_EXPOSURE))
    exposure = gains_of(np.array([0.4, 0.5, 0.6]), white_balance=False, exposure=True)
    assert np.ptp(exposure) == pytest.approx(0.0, abs=1e-12)
    assert estimate_light([]) == {}


def test_relight_multiplies_linear_light():
    image = np.random.default_rng(0).integers(20, 150, (16, 16, 3)).astype(np.uint8)
    gains = np.array([1.5, 1.0, 0.8])
    lit = srgb_to_linear(relight(image, gains))
    np.testing.assert_allclose(lit, srgb_to_linear(image) * gains, atol=0.006)
    assert relight(image, np.ones(3)) is image
    assert relight(np.full((4, 4, 3), 250, np.uint8), np.full(3, 2.0)).min() == 255


def test_surface_colours_leave_lamps_and_specks_aside():
    image = np.full((240, 320, 3), 128, np.uint8)
    labels = np.zeros((240, 320), np.uint8)
    labels[:120] = 3
    image[:120] = (180, 170, 160)
    image[20:60, 20:60] = 255
    labels[200:204, 10:14] = 1
    found = surface_colours(image, labels, "a.png", ["r1", "r2"])
    assert {(item.room_id, item.surface) for item in found} == {
        ("r1", "ceiling"),
        ("r2", "ceiling"),
    }
    expected = srgb_to_linear(np.array([180, 170, 160], np.uint8))
    np.testing.assert_allclose(found[0].colour, expected, atol=1e-6)
