import numpy as np
import pytest

from plan2scene import colour as tones
from plan2scene.paint.light import GAINS, estimate_light, house_gains, recoloured, relight
from plan2scene.paint.observations import SurfaceColour

WHITE, GREEN, OAK = (0.83, 0.82, 0.8), (0.35, 0.5, 0.4), (0.3, 0.2, 0.1)


def photo(name, light, *, room="r", ceiling=WHITE, wall=GREEN, floor=OAK):
    return [
        SurfaceColour(name, room, kind, tuple(np.array(value) * np.array(light)))
        for kind, value in {"ceiling": ceiling, "wall": wall, "floor": floor}.items()
        if value is not None
    ]


def error(colour, truth):

    lab = tones.rgb_to_lab(tones.linear_to_srgb(np.clip(np.stack([colour, truth]), 0, 1)))
    return float(tones.delta_e_2000(lab[0], lab[1]))


def chroma(light):
    return np.log(light[0] / light[2])


def test_a_blue_house_does_not_give_blue_walls():
    blue = np.array([0.55, 0.65, 0.9])
    colours = [c for k in range(3) for c in photo(f"p{k}", blue)]
    gains = house_gains(estimate_light(colours), colours)
    lit = np.array(GREEN) * blue * gains["p0"]
    assert error(lit / lit.sum(), np.array(GREEN) / sum(GREEN)) < 3.0
    seen = np.array(GREEN) * blue
    assert error(seen / seen.sum(), np.array(GREEN) / sum(GREEN)) > 8.0


def test_photos_of_one_room_are_brought_nearer_and_those_of_rooms_apart_hardly():
    bright, dark = np.array([0.7, 0.7, 0.7]), np.array([0.5, 0.5, 0.5])
    colours = photo("bright", bright) + photo("dark", dark)
    light = estimate_light(colours)
    apart = np.log(light["bright"] / light["dark"]).mean()
    assert 0.3 * np.log(1.4) < apart < np.log(1.4)
    gains = house_gains(light, colours)
    assert gains["dark"].mean() > gains["bright"].mean()
    # Two rooms that no photo ties: nothing tells light from paint.
    blue, warm = np.array([0.55, 0.65, 0.9]), np.array([0.9, 0.75, 0.55])
    light = estimate_light(photo("blue", blue, room="x") + photo("warm", warm, room="y"))
    assert abs(chroma(light["blue"] / light["warm"])) < 0.4 * abs(chroma(blue / warm))


def test_gains_keep_the_brightest_surfaces_below_the_knee():
    colours = [c for k in range(4) for c in photo(f"p{k}", np.full(3, 0.95))]
    gains = house_gains(estimate_light(colours), colours)
    assert max((np.array(c.colour) * gains[c.photo]).max() for c in colours) <= GAINS.knee + 1e-9
    assert estimate_light([]) == {} and house_gains({}, []) == {}


def test_relight_multiplies_linear_light_and_burns_nothing_out():
    ramp = np.repeat(np.arange(256, dtype=np.uint8)[None, :, None], 3, axis=2)
    gains = np.array([2.5, 1.0, 0.8])
    lit = tones.srgb_to_linear(relight(ramp, gains))
    below = tones.srgb_to_linear(ramp[0, :, 0]) * 2.5 < GAINS.knee
    np.testing.assert_allclose(
        lit[0, below, 0], tones.srgb_to_linear(ramp[0, below, 0]) * 2.5, atol=0.006
    )
    np.testing.assert_allclose(lit[..., 2], tones.srgb_to_linear(ramp[..., 2]) * 0.8, atol=0.006)
    red = relight(ramp, gains)[0, :, 0].astype(int)
    assert (np.diff(red) >= 0).all()
    clipped = tones.CLIPPED_LEVELS[1]
    assert (red[:clipped] <= clipped).all() and red[200] < clipped
    assert relight(ramp, np.ones(3)) is ramp


@pytest.mark.parametrize("own_green", [0.0, 0.005])
def test_a_red_carpet_that_becomes_green_has_no_blotches(own_green):
    """Its green and blue are nearly black, so that they are noise alone."""
    rng = np.random.default_rng(0)
    bright = rng.uniform(0.6, 1.4, (64, 64, 1))
    linear = bright * [0.2, own_green, 0.01] + rng.uniform(-0.004, 0.004, (64, 64, 3))
    tile = tones.as_uint8(tones.linear_to_srgb(np.maximum(linear, 0.0)))
    green = np.array([0.05, 0.2, 0.15])
    painted = tones.srgb_to_linear(recoloured(tile, tones.linear_to_srgb(green)))
    assert np.median(painted, axis=(0, 1)) == pytest.approx(green, rel=0.1)
    assert (painted / painted[..., :1]).std(axis=(0, 1)) == pytest.approx(np.zeros(3), abs=0.1)
    assert np.corrcoef(painted[..., 1].ravel(), bright.ravel())[0, 1] > 0.95
