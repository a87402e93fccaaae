"""Texture statistics: alike textures are close, others are not; VGG-19 loads and pads by one."""

import itertools

import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.textures import statistics as st


def stripes(period: float, angle: float = 0.0, size: int = 64, shift: float = 0.0) -> torch.Tensor:
    y, x = np.mgrid[:size, :size]
    along = np.cos(angle) * x + np.sin(angle) * y + shift
    wave = 0.5 + 0.2 * np.sin(2 * np.pi * along / period)
    image = np.stack([wave, 0.8 * wave, 0.6 * wave])
    return torch.from_numpy(image[None].astype(np.float32))


def test_gram_of_known_features() -> None:
    features = torch.tensor([[[[1.0, 2.0]], [[0.0, 4.0]]]])
    assert st.gram(features).tolist() == [[[2.5, 4.0], [4.0, 8.0]]]


def test_filters_have_zero_mean_and_unit_norm() -> None:
    bank = st.FilterBankStatistics().bank
    assert bank.flatten(2).sum(2).abs().max() < 1e-5
    np.testing.assert_allclose(bank.flatten(1).norm(dim=1), 1.0, atol=1e-5)


def test_distance_is_zero_to_itself_and_ignores_shifts_on_the_torus() -> None:
    filters = st.FilterBankStatistics(periodic=True)
    image = torch.rand(2, 3, 64, 64, generator=torch.Generator().manual_seed(0))
    assert filters.distance(image, image).max() < 0.01
    assert filters.distance(torch.roll(image, (16, 32), (2, 3)), image).max() < 0.01


@pytest.mark.parametrize("source", [st.FilterBankStatistics(), st.SpectrumStatistics()])
def test_other_patterns_are_farther_than_shifted_ones(source) -> None:
    base = stripes(8)
    shifted = float(source.distance(stripes(8, shift=3.0), base))
    turned = float(source.distance(stripes(8, angle=np.pi / 2), base))
    wider = float(source.distance(stripes(16), base))
    assert shifted < 0.5 * turned
    assert shifted < 0.5 * wider


def test_flat_images_do_not_blow_up() -> None:
    flat = torch.full((1, 3, 64, 64), 0.5)
    noisy = flat + 0.002 * torch.randn(flat.shape, generator=torch.Generator().manual_seed(1))
    assert float(st.FilterBankStatistics().distance(noisy, flat)) < 0.2


def test_colour_distance_is_the_shift_of_the_distribution() -> None:
    image = torch.rand(1, 3, 16, 16) * 0.5
    assert float(st.colour_distance(image, image.flip(3))) == 0.0
    # RGB and luminance move by 0.1 (halved for luminance), the two opponent colours not at all.
    moved = st.colour_distance(image + 0.1, image)
    assert float(moved) == pytest.approx((3 * 0.1 + 0.05) / 6, abs=1e-5)


def test_distances_have_gradients() -> None:
    target = stripes(8)
    for source in (st.FilterBankStatistics(), st.SpectrumStatistics()):
        image = torch.rand(1, 3, 64, 64).requires_grad_()
        source.distance(image, target).sum().backward()
        assert image.grad is not None
        assert bool(torch.isfinite(image.grad).all())
        assert float(image.grad.abs().sum()) > 0


@pytest.fixture(scope="module")
def vgg_file(tmp_path_factory):
    """Random weights under torchvision's names."""
    torch.manual_seed(0)
    shapes = {}
    channels, index = 3, 0
    for outputs in st._VGG19:
        if outputs == "pool":
            index += 1
            continue
        shapes[f"features.{index}.weight"] = (outputs, channels, 3, 3)
        shapes[f"features.{index}.bias"] = (outputs,)
        channels, index = outputs, index + 2
    state = {name: torch.randn(shape) * 0.05 for name, shape in shapes.items()}
    path = tmp_path_factory.mktemp("vgg") / "vgg19.pth"
    torch.save(state, path)
    return path


def test_vgg_taps_and_circular_padding(vgg_file) -> None:
    vgg = st.load_statistics("pretrained", vgg_file)
    image = torch.rand(1, 3, 32, 32)
    assert [g.shape[1] for g in vgg.grams(image)] == [64, 128, 256, 512, 512]
    for mine, theirs in itertools.islice(
        zip(vgg.grams(torch.roll(image, (16, 16), (2, 3))), vgg.grams(image), strict=True), 5
    ):
        np.testing.assert_allclose(mine, theirs, rtol=1e-3, atol=1e-5)
    assert float(vgg.distance(image, image)) == 0.0
    assert float(vgg.distance(image.flip(1), image)) > 0.0


def test_vgg_weights_of_another_shape_are_refused(vgg_file, tmp_path) -> None:
    state = torch.load(vgg_file, weights_only=True)
    del state["features.28.weight"]
    torch.save(state, tmp_path / "bad.pth")
    with pytest.raises(InputError, match=r"features\.28\.weight"):
        st.VggStatistics(tmp_path / "bad.pth")
    (tmp_path / "text.pth").write_text("no weights")
    with pytest.raises(InputError, match=r"text\.pth"):
        st.VggStatistics(tmp_path / "text.pth")


def test_unknown_source_is_refused() -> None:
    with pytest.raises(InputError, match="resnet"):
        st.load_statistics("resnet")
    with pytest.raises(InputError, match="with a file"):
        st.load_statistics("pretrained")
