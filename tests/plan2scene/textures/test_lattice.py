import cv2
import numpy as np
import pytest

from plan2scene.textures.exemplar.lattice import grain, grains_of, one_way
from plan2scene.textures.exemplar.make import ExemplarCrop, make_exemplar
from plan2scene.textures.exemplar.things import oddness


def planks(seed, width=32):
    rng = np.random.default_rng(seed)
    fine = cv2.GaussianBlur(rng.normal(0, 1, (128, 128)), (0, 0), sigmaX=1.0, sigmaY=9.0)
    values = np.array((150, 120, 90)) * np.exp(1.0 * fine)[..., None]
    values[:, seed % width :: width] *= 0.5
    return np.clip(values, 0, 255).astype(np.uint8)


def luma(image):
    return np.log(image.mean(axis=2) + 4.0)


NOTHING = np.zeros((128, 128), bool)


def test_an_exemplar_of_planks_seen_from_two_sides_runs_one_way():
    images = [planks(k) for k in range(5)] + [np.rot90(planks(k)) for k in (7, 9)]
    flat = np.stack(images) / 255.0
    masks = np.zeros(flat.shape[:3], bool)
    grains = grains_of(np.stack([luma(255 * image) for image in flat]), masks)
    straight, masks, _ = one_way(flat, masks, grains)
    assert all(grain(luma(255 * image), NOTHING) < -0.4 for image in straight)
    assert masks.shape == flat.shape[:3]
    made = make_exemplar([ExemplarCrop(i, 0.8, 1.0) for i in images], size_px=128)
    assert made is not None and grain(luma(made.image), NOTHING) < -0.3


def plaster(seed, *, switch=False):
    rng = np.random.default_rng(seed)
    values = np.full((128, 128, 3), 170.0) + rng.normal(0, 2, (128, 128, 1))
    if switch:
        values[60:64, 60:64] = 90
    return np.clip(values, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(("shown", "odd"), [(3, True), (8, False)])
def test_crops_that_show_a_switch_are_odd_unless_all_do(shown, odd):
    images = [plaster(k, switch=k < shown) for k in range(8)]
    lumas = np.stack([luma(image) for image in images])
    found = oddness(lumas, np.zeros(lumas.shape, bool))
    assert (found[:shown] > 0.3).all() == odd and not found[shown:].any()
    made = make_exemplar([ExemplarCrop(i, 0.5, 1.0) for i in images], size_px=128)
    assert made is not None and (int(made.image.min()) > 130) == odd
