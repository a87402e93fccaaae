import colorsys

import numpy as np
import pytest
import torch

from plan2scene import colour
from plan2scene.textures.model import hsv as hsv_space


def to_torch(image):
    return torch.from_numpy(image).permute(2, 0, 1)[None]


def to_numpy(image):
    return image[0].permute(1, 2, 0).numpy()


def test_hsv_is_the_standard_library_s_and_comes_back():
    rgb = np.random.default_rng(0).random((9, 7, 3)).astype(np.float32)
    rgb[0, 0] = 0.0
    rgb[0, 1] = 1.0
    rgb[0, 2] = 0.4
    rgb[0, 3] = (1.0, 0.0, 0.0)
    expected = [colorsys.rgb_to_hsv(*pixel) for pixel in rgb.reshape(-1, 3).astype(float)]
    hsv = hsv_space.rgb_to_hsv(to_torch(rgb))
    np.testing.assert_allclose(to_numpy(hsv).reshape(-1, 3), expected, atol=1e-5)
    np.testing.assert_allclose(to_numpy(hsv_space.hsv_to_rgb(hsv)), rgb, atol=1e-6)
    turned = hsv + torch.tensor([1.0, 0.0, 0.0]).view(1, 3, 1, 1)
    np.testing.assert_allclose(to_numpy(hsv_space.hsv_to_rgb(turned)), rgb, atol=1e-5)


def test_median_is_the_lower_of_the_middle_values():
    image = np.array([[[0, 10, 7], [255, 20, 7]], [[10, 30, 7], [20, 40, 7]]], np.uint8)
    np.testing.assert_allclose(colour.median_colour(image) * 255, [10, 20, 7], atol=1e-4)
    torch_median = hsv_space.median_colour(to_torch(colour.as_float(image)))
    np.testing.assert_allclose(torch_median[0] * 255, [10, 20, 7], atol=1e-4)


def test_linear_light_round_trip():
    levels = np.arange(256, dtype=np.uint8)
    linear = colour.srgb_to_linear(levels)
    np.testing.assert_allclose(linear, colour.srgb_to_linear(levels / 255.0), atol=1e-12)
    np.testing.assert_allclose(colour.linear_to_srgb(linear), levels / 255.0, atol=1e-6)
    assert linear[128] == pytest.approx(0.2158605, abs=1e-6)


def test_clipped_share_counts_white_and_black_but_no_strong_colour():
    image = np.full((4, 4, 3), 128, np.uint8)
    image[0] = 255
    image[1, 0] = 0
    image[2] = (255, 20, 20)
    assert colour.clipped_share(image) == 5 / 16
