import cv2
import numpy as np

from plan2scene.paint.shading import unrest
from plan2scene.photos.crops.filter import (
    FILTER,
    has_object,
    image_reasons,
    mark_outvoted,
    restless,
    step_of,
)
from plan2scene.photos.crops.sampling import Candidate, Crop, Reason, Verdict


def plain(seed=0, colour=(190, 180, 165), noise=2.0):
    rng = np.random.default_rng(seed)
    image = np.array(colour, float) + rng.normal(0, noise, (128, 128, 3))
    return np.clip(image, 0, 255).round().astype(np.uint8)


def checker(cell=16, dark=(120, 100, 80)):
    rows, columns = np.indices((128, 128)) // cell
    odd = (rows + columns) % 2
    return np.where(odd[..., None] > 0, np.array(dark), np.array((200, 190, 170))).astype(np.uint8)


def shaded(image, left=0.8, right=1.2):
    return np.clip(image * np.linspace(left, right, 128)[None, :, None], 0, 255).astype(np.uint8)


def test_surfaces_pass():
    for image in (plain(), shaded(plain()), checker(16), checker(32), checker(8, (60, 60, 60))):
        assert image_reasons(image) == []


def test_a_thing_in_the_corner_is_clutter():
    image = plain()
    image[100:, 100:] = (90, 60, 40)
    assert has_object(image)
    speck = plain()
    speck[60:64, 60:64] = (60, 50, 40)
    assert has_object(speck)
    tinted = plain()
    tinted[:, 90:] = np.clip(tinted[:, 90:] * np.array([1.0, 1.0, 0.9]), 0, 255)
    assert has_object(tinted)  # as bright, but of another colour


def test_shadow_edges_and_things_of_another_colour_divide_a_crop():
    image = plain()
    image[:, :60] = (image[:, :60] * 0.75).astype(np.uint8)
    image = cv2.GaussianBlur(image, (0, 0), 3.0)
    assert step_of(image) is Reason.SHADOW
    door = plain()
    door[:, :60] = (130, 80, 40)
    assert step_of(door) is Reason.CLUTTER and step_of(shaded(plain(), 0.75, 1.25)) is None
    assert step_of(checker(32)) is None


def test_planks_of_several_shades_are_no_shadow_but_a_shadow_on_them_is():
    rng = np.random.default_rng(3)
    shade = np.repeat(rng.uniform(0.8, 1.1, 8), 21)[:128]
    grain = cv2.GaussianBlur(rng.normal(0, 1, (128, 128)), (0, 0), sigmaX=1.0, sigmaY=9.0)
    values = np.array((150, 120, 90)) * (shade[None, :] * np.exp(1.2 * grain))[..., None]
    values[:, ::21] *= 0.6
    floor = np.clip(values, 0, 255).astype(np.uint8)
    assert image_reasons(floor, joints=True) == []
    grey = np.repeat(floor.mean(axis=2, keepdims=True), 3, axis=2)
    grey[:, :60] *= 0.35
    assert step_of(grey.astype(np.uint8)) is Reason.SHADOW


def test_joints_of_a_floor_are_no_things():
    floor = plain()
    floor[62:66] = 110
    floor[:70, 40:44] = 110  # a joint that ends at another
    assert image_reasons(floor, joints=True) == []
    assert has_object(floor)  # on a wall it is one
    floor[90:120, 90:110] = (90, 60, 40)
    assert has_object(floor, joints=True)


def test_pictures_beside_a_calm_wall_are_things_and_a_wallpaper_all_round_is_none():
    image = plain(0)
    for row in (8, 72):
        for column in (10, 76):
            image[row : row + 44, column : column + 40] = (80, 50, 30)
            image[row + 8 : row + 36, column + 8 : column + 32] = (230, 215, 120)
    wall, pictures, paper = unrest(plain()), unrest(image), unrest(checker(32))
    assert wall < 1.0 < 10.0 < pictures
    limits = FILTER.restless_wall
    assert restless(np.array([wall, pictures]), *limits).tolist() == [False, True]
    assert not restless(np.array([paper, 0.8 * paper, 1.1 * paper]), *limits).any()
    assert not restless(np.array([pictures]), *limits).any()  # nothing else is known of the wall


def test_a_patterned_rug_beside_a_calm_floor_is_a_thing_and_a_chequered_floor_is_none():
    def reasons(*images):
        seen = [
            Candidate(Crop(0, (0, 0, 1, 1), 1.0, 1.0, 60.0, i), Verdict(), "floor", 0, f"{k}", "r")
            for k, i in enumerate(images)
        ]
        return [candidate.verdict.reasons for candidate in mark_outvoted(seen, {})]

    rug, stone = checker(16, (150, 140, 120)), plain(0, (175, 165, 145))
    assert reasons(rug, stone) == [(Reason.CLUTTER,), ()]
    assert reasons(rug, shaded(rug, 0.95, 1.05)) == [(), ()]
