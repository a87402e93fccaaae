import numpy as np
import pandas as pd
import pytest

from plan2scene.colour import LUMINANCE, linear_to_srgb
from plan2scene.io import write_parquet
from plan2scene.paint.light import expected_colours
from plan2scene.paint.observations import HouseColours, house_colours, matte_colour, usual_colour

GREY = np.full((4, 3, 3), 0.5)


def shown(**seen):
    colours, photos = np.zeros((4, 3, 3)), np.zeros((4, 3))
    for place, value, count in seen.values():
        colours[place], photos[place] = value, count
    return HouseColours(colours, photos)


def test_shadow_and_glare_do_not_move_the_usual_colour():
    floor = np.linspace(0.19, 0.21, 32)
    floor[:4], floor[-3:] = 0.02, 0.9
    shares = np.repeat(floor[:, None], 3, axis=1)
    assert usual_colour([shares], [1.0]) == pytest.approx(np.full(3, 0.2), abs=0.01)
    dark = np.full((32, 3), 0.05)
    assert usual_colour([dark, shares], [1.0, 3.0]) == pytest.approx(np.full(3, 0.2), abs=0.01)
    assert usual_colour([dark, shares], [3.0, 1.0]) == pytest.approx(np.full(3, 0.05), abs=0.01)


def test_glare_and_the_red_shadow_of_a_sofa_do_not_tint_a_floor():
    paint, glare = np.array([0.3, 0.1, 0.05]), np.linspace(-0.2, 0.2, 32).clip(0)
    shown = paint + glare[:, None]
    found = matte_colour([shown, shown], [1.0, 2.0])
    assert found / found[1] == pytest.approx(paint / paint[1])
    assert found @ LUMINANCE == pytest.approx(usual_colour([shown], [1.0]) @ LUMINANCE)
    carpet = np.linspace(0.1, 0.5, 32)[:, None] * np.array([1.0, 1.0, 1.1])
    carpet[:3] = np.array([0.04, 0.01, 0.01])
    found = matte_colour([carpet], [1.0])
    assert found / found[1] == pytest.approx([1.0, 1.0, 1.1])


def test_a_surface_well_seen_keeps_its_colour_and_one_unseen_follows_the_house():
    others = {f"c{k}": ((k, 2), 0.4, 4.0) for k in range(3)}
    well = expected_colours(shown(**others, mine=((3, 2), 0.1, 30.0)), GREY)
    assert well[3, 2] == pytest.approx(linear_to_srgb(np.full(3, 0.1)), abs=0.03)
    glimpse = expected_colours(shown(**others, mine=((3, 2), 0.1, 0.05)), GREY)
    assert glimpse[3, 2] == pytest.approx(linear_to_srgb(np.full(3, 0.4)), abs=0.05)
    unseen = expected_colours(shown(**others), GREY)
    assert unseen[3, 2] == pytest.approx(linear_to_srgb(np.full(3, 0.4)), abs=0.02)
    seen = {"a": ((0, 0), 0.1, 2.0), "b": ((1, 0), 0.3, 1.0), "c": ((1, 1), 0.5, 3.0)}
    every = shown(**seen)
    out = expected_colours(every, GREY, as_if_unseen=True)
    for place, _, _ in seen.values():
        alone = expected_colours(every.without(place), GREY)
        np.testing.assert_allclose(out[place], alone[place], atol=1e-9)
    np.testing.assert_allclose(expected_colours(shown(), GREY), GREY, atol=1e-9)


def test_one_photo_with_much_of_a_surface_does_not_outvote_two(tmp_path):
    def row(photo, weight, grey):
        place = {"photo": photo, "room_id": "hall", "surface": "floor", "plane": 0, "own": True}
        return {**place, "weight": weight, "colours": np.full(96, grey, np.float32).tolist()}

    rows = [row("a.jpg", 0.02, 0.1), row("b.jpg", 0.02, 0.12), row("door.jpg", 0.06, 0.7)]
    write_parquet(tmp_path / "colours.parquet", pd.DataFrame(rows), {})
    found = house_colours(tmp_path / "colours.parquet", set(), ["hall"])
    assert 0.1 <= found.colours[0, 0].mean() <= 0.12
    alone = house_colours(tmp_path / "colours.parquet", {"a.jpg"}, ["hall"])
    assert alone.colours[0, 0] == pytest.approx(np.full(3, 0.7), abs=1e-6)
