from dataclasses import replace

import cv2
import numpy as np
import pytest

import plan2scene.photos.patterns.units as units_module
from plan2scene.house import Door, House, Room
from plan2scene.materials import bonds, random_material
from plan2scene.photos.patterns.bonds import LAID, Zigzag
from plan2scene.photos.patterns.find import FoundPattern, find_pattern
from plan2scene.photos.patterns.house_patterns import boarded, continued, floor_patterns
from plan2scene.photos.patterns.joints import JOINTS, directions, evened
from plan2scene.photos.patterns.views import FloorView, of_one_colour, with_usual_height

SIDE_M = 2.4


SIZE_PX = round(SIDE_M * JOINTS.px_per_m)


def floor(columns, rows, offset, seed):
    return made_of(bonds.bond(SIZE_PX, columns, rows, SIDE_M, (np.arange(rows) * offset)), seed)


def made_of(layout, seed, *, turned=False, joint=0.2):
    """Return units of random tones with dark joints of 3 mm; grain is `turned` with its unit."""
    size = layout.key.shape[0]
    rng = np.random.default_rng(seed)
    grain = cv2.GaussianBlur(rng.normal(0, 0.3, (size, size)), (0, 0), sigmaX=12, sigmaY=1)
    grain = layout.lookup(rng, grain.astype(np.float32)) if turned else grain
    value = 0.5 + layout.draw(rng, 0.02) + grain - joint * layout.joint(0.003)
    return np.repeat(value[..., None], 3, axis=2)


def view(image, angle, *, scale=1.0, room="hall"):
    """Return a view of a floor turned by an angle, under uneven light, with noise."""
    side = image.shape[0]
    turn = cv2.getRotationMatrix2D((side / 2, side / 2), -angle, scale)
    light = np.linspace(0.6, 1.2, side)[:, None, None]
    noise = np.random.default_rng(int(angle)).normal(0, 0.01, image.shape)
    seen = cv2.warpAffine(image, turn, (side, side), borderMode=cv2.BORDER_REFLECT) * light + noise
    mask = np.zeros((side, side), np.uint8)
    cv2.circle(mask, (side // 2, side // 2), round(0.45 * side), 1, -1)
    shown = np.rint(255 * np.clip(seen, 0, 1)).astype(np.uint8)
    found = directions(*evened(shown, mask > 0))
    return FloorView(f"{room}{angle}.jpg", (room,), True, shown, mask > 0, found)


@pytest.mark.parametrize(("columns", "rows", "offset"), [(4, 16, 0.5), (8, 8, 0.0), (4, 8, 0.0)])
def test_size_kind_and_direction_are_those_of_the_floor(columns, rows, offset):
    image = floor(columns, rows, offset, seed=1)
    found, _ = find_pattern([view(image, 25.0), view(image, 25.5, scale=1.03)])
    assert found.kind == ("planks" if rows > 2 * columns else "tiles")
    assert found.width_m == pytest.approx(SIDE_M / rows, rel=0.04)
    assert found.length_m == pytest.approx(SIDE_M / columns, rel=0.04)
    assert found.direction_deg == pytest.approx(25.0, abs=1.5)
    assert abs((found.offset - offset + 0.5) % 1.0 - 0.5) < 0.08 and found.confidence > 0.6


@pytest.mark.parametrize(("looks", "kind"), [((0.8, 0.1), "planks"), ((0.1, 0.8), "tiles")])
def test_looks_part_planks_from_tiles_of_one_shape(looks, kind):
    image = floor(12, 24, 0.5, seed=1)
    found, _ = find_pattern([view(image, 25.0), view(image, 25.5)], looks)
    assert found.kind == kind and np.isnan(found.length_m) == (kind == "planks")


@pytest.mark.parametrize(("looks", "kind"), [((0.8, 0.1), "planks"), ((0.05, 0.6), "plain")])
def test_stripes_without_ends_are_planks_on_wood_and_shadows_on_other_floors(looks, kind):
    y = np.arange(SIZE_PX) / JOINTS.px_per_m
    stripes = 0.5 + 0.2 * ((y % 0.17) < 0.05)[:, None] * np.ones(SIZE_PX)
    image = np.repeat(stripes[..., None], 3, axis=2)
    found, _ = find_pattern([view(image, 25.0), view(image, 25.5)], looks)
    assert found.kind == kind


def test_wood_whose_joints_hardly_show_has_planks_all_the_same():
    layout = bonds.bond(SIZE_PX, 2, 28, SIDE_M, np.random.default_rng(1).uniform(0, 1, 28))
    image = made_of(layout, seed=3, turned=True, joint=0.07)
    found, _ = find_pattern([view(image, 30.0), view(image, 31.0)])
    assert found.kind == "planks" and found.width_m == pytest.approx(SIDE_M / 28, rel=0.05)
    assert found.confidence < 0.99


@pytest.mark.parametrize(("substance", "kind"), [("carpet", "cut"), ("plaster", "concrete")])
def test_what_has_no_joints_has_no_pattern(substance, kind):
    material = random_material(substance, 1, kind=kind, size_px=512)
    image = cv2.resize(material.albedo / 255.0, (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_AREA)
    seen = view(image, 10.0)
    found, _ = find_pattern([seen], looks=(0.2, 0.1))
    assert found.kind == "plain" and found.confidence > 0.6
    # What looks like wood, or is seen on few pixels, may well have joints.
    assert find_pattern([seen], looks=(0.5, 0.45))[0].confidence < 0.5
    assert find_pattern([replace(seen, px_per_m=90.0)])[0].confidence < 0.5


def slanting(zigzag, seed, joint=0.2):
    y, x = np.mgrid[:SIZE_PX, :SIZE_PX] / JOINTS.px_per_m
    number, u, v, edge = (np.asarray(part) for part in zigzag.planks(x, y))
    key = (number[..., 0] * 7919 + number[..., 1] * 104729) % 8192
    layout = bonds.Layout(key, u, v, edge.astype(np.float32), SIDE_M)
    return made_of(layout, seed, turned=True, joint=joint)


def zigzags():
    sizes = ((0.06, 0.3), (0.09, 0.45), (0.12, 0.6))
    usual = [Zigzag(kind, *size) for kind in ("herringbone", "chevron") for size in sizes]
    return [*usual, Zigzag("chevron", 0.09, 0.5, 60.0)]


@pytest.mark.parametrize("true", zigzags(), ids=str)
def test_planks_in_columns_have_their_size_direction_and_units(true):
    image = slanting(true, seed=4)
    (found, units) = floor_patterns([view(image, 20.0), view(image, 20.5)], {}, {})["hall"]
    assert found.kind == true.kind and found.width_m == pytest.approx(true.width_m, rel=0.05)
    assert found.length_m == pytest.approx(true.length_m, rel=0.05)
    assert found.direction_deg == pytest.approx(20.0, abs=1.5)
    assert found.slant_deg == pytest.approx(true.slant_deg, abs=1.5)
    assert len(units.images) > 12
    assert np.median([(unit.mean(axis=2) < 90).mean() for unit in units.images]) < 0.03


def test_columns_are_found_by_the_slant_of_their_grain_without_joints():
    image = slanting(Zigzag("herringbone", 0.09, 0.45), seed=4, joint=0.0)
    found, _ = find_pattern([view(image, 20.0)])
    assert found.kind == "herringbone" and found.length_m == pytest.approx(0.45, rel=0.08)


def test_a_period_in_one_photo_is_no_multiple_in_another():
    image = floor(4, 24, 0.37, seed=1)
    scales = (0.85, 1.0, 1.1, 1.35)
    found, _ = find_pattern([view(image, 20.0 + k, scale=s) for k, s in enumerate(scales)])
    assert (found.kind, found.width_m) == ("planks", pytest.approx(0.105, rel=0.15))


def test_a_piece_of_another_colour_is_no_part_of_a_floor():
    image = np.full((200, 400, 3), (150, 110, 80), np.uint8)
    image[:, 250:] = (150, 150, 200)
    mask = np.zeros(image.shape[:2], bool)
    mask[20:180, 20:200] = mask[20:180, 210:240] = mask[50:150, 260:380] = True
    image[:, 205:245] = image[:, 205:245] // 4 * 3  # in shade
    assert np.array_equal(of_one_colour(image, mask), mask & (np.arange(400) < 250))


def test_a_basket_is_not_taken_for_rows_or_columns():
    image = made_of(bonds.basket(SIZE_PX, 6, 5, SIDE_M), seed=4, turned=True)
    assert find_pattern([view(image, 0.0)])[0].kind not in LAID


def test_veins_that_repeat_from_tile_to_tile_do_not_hide_that_they_are_tiles():
    side = round(0.4 * JOINTS.px_per_m)
    veins = cv2.GaussianBlur(np.random.default_rng(6).normal(0, 1.0, (side, side)), (0, 0), 4)
    image = 0.5 + np.tile(veins, (6, 6))[..., None] * np.ones(3)
    image[::side] -= 0.05
    image[:, ::side] -= 0.05
    found, _ = find_pattern([view(image, 10.0)])
    assert found.kind == "tiles"
    assert (found.width_m, found.length_m) == pytest.approx((0.4, 0.4), rel=0.03)


def test_a_small_view_of_clear_joints_is_believed():
    small = view(floor(16, 32, 0.5, seed=1), 10.0)
    middle = SIZE_PX // 2
    mask = np.zeros_like(small.mask)
    mask[middle - 70 : middle + 70, middle - 70 : middle + 70] = True
    shown = replace(small, mask=mask, directions=directions(*evened(small.image, mask)))
    found, _ = find_pattern([shown])
    assert found.kind == "tiles" and shown.square_m < 0.5
    assert found.width_m == pytest.approx(SIDE_M / 32, rel=0.06)


def test_photos_whose_height_is_off_do_not_set_the_size():
    image = floor(4, 16, 0.5, seed=1)
    # All photos are from 1.5 m; three are taken for such from 1.8 m: planks look 20 % wider there.
    right = replace(view(image, 25.0), camera_m=1.5)
    off = [
        replace(view(image, 20.0 + k, scale=1.2), camera_m=1.8, photo=f"{k}.jpg") for k in range(3)
    ]
    elsewhere = [replace(right, photo=f"other {k}.jpg") for k in range(4)]
    views = with_usual_height([right, *off, *elsewhere])[:4]
    assert find_pattern(views)[0].width_m == pytest.approx(0.15, rel=0.03)
    assert find_pattern([right, *off])[0].width_m > 0.17


def test_a_room_of_the_material_has_its_size_and_keeps_its_own_direction():
    planks = floor(4, 16, 0.5, seed=2)
    views = [view(planks, 0.0, room="hall"), view(planks, 90.0, scale=1.06, room="bedroom")]
    views += [view(planks, 1.0, room="hall"), view(planks, 91.0, scale=1.06, room="bedroom")]
    pairs = floor_patterns(views, {"hall": "floor-1", "bedroom": "floor-1"}, {})
    found = {room: pattern for room, (pattern, _) in pairs.items()}
    assert found["bedroom"].width_m == found["hall"].width_m == pytest.approx(0.15, rel=0.04)
    assert found["bedroom"].direction_deg == pytest.approx(90.0, abs=1.5)
    assert min(found["hall"].direction_deg, 180 - found["hall"].direction_deg) < 1.5


def test_units_are_whole_and_without_joints():
    image = floor(4, 16, 0.5, seed=3)
    (_, units) = floor_patterns([view(image, 0.0), view(image, 30.0)], {}, {})["hall"]
    assert len(units.images) > 12
    for unit in units.images:
        assert unit.shape[:2] == pytest.approx((30, 120), abs=4)
    assert np.median([(unit.mean(axis=2) < 100).mean() for unit in units.images]) < 0.01
    assert units.joint_m * units.joint.mean() == pytest.approx(0.003 * 0.4, rel=0.5)


def test_light_joints_are_laid_between_tiles_but_not_between_boards_of_any_length():
    tiles, of_tiles = floor_patterns([view(1.0 - floor(4, 16, 0.5, seed=3), 0.0)], {}, {})["hall"]
    assert tiles.line == "light" and of_tiles.joint.mean() < -0.2
    layout = bonds.bond(SIZE_PX, 1, 28, SIDE_M, np.random.default_rng(1).uniform(0, 1, 28))
    shining = made_of(layout, seed=3, turned=True, joint=-0.15)
    boards, of_boards = floor_patterns([view(shining, 0.0)], {}, {})["hall"]
    assert boards.line == "light" and np.isnan(boards.length_m)
    assert of_boards.images and of_boards.joint.tolist() == [0, 0, 0]


def test_of_many_units_the_most_usual_are_laid(monkeypatch):
    image = floor(4, 16, 0.5, seed=3)
    blots = np.random.default_rng(3).normal(0, 1.0, image.shape[:2])
    blots = cv2.GaussianBlur(blots, (0, 0), 5)
    blots *= np.linspace(0, 0.04, len(image))[:, None] / blots.std()
    views = [view(image + blots[..., None], 30.0 * k) for k in range(3)]
    spreads = {}
    for most in (20, 1000):
        monkeypatch.setattr(units_module, "UNITS", replace(units_module.UNITS, most=most))
        (_, units) = floor_patterns(views, {}, {})["hall"]
        spreads[most] = np.std([unit.std() for unit in units.images])
        assert len(units.images) == most or (most == 1000 and len(units.images) > 20)
    assert spreads[20] < 0.5 * spreads[1000]


def test_a_floor_that_no_crop_shows_runs_on_from_its_neighbours():
    outline = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    types = dict(closet="Closet", bath="Bathroom", hall="Hall", store="Closet", den="Den")
    rooms = tuple(Room(name, (kind,), (outline,), 2.5) for name, kind in types.items())
    doors = (("closet", "hall"), ("bath", "hall"), ("store", "hall"), ("store", "den"))
    plan = House("h", rooms, (), tuple(Door(a, "", b) for a, b in doors))
    patterns = {"hall": FoundPattern("planks", 0.15), "den": FoundPattern("plain")}
    assert continued(plan, {"hall", "den"}, patterns) == {"closet": "hall"}
    patterns["den"] = FoundPattern("planks", 0.16)
    assert continued(plan, {"hall", "den"}, patterns) == {"closet": "hall", "store": "den"}
    patterns["den"] = FoundPattern("planks", 0.2)
    assert continued(plan, {"hall", "den"}, patterns) == {"closet": "hall"}
    # What the closet shows too little of to have a crop tells the kind, not the size.
    patterns["closet"] = FoundPattern("planks", 0.05)
    assert continued(plan, {"hall", "den"}, patterns) == {"closet": "hall"}
    patterns["closet"] = FoundPattern("tiles", 0.3)
    assert continued(plan, {"hall", "den"}, patterns) == {}


@pytest.mark.parametrize(
    ("confidence", "shares", "wood"), [(0.2, (0.6, 0.2), True), (0.5, (0.6, 0.2), False)]
)
def test_a_floor_of_wood_whose_photos_are_too_poor_for_joints_is_not_seen(confidence, shares, wood):
    plain = FoundPattern("plain", confidence=confidence)
    assert boarded(plain, shares) is wood
    assert not boarded(plain, (0.2, 0.6)) and not boarded(plain, None)
    assert not boarded(FoundPattern("planks", 0.15), shares)
