from dataclasses import replace

import numpy as np
import pytest

from plan2scene.colour import log_axes
from plan2scene.house import SurfaceKey
from plan2scene.paint.estimate import Observation, PaintPrior, estimate_paint
from plan2scene.paint.observations import SHARES, PlaneColours, write_colours
from plan2scene.paint.surfaces import joined, observations_of, trim_paint
from plan2scene.photos.crops.colours import frame_colours
from plan2scene.photos.labels.palette import OTHER, WALL

WHITE = np.exp(PaintPrior().white[0])


def observed(paints, lights, *, noise=0.0, seed=0):
    """Return what photos in `lights` (name to RGB and rooms) show of `paints`."""
    rng = np.random.default_rng(seed)
    return [
        Observation(
            photo,
            key,
            True,
            0.05,
            tuple(np.array(paint) * light * np.exp(noise * rng.normal(size=3))),
        )
        for photo, (light, rooms) in lights.items()
        for key, paint in paints.items()
        if key.room_id in rooms
    ]


def room(name, wall, floor=(0.3, 0.2, 0.12), ceiling=(WHITE,) * 3):
    return {
        SurfaceKey(name, "floor"): floor,
        SurfaceKey(name, "wall"): wall,
        SurfaceKey(name, "ceiling"): ceiling,
    }


LAMP, SKY, GREY = np.array([0.75, 0.55, 0.33]), np.array([0.4, 0.45, 0.55]), np.full(3, 0.35)


@pytest.mark.parametrize("light", [LAMP, SKY, GREY], ids=["lamp", "sky", "grey"])
def test_white_rooms_are_white_in_any_light(light):
    paints = room("a", (WHITE,) * 3) | room("b", (WHITE,) * 3)
    estimate = estimate_paint(observed(paints, {"1": (light, "a"), "2": (GREY, "b")}, noise=0.03))
    for key in paints:
        if key.surface != "floor":
            assert key in estimate.white
            assert estimate.paint[key] == pytest.approx(np.full(3, WHITE), rel=0.08)


def test_a_carpet_may_be_redder_than_any_other():
    red = (0.12, 0.004, 0.015)
    paints = room("a", (WHITE,) * 3, floor=red)
    estimate = estimate_paint(observed(paints, {"1": (GREY, "a")}, noise=0.02))
    assert estimate.paint[SurfaceKey("a", "floor")] == pytest.approx(red, rel=0.4)


@pytest.mark.parametrize(
    ("floor", "grey"), [((0.4, 0.38, 0.43), True), ((0.3, 0.2, 0.12), False)], ids=["grey", "wood"]
)
def test_a_grey_carpet_that_looks_lilac_is_grey_and_wood_stays_brown(floor, grey):
    paints = room("a", (WHITE,) * 3, floor=floor)
    estimate = estimate_paint(observed(paints, {"1": (GREY, "a")}, noise=0.02))
    off, shown = (
        np.abs(log_axes(np.array(colour))[1:]).max()
        for colour in (estimate.paint[SurfaceKey("a", "floor")], floor)
    )
    assert off < 0.6 * shown if grey else off == pytest.approx(shown, rel=0.2)


@pytest.mark.parametrize(
    ("wall", "light"), [((0.2, 0.3, 0.5), GREY), ((0.45, 0.2, 0.06), LAMP)], ids=["blue", "panels"]
)
def test_a_wall_of_a_colour_below_a_white_ceiling_keeps_it(wall, light):
    paints = room("a", wall) | room("b", (WHITE,) * 3)
    estimate = estimate_paint(observed(paints, {"1": (light, "a"), "2": (LAMP, "b")}, noise=0.02))
    assert estimate.white == {
        SurfaceKey("a", "ceiling"),
        SurfaceKey("b", "ceiling"),
        SurfaceKey("b", "wall"),
    }
    assert estimate.paint[SurfaceKey("a", "wall")] == pytest.approx(wall, rel=0.15)


@pytest.mark.parametrize(("mixed", "white"), [(0.0, False), (0.2, True)])
def test_a_ceiling_in_the_light_of_lamps_is_white_where_light_is_seen_to_be_mixed(mixed, white):
    shown = observed(room("a", (WHITE,) * 3), {"1": (GREY, "a"), "2": (SKY, "a")}, noise=0.02)
    warm = np.exp(0.8 * np.array([0.507, 0.0, -0.862]))
    lit = [
        replace(item, mixed=mixed, colour=tuple(np.array(item.colour) * warm))
        if item.surface.surface == "ceiling"
        else item
        for item in shown
    ]
    assert (SurfaceKey("a", "ceiling") in estimate_paint(lit).white) is white


def test_a_grey_carpet_is_no_blue_one_below_ceilings_that_panelled_walls_tint():
    wood = np.array((0.45, 0.2, 0.06))
    tinted = WHITE * (wood / wood[1]) ** 0.15
    paints = {}
    for name in "abc":
        paints |= room(name, wood, floor=(0.3, 0.3, 0.3), ceiling=tinted)
    shown, _ = joined(observed(paints, {name: (LAMP, name) for name in "abc"}), {})
    red, _, blue = estimate_paint(shown).paint[SurfaceKey("a", "floor")]
    assert blue == pytest.approx(red, rel=0.1)  # .25 without the tint


def test_a_ceiling_that_only_teal_walls_light_is_white():
    teal = np.array((0.03, 0.12, 0.13))
    paints = room("a", teal, ceiling=WHITE * (teal / teal[1]) ** 0.6) | room("b", (WHITE,) * 3)
    shown, _ = joined(observed(paints, {"1": (GREY, "a"), "2": (GREY, "b")}), {})
    assert SurfaceKey("a", "ceiling") in estimate_paint(shown).white
    assert (
        SurfaceKey("a", "ceiling")
        not in estimate_paint(shown, PaintPrior(bounce_deviation=0)).white
    )


def test_light_is_what_the_paint_leaves_and_photos_of_one_room_share_it():
    paints = room("a", (WHITE,) * 3)
    estimate = estimate_paint(observed(paints, {"1": (LAMP, "a"), "2": (GREY, "a")}))
    for name, light in (("1", LAMP), ("2", GREY)):
        assert estimate.light[name] == pytest.approx(light, rel=0.15)
    lights = {"1": (LAMP, "a"), "2": (LAMP, "a"), "3": (SKY, "b")}
    items = observed(room("a", (WHITE,) * 3) | room("b", (WHITE,) * 3), lights)
    estimate = estimate_paint([replace(item, room=item.surface.room_id) for item in items])
    for name, (light, _) in lights.items():
        assert estimate.light[name] == pytest.approx(light, rel=0.1)


def test_exposure_and_order_of_photos_change_no_paint():
    paints = room("a", (0.2, 0.3, 0.5)) | room("b", (WHITE,) * 3)
    lights = {"1": (GREY, "a"), "2": (LAMP, "b")}
    bright = estimate_paint(observed(paints, lights))
    dim = estimate_paint(observed(paints, {k: (0.6 * v, r) for k, (v, r) in lights.items()}))
    assert bright.white == dim.white
    for key in paints:
        assert dim.paint[key] == pytest.approx(bright.paint[key], rel=0.12)
    items = observed(room("a", (0.2, 0.3, 0.5)) | room("b", (WHITE,) * 3), {"1": (GREY, "ab")})
    there, back = estimate_paint(items), estimate_paint(items[::-1])
    assert there.white == back.white
    for key in there.paint:
        assert there.paint[key] == pytest.approx(back.paint[key], rel=1e-6)
    assert not estimate_paint([]).paint


def test_few_pixels_of_another_room_do_not_paint_a_wall():
    paints = room("a", (WHITE,) * 3) | room("b", (WHITE,) * 3)
    items = observed(paints, {"1": (GREY, "a"), "2": (GREY, "b")})
    oak = Observation("2", SurfaceKey("a", "wall"), False, 0.0005, (0.12, 0.06, 0.02))
    assert SurfaceKey("a", "wall") in estimate_paint([*items, oak]).white


@pytest.mark.parametrize(
    ("seen", "far", "kept"), [(0.03, 0.01, 1), (0.001, 0.01, 2), (0.001, 0.001, 1), (0.0, 0.001, 0)]
)
def test_what_is_seen_within_a_room_takes_no_colour_from_another(tmp_path, seen, far, kept):
    def plane(photo, own, weight, colour):
        shares = np.tile(np.array(colour, dtype=np.float32), (SHARES, 1))
        return PlaneColours(photo, ("hall",), "floor", 0, own, (), weight, shares)

    planes = [plane("hall", True, seen, (0.2, 0.01, 0.02)), plane("bed", False, far, (0.3,) * 3)]
    path = tmp_path / "colours.parquet"
    write_colours(path, planes, dataset="d", house_id="h")
    assert len(observations_of(path)) == kept


@pytest.mark.parametrize(
    ("leaf", "white"),
    [((0.2, 0.12, 0.06), False), ((0.3, 0.29, 0.28), True), ((0.45, 0.3, 0.2), True)],
    ids=["oak", "white in the shade", "a warm reflection"],
)
def test_few_pixels_tell_an_oak_leaf_where_one_photo_washes_it_out(leaf, white):
    door, photos = SurfaceKey("hole_0", "door"), ("1", "2")
    lights = {photo: (GREY, "a") for photo in photos}
    leaves = [
        Observation(photo, door, True, 0.001, tuple(np.array(colour) * GREY))
        for photo, colour in zip(photos, (leaf, (0.5, 0.45, 0.4)), strict=True)
    ]
    estimate = estimate_paint(observed(room("a", (WHITE,) * 3), lights) + leaves)
    assert (door in estimate.white) == white


@pytest.mark.parametrize(
    ("frame", "trim"), [((150, 100, 60), True), ((230, 228, 224), False), ((60, 90, 150), False)]
)
def test_trim_is_of_wood_where_frames_of_windows_are(tmp_path, frame, trim):
    labels = np.full((200, 400), WALL, np.uint8)
    labels[50:150, 100:300] = OTHER
    image = np.full((200, 400, 3), 235, np.uint8)
    image[50:150, 100:300] = frame
    image[54:146, 104:296] = 248  # the pane
    shown = frame_colours(image, labels, labels == OTHER, "p", "a")
    path = tmp_path / "colours.parquet"
    write_colours(path, shown, dataset="d", house_id="h")
    assert (trim_paint(path, {"p": np.ones(3)}) is not None) is trim
    assert not observations_of(path)


def test_floors_of_one_material_have_one_paint():
    paints = room("a", (WHITE,) * 3) | room("b", (WHITE,) * 3, floor=(0.1, 0.2, 0.3))
    items = observed(paints, {"1": (GREY, "a"), "2": (LAMP, "b")})
    floors = SurfaceKey("a", "floor"), SurfaceKey("b", "floor")
    one, owner = joined(items, dict.fromkeys(floors, "floor-1"))
    assert owner[floors[1]] == floors[0] and floors[1] not in estimate_paint(one).paint
    assert owner[SurfaceKey("b", "wall")] == SurfaceKey("b", "wall")


def test_grey_walls_are_no_white_ones_in_the_shade():
    grey = (0.22, 0.21, 0.2)
    paints = room("a", grey, floor=(0.6, 0.6, 0.58)) | room("b", (WHITE,) * 3)
    lights = {"1": (0.6 * GREY, "a"), "2": (GREY, "b"), "3": (LAMP, "b")}
    estimate = estimate_paint(observed(paints, lights, noise=0.02))
    assert SurfaceKey("a", "wall") not in estimate.white
    assert estimate.paint[SurfaceKey("a", "wall")] == pytest.approx(grey, rel=0.3)
    assert SurfaceKey("b", "wall") in estimate.white
