"""VGG-19's statistics load and wrap around; the loss of a training can be made of them."""

import itertools

import numpy as np
import pytest
import torch

from plan2scene_workshop.texture import vgg_statistics as vs


@pytest.fixture(scope="module")
def vgg_file(tmp_path_factory):
    """Random weights under torchvision's names."""
    torch.manual_seed(0)
    shapes, channels = {}, 3
    places = (0, 2, 5, 7, 10, 12, 14, 16, 19, 21, 23, 25, 28)
    widths = (64,) * 2 + (128,) * 2 + (256,) * 4 + (512,) * 5
    for index, outputs in zip(places, widths, strict=True):
        shapes[f"features.{index}.weight"] = (outputs, channels, 3, 3)
        shapes[f"features.{index}.bias"] = (outputs,)
        channels = outputs
    state = {name: torch.randn(shape) * 0.05 for name, shape in shapes.items()}
    path = tmp_path_factory.mktemp("vgg") / "vgg19.pth"
    torch.save(state, path)
    return path


def test_vgg_taps_and_circular_padding(vgg_file) -> None:
    vgg = vs.load_statistics("pretrained", vgg_file)
    image = torch.rand(1, 3, 32, 32)
    assert [g.shape[1] for g in vgg.grams(image)] == [64, 128, 256, 512, 512]
    for mine, theirs in itertools.islice(
        zip(vgg.grams(torch.roll(image, (16, 16), (2, 3))), vgg.grams(image), strict=True), 5
    ):
        np.testing.assert_allclose(mine, theirs, rtol=1e-3, atol=1e-5)
    assert float(vgg.distance(image, image)) == 0.0
    assert float(vgg.distance(image.flip(1), image)) > 0.0
