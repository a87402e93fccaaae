"""Texture statistics: alike textures are close, others are not."""

import numpy as np
import pytest
import torch

from plan2scene.textures.model import statistics as st


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


def test_distances_have_gradients() -> None:
    target = stripes(8)
    for source in (st.FilterBankStatistics(), st.SpectrumStatistics()):
        image = torch.rand(1, 3, 64, 64).requires_grad_()
        source.distance(image, target).sum().backward()
        assert image.grad is not None
        assert bool(torch.isfinite(image.grad).all())
        assert float(image.grad.abs().sum()) > 0


def test_moments_tell_joints_from_weave() -> None:
    filters = st.FilterBankStatistics()
    joints = torch.full((1, 3, 128, 128), 0.7)
    joints[:, :, ::32] = 0.3
    joints[:, :, :, ::32] = 0.3
    both = st.moments_of(filters.responses(torch.cat([joints, stripes(4, size=128)])))
    named = filters.bank.shape[0] - st._RANDOM_FILTERS
    first = slice(filters.bank.shape[0] + named, filters.bank.shape[0] + 2 * named)
    assert float(both[0, first].max()) > float(both[1, first].max()) + 1.0  # log kurtosis
    assert bool(torch.isfinite(st.moments_of(filters.responses(torch.zeros(1, 3, 128, 128)))).all())


def test_colour_quantiles_of_known_values() -> None:
    ramp = torch.linspace(0.0, 1.0, 64 * 64).view(1, 1, 64, 64).expand(1, 3, 64, 64)
    found = st.colour_quantiles(ramp)[0]
    assert float(found[0]) == pytest.approx(0.5, abs=0.01)
    assert found[1:3].abs().max() < 1e-5
    assert found[3:9].square().tolist() == pytest.approx(
        [0.48, 0.4, 0.25, 0.25, 0.4, 0.48], abs=0.01
    )
    assert (found[3:6] < 0).all() and (found[6:9] > 0).all()


def test_sectors_are_the_same_where_tensors_default_to_meta():
    rows = st.SpectrumStatistics().sectors64
    with torch.device("meta"):
        shape = st.SpectrumStatistics().sectors64
    assert shape.is_meta and shape.shape == rows.shape
    np.testing.assert_allclose(rows.sum(1), 1.0, rtol=1e-5)
