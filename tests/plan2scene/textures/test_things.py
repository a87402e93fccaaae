import cv2
import numpy as np

from plan2scene.paint.shading import log_luma
from plan2scene.textures.exemplar.make import ExemplarCrop, make_exemplar
from plan2scene.textures.exemplar.things import things

SIZE = 128


def plaster(seed):
    grain = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, (SIZE, SIZE)), (0, 0), 2.0)
    return np.clip(190 + 12 * grain[..., None] * np.ones(3), 0, 255).astype(np.uint8)


def with_switch(image, corner=(40, 50)):
    shown = image.copy()
    row, column = corner
    cv2.rectangle(shown, (column, row), (column + 14, row + 20), (90, 90, 90), 2)
    cv2.rectangle(shown, (column + 5, row + 7), (column + 9, row + 13), (40, 40, 40), -1)
    return shown


def found(image):
    return things(log_luma(image[None] / 255.0), np.zeros((1, SIZE, SIZE), bool))[0]


def test_a_switch_is_found_and_a_plain_surface_tiled_without_it():
    mask = found(with_switch(plaster(0)))
    assert mask[40:61, 50:65].all() and mask.mean() < 0.08 and not found(plaster(0)).any()
    crops = [ExemplarCrop(with_switch(plaster(k), (30 + 5 * k, 40)), 0.8, 1.0) for k in range(4)]
    kept = make_exemplar(crops, size_px=SIZE)
    plain = make_exemplar(crops, size_px=SIZE, plain=True)
    assert kept is not None and plain is not None
    assert kept.image.min() < 100 and plain.image.min() > 140
