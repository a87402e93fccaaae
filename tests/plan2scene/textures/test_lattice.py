"""Directions of crops: planks of photos taken in different directions run one way."""

import cv2
import numpy as np
import pytest

from plan2scene.paint.shading import flatten
from plan2scene.textures.exemplar.lattice import faintness, grain, grains_of, one_way, quarter_turns
from plan2scene.textures.exemplar.make import ExemplarCrop, blur_octaves, make_exemplar, sharper
from plan2scene.textures.exemplar.things import oddness


def planks(seed: int, width: int = 32) -> np.ndarray:
    """Planks along y, (128, 128, 3) uint8."""
    rng = np.random.default_rng(seed)
    fine = cv2.GaussianBlur(rng.normal(0, 1, (128, 128)), (0, 0), sigmaX=1.0, sigmaY=9.0)
    values = np.array((150, 120, 90)) * np.exp(1.0 * fine)[..., None]
    values[:, seed % width :: width] *= 0.5
    return np.clip(values, 0, 255).astype(np.uint8)


def luma(image: np.ndarray) -> np.ndarray:
    return np.log(image.mean(axis=2) + 4.0)


NOTHING = np.zeros((128, 128), bool)


def test_planks_run_along_an_axis_and_checkers_along_none() -> None:
    assert grain(luma(planks(0)), NOTHING) < -0.4
    assert grain(luma(np.rot90(planks(0))), NOTHING) > 0.4
    rows, columns = np.indices((128, 128)) // 20
    checker = np.where((rows + columns)[..., None] % 2, 90, 180) + np.zeros(3)
    assert abs(grain(luma(checker), NOTHING)) < 0.1
    assert grain(np.zeros((128, 128)), NOTHING) == 0.0


def test_masked_pixels_have_no_say() -> None:
    image = planks(0)
    image[::8, :64] = 255
    mask = NOTHING.copy()
    mask[:, :64] = True
    assert grain(luma(image), mask) < -0.4


@pytest.mark.parametrize(
    ("grains", "turned"),
    [
        ([0.7, 0.6, -0.6, 0.1], [False, False, True, False]),
        ([-0.7, -0.6, 0.6], [False, False, True]),
        ([0.05, -0.1, 0.7, 0.02], [False] * 4),
        ([], []),
    ],
)
def test_the_fewer_are_turned_where_most_have_a_direction(grains, turned) -> None:
    assert quarter_turns(np.array(grains)).tolist() == turned


def test_an_exemplar_of_planks_seen_from_two_sides_runs_one_way() -> None:
    images = [planks(k) for k in range(5)] + [np.rot90(planks(k)) for k in (7, 9)]
    flat = np.stack(images) / 255.0
    masks = np.zeros(flat.shape[:3], bool)
    grains = grains_of(np.stack([luma(255 * image) for image in flat]), masks)
    straight, masks, _ = one_way(flat, masks, grains)
    assert all(grain(luma(255 * image), NOTHING) < -0.4 for image in straight)
    assert masks.shape == flat.shape[:3]
    made = make_exemplar([ExemplarCrop(i, 0.8, 1.0) for i in images], size_px=128)
    assert made is not None
    assert grain(luma(made.image), NOTHING) < -0.3


def test_far_blurrier_crops_are_left_out_where_others_are_sharp() -> None:
    sharp = [ExemplarCrop(planks(k), 0.5, 0.8) for k in range(3)]
    poor = ExemplarCrop(planks(4), 1.0, 0.4)
    np.testing.assert_allclose(blur_octaves([*sharp, poor]), [0, 0, 0, 2])
    assert sharper([*sharp, poor]) == sharp
    assert sharper([*sharp[:2], poor]) == [*sharp[:2], poor]
    unknown = ExemplarCrop(planks(5), float("nan"), float("nan"))
    assert sharper([*sharp, unknown]) == [*sharp, unknown]
    assert blur_octaves([unknown, unknown]).tolist() == [0, 0]


def faded(image: np.ndarray, share: float) -> np.ndarray:
    """An image with that share of its contrast, as under a gleam."""
    middle = np.median(image.reshape(-1, 3), axis=0)
    return np.clip(middle + share * (image - middle), 0, 255).astype(np.uint8)


def test_planks_that_hardly_show_under_a_gleam_are_the_last_to_be_used() -> None:
    clear = [planks(k) for k in range(5)]
    images = [*clear, *(faded(planks(k), 0.25) for k in range(5, 8))]
    lumas = np.stack([luma(image) for image in images])
    masks = np.zeros(lumas.shape, bool)
    faint = faintness(lumas, masks, grains_of(lumas, masks))
    assert faint[5:].min() > 1.0 > 0.3 > faint[:5].max()
    made = make_exemplar([ExemplarCrop(i, 0.5, 1.0) for i in images[::-1]], size_px=128)
    assert made is not None and set(made.crops) >= {3, 4, 5, 6, 7}
    assert not faintness(lumas, masks, np.zeros(len(images))).any()  # no direction: things


def plaster(seed: int, *, switch: bool = False) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = np.full((128, 128, 3), 170.0) + rng.normal(0, 2, (128, 128, 1))
    if switch:
        values[60:64, 60:64] = 90
    return np.clip(values, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(("shown", "odd"), [(3, True), (8, False)])
def test_crops_that_show_a_switch_are_odd_unless_all_do(shown, odd) -> None:
    images = [plaster(k, switch=k < shown) for k in range(8)]
    lumas = np.stack([luma(image) for image in images])
    found = oddness(lumas, np.zeros(lumas.shape, bool))
    assert (found[:shown] > 0.3).all() == odd and not found[shown:].any()
    made = make_exemplar([ExemplarCrop(i, 0.5, 1.0) for i in images], size_px=128)
    assert made is not None
    assert (int(made.image.min()) > 130) == odd


def test_lamp_and_daylight_on_one_wall_are_evened_out() -> None:
    walls = np.stack([plaster(k) for k in range(3)]) / 255.0
    ramp = np.linspace(-0.15, 0.15, 128)
    lit = walls * np.exp(np.stack([ramp, 0 * ramp, -ramp], axis=1))[None, None]
    flat = flatten(np.clip(lit, 0, 1), np.zeros(lit.shape[:3], bool))
    before, after = (np.ptp(np.log(i[..., 0] / i[..., 2]).mean(axis=1)) for i in (lit, flat))
    assert after < 0.25 * before
    np.testing.assert_allclose(np.median(flat, axis=(1, 2)), np.median(lit, axis=(1, 2)), atol=0.01)
